#pragma once

#include <optional>
#include <string>
#include <vector>

#include "query/lexicon.h"

namespace hgg {

/// How a thing lies to others ("anchors").
enum class Relation : std::uint8_t {
  kNear,
  kClosest,
  kFar,
  kBetween,
  kOn,          // rests on the anchor, or hangs on it
  kSupporting,  // the anchor rests on it
  kAbove,
  kBelow,
  kFront,
  kBehind,
  kLeft,
  kRight,
  kInside,
  kFacing,
  kAcross,
  kWith,  // has the anchor on, in or beside it
};

/// What holds of the anchor when the relation holds of the owner.
inline Relation inverseOf(Relation r) {
  switch (r) {
    case Relation::kOn:
      return Relation::kSupporting;
    case Relation::kSupporting:
      return Relation::kOn;
    case Relation::kAbove:
      return Relation::kBelow;
    case Relation::kBelow:
      return Relation::kAbove;
    case Relation::kInside:
      return Relation::kWith;
    default:
      return r == Relation::kWith ? Relation::kNear : r;
  }
}

/// Where a thing is among its like, or in the room.
enum class Placement : std::uint8_t {
  kLeft,
  kRight,
  kMiddle,
  kFront,
  kBack,
  kTop,
  kBottom,
  kCorner,
  kCentre,
  kWall,
  kFloor,
  kAlone
};

/// What of a thing's extent is spoken of.
enum class Measure : std::uint8_t { kSize, kHeight, kLength, kWidth };

/// What a phrase says of its thing. One of the kinds below, with what belongs to it.
struct Constraint {
  enum class Kind : std::uint8_t { kRelation, kPlace, kMeasure, kColour, kShape };
  Kind kind = Kind::kRelation;
  Relation relation = Relation::kNear;
  std::vector<int> anchors;  // phrases of the request; several: it lies so to all of them together (between)
  Placement place = Placement::kLeft;
  int rank = 1;          // the second from the left is 2
  bool is_bare = false;  // a rank, of which it was not said from where it counts
  bool ranked = false;   // an ordinal was given
  Measure measure = Measure::kSize;
  double sign = 1;  // of a measure: 1 for large, -1 for small
  bool is_superlative = false;
  std::string word;  // the colour or shape
  bool is_negated = false;
  double weight = 1;  // how sure it is that this was meant
};

inline Constraint relationOf(Relation r, double weight = 1) {
  Constraint c;
  c.kind = Constraint::Kind::kRelation, c.relation = r, c.weight = weight;
  return c;
}

/// A thing that a request speaks of.
struct Phrase {
  std::string words;
  ClassFit classes;       // none: no class of the map stands for it
  bool is_any = false;    // "the one", "the object": of any class
  bool is_room = false;   // the room itself
  bool is_robot = false;  // who asks: "me", "you"
  bool is_other = false;  // "the other chairs"
  int count = 0;          // "three chairs"; 0: not said
  std::vector<Constraint> constraints;
};

/// From where left, right, front and back are said.
struct View {
  enum class Kind : std::uint8_t { kFacing, kFrom, kEntering };
  Kind kind = Kind::kFacing;
  int phrase = -1;  // what is faced, or from where; -1: the door, for entering
};

/// One reading of a text.
struct Request {
  std::vector<Phrase> phrases;
  int target = -1;  // phrase; -1: nothing was asked for
  std::optional<View> view;
  int unread = 0;        // words that may matter and were not understood
  int choices = 0;       // places where another reading was possible
  double log_prior = 0;  // of this reading against the others of the text
};

}  // namespace hgg
