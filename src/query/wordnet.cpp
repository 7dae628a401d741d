#include "query/wordnet.h"

#include <algorithm>
#include <charconv>

namespace hgg {

extern const std::string_view kWordnetText;  // generated

namespace {

/// Takes what is before the next separator off the text.
std::string_view take(std::string_view& text, char separator) {
  const std::size_t at = std::min(text.find(separator), text.size());
  const std::string_view part = text.substr(0, at);
  text.remove_prefix(std::min(at + 1, text.size()));
  return part;
}

std::vector<Wordnet::Synset> numbersOf(std::string_view text) {
  std::vector<Wordnet::Synset> numbers;
  while (!text.empty()) {
    const std::string_view part = take(text, ' ');
    Wordnet::Synset number = 0;
    std::from_chars(part.data(), part.data() + part.size(), number);
    numbers.push_back(number);
  }
  return numbers;
}

}  // namespace

Wordnet::Wordnet(std::string_view text) {
  for (std::string_view line = take(text, '\n'); !line.empty(); line = take(text, '\n')) {
    const std::string_view word = take(line, ' ');
    senses_.emplace(word, numbersOf(line));
  }
  while (!text.empty()) {
    std::string_view line = take(text, '\n');
    take(line, ' ');  // its number: they are in order
    above_.push_back(numbersOf(line));
  }
}

const Wordnet& Wordnet::builtin() {
  static const Wordnet kBuiltin(kWordnetText);
  return kBuiltin;
}

const std::vector<Wordnet::Synset>& Wordnet::sensesOf(const std::string& word) const {
  static const std::vector<Synset> kNone;
  const auto it = senses_.find(word);
  return it != senses_.end() ? it->second : kNone;
}

std::optional<int> Wordnet::stepsUp(Synset from, Synset to) const {
  std::vector<Synset> layer{from};
  for (int steps = 0; !layer.empty() && steps < 20; ++steps) {
    std::vector<Synset> next;
    for (const Synset s : layer) {
      if (s == to) {
        return steps;
      }
      const std::vector<Synset>& above = above_[static_cast<std::size_t>(s)];
      next.insert(next.end(), above.begin(), above.end());
    }
    layer = std::move(next);
  }
  return std::nullopt;
}

int Wordnet::depthOf(Synset synset) const {
  int depth = 0;
  for (std::vector<Synset> above = above_[static_cast<std::size_t>(synset)]; !above.empty() && depth < 20; ++depth) {
    above = above_[static_cast<std::size_t>(above.front())];
  }
  return depth;
}

}  // namespace hgg
