#include "query/parse.h"

#include <fmt/format.h>

#include <algorithm>

#include "query/reader.h"
#include "query/words.h"

namespace hgg {
namespace {

constexpr int kMostChoices = 2;  // four readings
/// A text of which less than this share is known words is not English, or no request.
constexpr double kLeastKnown = 0.5;

double shareKnown(const std::vector<Piece>& pieces) {
  double known = 0, all = 0;
  for (const Piece& piece : pieces) {
    if (piece.kind != Piece::Kind::kBreak && piece.kind != Piece::Kind::kStop) {
      const double words = 1.0 + static_cast<double>(std::ranges::count(piece.words, ' '));
      all += words, known += piece.kind == Piece::Kind::kUnknown ? 0 : words;
    }
  }
  return all > 0 ? known / all : 0;
}

/// Whether there is something to find: "the object" alone is anything.
bool namesATarget(const Request& reading) {
  if (reading.target < 0) {
    return false;
  }
  const Phrase& target = reading.phrases[static_cast<std::size_t>(reading.target)];
  return !target.is_any || !target.constraints.empty();
}

}  // namespace

Parse parseText(std::string_view text, const Lexicon& lexicon) {
  if (!isUtf8(text)) {
    return {{}, "the text is not UTF-8"};
  }
  if (text.size() > kMostTextBytes) {
    return {{}, fmt::format("the text has {} bytes; a request has at most {}", text.size(), kMostTextBytes)};
  }
  const std::vector<std::string> words = wordsOf(text);
  if (words.empty()) {
    return {{}, "the text is empty"};
  }
  const std::vector<Piece> pieces = piecesOf(words, lexicon);
  if (shareKnown(pieces) < kLeastKnown) {
    return {{}, "most of its words are not known"};
  }
  Parse parse;
  unsigned count = 1;
  for (unsigned choices = 0; choices < count; ++choices) {
    Request reading = SentenceReader(pieces, choices).read();
    count = 1U << static_cast<unsigned>(std::min(std::max(reading.choices, 0), kMostChoices));
    if (namesATarget(reading)) {
      parse.readings.push_back(std::move(reading));
    }
  }
  if (parse.readings.empty()) {
    parse.reason = "it names nothing to look for";
  }
  return parse;
}

}  // namespace hgg
