#pragma once

#include <span>
#include <string>
#include <vector>

#include "query/request.h"

namespace hgg {

/// The words of English that are no names of things: a table (english.cpp) and the search in it.
enum class CueKind : std::uint8_t {
  kRelation,  // "next to": value is a Relation; sign below 0: that it does not hold ("without")
  kPlace,     // "on the left": value is a Placement
  kMeasure,   // "tall": a Measure, sign, and whether it is a superlative
  kColour,    // text says which
  kShape,     // form, material, state: nothing a map knows of
  kOrdinal,   // "second": value
  kNumber,    // "two": value
  kNot,
  kFacing,  // begins the phrase of a view
  kFrom,
  kEntering,
  kPronoun,  // "it"
  kAny,      // "one", "object"
  kRobot,    // "me"
  kRoom,
  kDeterminer,
  kOther,
  kPart,  // "side", "edge": its owner is meant
  kThis,  // the thing asked for
  kThat,  // begins what is said of the last thing
  kAnd,
  kPick,  // "choose": what follows is asked for
  kIs,
  kOf,
  kFiller,  // says nothing
};

struct Cue {
  CueKind kind = CueKind::kFiller;
  int value = 0;
  int sign = 0;
  bool is_superlative = false;
};

struct FoundCue {
  std::size_t length = 0;  // words; 0: none
  Cue cue;
};

/// The longest cue that begins at words[at] with at most `most` words.
FoundCue cueAt(std::span<const std::string> words, std::size_t at, std::size_t most = 8);
/// Whether a word can be part of a noun: letters or digits, and no cue.
bool isPlainWord(const std::string& word);
/// "side", "corner", "row": nouns that WordNet knows and that name no thing.
bool isRelationNoun(const std::string& word);

}  // namespace hgg
