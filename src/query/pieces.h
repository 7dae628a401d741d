#pragma once

#include <span>
#include <string>
#include <vector>

#include "query/english.h"
#include "query/lexicon.h"

namespace hgg {

/// Words cut into pieces: cues, nouns, and what is neither.
struct Piece {
  enum class Kind : std::uint8_t { kCue, kNoun, kBreak, kStop, kUnknown };
  Kind kind = Kind::kUnknown;
  std::string words;
  Cue cue;
  ClassFit classes;
};

std::vector<Piece> piecesOf(std::span<const std::string> words, const Lexicon& lexicon);

}  // namespace hgg
