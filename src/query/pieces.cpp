#include "query/pieces.h"

namespace hgg {
namespace {

bool isLikePreposition(const std::string& word) {
  return word == "on" || word == "in" || word == "at" || word == "to" || word == "from" || word == "against";
}

}  // namespace

std::vector<Piece> piecesOf(std::span<const std::string> words, const Lexicon& lexicon) {
  std::vector<Piece> pieces;
  const auto text = [&](std::size_t at, std::size_t n) {
    std::string all = words[at];
    for (std::size_t k = 1; k < n; ++k) {
      all += " " + words[at + k];
    }
    return all;
  };
  for (std::size_t at = 0; at < words.size();) {
    if (words[at] == "," || words[at] == ".") {
      pieces.push_back({words[at] == "," ? Piece::Kind::kBreak : Piece::Kind::kStop, words[at], {}, {}});
      ++at;
      continue;
    }
    FoundCue cue = cueAt(words, at);
    const Noun noun = lexicon.nounAt(words, at);
    // "on the left nightstand" is on a nightstand; "on the left" is a place.
    const std::size_t after = at + cue.length;
    if (cue.length > 1 && cue.cue.kind == CueKind::kPlace && isLikePreposition(words[at]) && after < words.size() &&
        cueAt(words, after).length == 0 && lexicon.nounAt(words, after).length > 0) {
      cue = cueAt(words, at, 1);
    }
    Piece piece;
    std::size_t length = 1;
    const bool is_class = cue.cue.kind == CueKind::kRoom && !noun.classes.empty();  // a map of a town has buildings
    if (noun.length > cue.length || (noun.length == cue.length && is_class)) {
      piece.kind = Piece::Kind::kNoun, piece.classes = noun.classes, length = noun.length;
    } else if (cue.length > 0) {
      piece.kind = Piece::Kind::kCue, piece.cue = cue.cue, length = cue.length;
    }
    piece.words = text(at, length);
    pieces.push_back(std::move(piece));
    at += length;
  }
  return pieces;
}

}  // namespace hgg
