#include "query/words.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <map>
#include <utility>

namespace hgg {
namespace {

/// What an apostrophe leaves behind; "'s" after a noun owns something and says nothing of where.
const std::map<std::string, std::vector<std::string>>& contractions() {
  static const std::map<std::string, std::vector<std::string>> kContractions{
      {"it's", {"it", "is"}},       {"its", {"it", "is"}},      {"that's", {"that", "is"}},
      {"there's", {"there", "is"}}, {"you're", {"you", "are"}}, {"i'm", {"i", "am"}},
      {"isn't", {"is", "not"}},     {"don't", {"do", "not"}},   {"doesn't", {"does", "not"}},
      {"aren't", {"are", "not"}},   {"can't", {"can", "not"}},  {"cannot", {"can", "not"}},
      {"you'll", {"you", "will"}},  {"it'll", {"it", "will"}},  {"what's", {"what", "is"}},
      {"where's", {"where", "is"}}, {"one's", {"one", "is"}},   {"infront", {"in", "front"}},
      {"ontop", {"on", "top"}},     {"nextto", {"next", "to"}}, {"alot", {"a", "lot"}}};
  return kContractions;
}

void addWord(std::vector<std::string>& words, std::string word) {
  while (!word.empty() && word.back() == '\'') {
    word.pop_back();
  }
  if (word.empty()) {
    return;
  }
  if (const auto it = contractions().find(word); it != contractions().end()) {
    words.insert(words.end(), it->second.begin(), it->second.end());
    return;
  }
  if (word.size() > 2 && word.ends_with("'s")) {
    word.resize(word.size() - 2);
  }
  std::erase(word, '\'');
  words.push_back(std::move(word));
}

bool endsWithAny(const std::string& word, std::initializer_list<const char*> endings) {
  return std::ranges::any_of(endings, [&](const char* ending) { return word.ends_with(ending); });
}

}  // namespace

bool isUtf8(std::string_view text) {
  for (std::size_t k = 0; k < text.size();) {
    const auto first = static_cast<std::uint8_t>(text[k]);
    const std::size_t length = first < 0x80                    ? 1
                               : first >= 0xc2 && first < 0xe0 ? 2
                               : first >= 0xe0 && first < 0xf0 ? 3
                               : first >= 0xf0 && first < 0xf5 ? 4
                                                               : 0;
    if (length == 0 || k + length > text.size()) {
      return false;
    }
    for (std::size_t j = 1; j < length; ++j) {
      if ((static_cast<std::uint8_t>(text[k + j]) & 0xc0) != 0x80) {
        return false;
      }
    }
    k += length;
  }
  return true;
}

std::vector<std::string> wordsOf(std::string_view text) {
  std::vector<std::string> words;
  std::string word;
  const auto end = [&] { addWord(words, std::exchange(word, {})); };
  for (std::size_t k = 0; k < text.size(); ++k) {
    const auto c = static_cast<unsigned char>(text[k]);
    if (text.substr(k).starts_with("\xe2\x80\x99")) {  // a typographic apostrophe
      word += '\'', k += 2;
    } else if (std::isalnum(c) != 0 || c >= 0x80 || (c == '\'' && !word.empty())) {
      word += static_cast<char>(std::tolower(c));
    } else {
      end();
      const char separator = c == ',' || c == '(' || c == ')' || c == ':'   ? ','
                             : c == '.' || c == ';' || c == '!' || c == '?' ? '.'
                                                                            : ' ';
      if (separator != ' ' && !words.empty() && words.back() != ".") {
        words.emplace_back(1, separator);
      }
    }
  }
  end();
  return words;
}

std::string singularOf(const std::string& noun) {
  static const std::map<std::string, std::string> kIrregular{
      {"people", "person"},   {"men", "man"},       {"women", "woman"},
      {"children", "child"},  {"shelves", "shelf"}, {"knives", "knife"},
      {"leaves", "leaf"},     {"feet", "foot"},     {"mice", "mouse"},
      {"loaves", "loaf"},     {"scarves", "scarf"}, {"wolves", "wolf"},
      {"halves", "half"},     {"geese", "goose"},   {"lens", "lens"},
      {"shoes", "shoe"},      {"canoes", "canoe"},  {"stairs", "stair"},
      {"clothes", "clothes"}, {"pants", "pants"},   {"bookshelves", "bookshelf"},
      {"glasses", "glass"},   {"buses", "bus"},     {"gas", "gas"},
      {"bus", "bus"},         {"moped", "moped"},   {"torsos", "torso"}};
  if (const auto it = kIrregular.find(noun); it != kIrregular.end()) {
    return it->second;
  }
  const std::size_t n = noun.size();
  if (n < 4 || noun.back() != 's' || endsWithAny(noun, {"ss", "us", "is"})) {
    return noun;
  }
  if (noun.ends_with("ies")) {
    return noun.substr(0, n - 3) + "y";
  }
  if (endsWithAny(noun, {"ches", "shes", "sses", "xes", "zes", "toes"})) {
    return noun.substr(0, n - 2);
  }
  return noun.substr(0, n - 1);
}

int spellingDistance(std::string_view a, std::string_view b, int limit) {
  constexpr std::size_t kLongest = 32;  // letters: longer words are not corrected
  const std::size_t n = a.size(), m = b.size();
  if (n > kLongest || m > kLongest || (n > m ? n - m : m - n) > static_cast<std::size_t>(limit)) {
    return limit + 1;
  }
  std::array<std::array<int, kLongest + 1>, 3> rows{};
  for (std::size_t j = 0; j <= m; ++j) {
    rows[0][j] = static_cast<int>(j);
  }
  for (std::size_t i = 1; i <= n; ++i) {
    auto &row = rows[i % 3], &above = rows[(i + 2) % 3], &before = rows[(i + 1) % 3];
    row[0] = static_cast<int>(i);
    for (std::size_t j = 1; j <= m; ++j) {
      row[j] = std::min({above[j] + 1, row[j - 1] + 1, above[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        row[j] = std::min(row[j], before[j - 2] + 1);
      }
    }
  }
  return std::min(rows[n % 3][m], limit + 1);
}

int toleratedMistakes(std::size_t length) { return length < 5 ? 0 : length < 7 ? 1 : 2; }

std::string joined(const std::vector<std::string>& words) {
  std::string all;
  for (const std::string& word : words) {
    all += word;
  }
  return all;
}

}  // namespace hgg
