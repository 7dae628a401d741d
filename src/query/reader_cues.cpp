// What SentenceReader does with the words that name no thing.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "query/reader.h"

namespace hgg {
namespace {

/// That what is said after "the lamp on the table ..." is said of the lamp. By the sense of English: what tells a thing
/// from its like (closest, on the left) is mostly said of the thing asked for, what a thing has is said of what stands
/// before it.
constexpr double kOddsOfTarget = 0.5, kOddsOfTargetWhenTelling = 0.65, kOddsOfTargetWith = 0.3;

constexpr int kBitsOfChoices = std::numeric_limits<unsigned>::digits;  // later ones go to the thing spoken of last

constexpr bool isTelling(Relation r) { return r == Relation::kClosest || r == Relation::kFar; }

}  // namespace

/// Whose relation it is that comes now: that of the thing spoken of last, or of the target.
int SentenceReader::ownerOf(double odds_of_target) {
  if (current_ == kNobody || current_ == request_.target || request_.target == kNobody || after_break_ || after_and_) {
    return current_ != kNobody && !after_break_ && !after_and_ ? current_
           : request_.target != kNobody && !in_view_           ? request_.target
                                                               : (after_break_ ? kNobody : current_);
  }
  if (current_ == rejected_) {
    return current_;
  }
  const bool of_target = request_.choices < kBitsOfChoices && ((choices_ >> request_.choices) & 1U) != 0;
  ++request_.choices;
  request_.log_prior += std::log(of_target ? odds_of_target : 1 - odds_of_target);
  return of_target ? request_.target : current_;
}

void SentenceReader::takeRelation(Constraint constraint, bool needs_anchor) {
  flushAdjectives();
  constraint.is_negated = constraint.is_negated != (is_negated_ || negates_clause_), is_negated_ = false;
  if (isTelling(constraint.relation) && !needs_anchor && beginsNoun(at_ + 1)) {
    adjectives_.push_back(std::move(constraint));  // "the closest chair"
    return;
  }
  const double odds = constraint.relation == Relation::kWith ? kOddsOfTargetWith
                      : isTelling(constraint.relation)       ? kOddsOfTargetWhenTelling
                                                             : kOddsOfTarget;
  open_owner_ = ownerOf(odds);
  open_ = std::move(constraint);
}

void SentenceReader::takePlace(Constraint constraint) {
  constraint.is_negated = is_negated_ || negates_clause_, is_negated_ = false;
  if (rank_ != 0) {
    constraint.rank = rank_, constraint.ranked = true, rank_ = 0;
  }
  if (beginsNoun(at_ + 1)) {
    adjectives_.push_back(std::move(constraint));
    return;
  }
  flushAdjectives();
  if (constraint.place == Placement::kTop && last_relation_ && last_relation_->relation == Relation::kWith &&
      current_ == last_relation_->anchors.front() && last_owner_ != kNobody) {
    phrase(last_owner_).constraints.back().relation = Relation::kSupporting;  // "with a box on top"
    return;
  }
  if (open_) {
    open_.reset();  // "on the far left": the relation was no relation
  }
  describe(ownerOf(kOddsOfTargetWhenTelling), std::move(constraint));
}

void SentenceReader::takePronoun() {
  if (open_) {
    const int target = request_.target;
    if (open_owner_ != target && open_owner_ != kNobody && target != kNobody) {
      // "the table with a lamp on it": what is said of the lamp says something of the table.
      Constraint c = std::move(*open_);
      open_.reset();
      c.relation = inverseOf(c.relation), c.anchors = {open_owner_};
      std::vector<Constraint>& said = phrase(target).constraints;
      std::erase_if(said, [&](const Constraint& old) {
        c.is_negated = c.is_negated || (old.is_negated && old.anchors == c.anchors);
        return old.kind == Constraint::Kind::kRelation && old.anchors == c.anchors &&
               (old.relation == Relation::kWith || old.relation == Relation::kNear);
      });
      said.push_back(std::move(c));
    } else if (current_ != kNobody && current_ != open_owner_) {
      if (open_owner_ != kNobody) {  // "the chair without a desk next to it"
        const std::vector<Constraint>& said = phrase(open_owner_).constraints;
        open_->is_negated = open_->is_negated || std::ranges::any_of(said, [&](const Constraint& old) {
                              return old.is_negated && old.anchors == std::vector<int>{current_};
                            });
      }
      anchorAt(current_);
    } else if (request_.view && request_.view->phrase >= 0 && request_.view->phrase != open_owner_) {
      anchorAt(request_.view->phrase);  // "facing the copier, the table on the left of it"
    } else {
      open_.reset();
    }
    return;
  }
  if (after_break_ && request_.target != kNobody) {
    current_ = request_.target;
  }
}

bool SentenceReader::pieceIs(std::size_t at, CueKind kind) const {
  const Piece* piece = pieceAt(at);
  return piece != nullptr && piece->kind == Piece::Kind::kCue && piece->cue.kind == kind;
}

/// "to" and "from" after "the closest chair".
void SentenceReader::takeDangling() {
  if (dangling_) {
    open_ = std::exchange(dangling_, std::nullopt), open_owner_ = dangling_owner_;
  }
}

void SentenceReader::takeView(CueKind kind, bool is_from) {
  if (dangling_ && is_from) {
    takeDangling();
    return;
  }
  flushAdjectives();
  open_view_ = kind == CueKind::kFacing ? View::Kind::kFacing
               : kind == CueKind::kFrom ? View::Kind::kFrom
                                        : View::Kind::kEntering;
  if (kind == CueKind::kEntering) {
    request_.view = View{View::Kind::kEntering, kNobody};
  }
}

void SentenceReader::takeAttribute(const Piece& piece) {
  Constraint c;
  c.kind = piece.cue.kind == CueKind::kMeasure ? Constraint::Kind::kMeasure : Constraint::Kind::kColour;
  c.measure = static_cast<Measure>(piece.cue.value), c.sign = piece.cue.sign;
  c.is_superlative = piece.cue.is_superlative, c.word = piece.words;
  const bool of_noun = is_negated_ && pieceIs(not_at_ + 1, CueKind::kDeterminer);  // "not the red chair"
  c.is_negated = (!of_noun && std::exchange(is_negated_, false)) || negates_clause_;
  adjectives_.push_back(std::move(c));
}

/// The words that stand for a thing without naming it.
void SentenceReader::takeWord(const Piece& piece) {
  const CueKind kind = piece.cue.kind;
  if ((kind == CueKind::kRobot && !open_) ||              // "you want the ..."
      (kind == CueKind::kRoom && beginsNoun(at_ + 1))) {  // "the bathroom door"
    return;
  }
  Phrase p;
  p.words = piece.words, p.is_any = kind == CueKind::kAny;
  p.is_robot = kind == CueKind::kRobot, p.is_room = kind == CueKind::kRoom;
  takeNoun(std::move(p));
}

void SentenceReader::takeCue(const Piece& piece) {
  const Cue& cue = piece.cue;
  switch (cue.kind) {
    case CueKind::kRelation: {
      Constraint c = relationOf(static_cast<Relation>(cue.value));
      c.is_negated = cue.sign < 0;
      takeRelation(std::move(c), piece.words.find(' ') != std::string::npos);
      break;
    }
    case CueKind::kPlace: {
      Constraint c;
      c.kind = Constraint::Kind::kPlace, c.place = static_cast<Placement>(cue.value), c.word = piece.words;
      takePlace(std::move(c));
      break;
    }
    case CueKind::kFacing:
    case CueKind::kFrom:
    case CueKind::kEntering:
      takeView(cue.kind, piece.words == "from");
      break;
    case CueKind::kAny:
    case CueKind::kRobot:
    case CueKind::kRoom:
      takeWord(piece);
      break;
    case CueKind::kThat:
    case CueKind::kPart:
    case CueKind::kOther:
    case CueKind::kOf:
      is_other_ = is_other_ || cue.kind == CueKind::kOther;
      break;
    default:
      takeSmallWord(piece);
      return;
  }
  after_break_ = after_and_ = false;
}

/// The words after which what follows belongs to whom it belonged before.
void SentenceReader::takeSmallWord(const Piece& piece) {
  switch (piece.cue.kind) {
    case CueKind::kMeasure:
    case CueKind::kColour:
      takeAttribute(piece);
      break;
    case CueKind::kOrdinal:
      rank_ = piece.cue.value;
      break;
    case CueKind::kNumber:
      count_ = piece.cue.value;
      break;
    case CueKind::kNot:
      is_negated_ = true, not_at_ = at_;
      break;
    case CueKind::kPronoun:
      takePronoun();
      break;
    case CueKind::kDeterminer:
      had_determiner_ = true;
      break;
    case CueKind::kThis:
      is_this_ = !pieceIs(at_ + 1, CueKind::kIs);
      if (!is_this_) {
        takePronoun();
      }
      break;
    case CueKind::kAnd:
      flushAdjectives();
      after_and_ = true;
      if (rejected_ != kNobody && piece.words == "but") {  // "not the chair near the bed but the table"
        rejected_ = kNobody, current_ = request_.target, last_relation_.reset();
      }
      break;
    case CueKind::kPick:
      is_predicate_ = after_break_ = true;
      break;
    case CueKind::kIs:
      is_predicate_ =
          is_predicate_ || (at_ > 0 && (pieceIs(at_ - 1, CueKind::kPronoun) || pieceIs(at_ - 1, CueKind::kThis) ||
                                        pieceIs(at_ - 1, CueKind::kAny)));
      break;
    case CueKind::kFiller:
      if (piece.words == "to") {
        takeDangling();
      }
      break;
    default:
      break;
  }
}

}  // namespace hgg
