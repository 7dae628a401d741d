#include "query/reader.h"

#include <algorithm>
#include <cmath>

namespace hgg {
namespace {

/// That what is said after "the lamp on the table ..." is said of the lamp. By the sense of English: what tells a thing
/// from its like (closest, on the left) is mostly said of the thing asked for, what a thing has is said of what stands
/// before it.
constexpr double kOddsOfTarget = 0.5, kOddsOfTargetWhenTelling = 0.65, kOddsOfTargetWith = 0.3;
/// A thing that is spoken of without a relation is somewhere near.
constexpr double kMentionWeight = 0.5;

constexpr bool isTelling(Relation r) { return r == Relation::kClosest || r == Relation::kFar; }

/// What holds of the anchor when the relation holds of the owner.
Relation inverseOf(Relation r) {
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

/// "the back of the room" is a place, not a relation.
std::optional<Placement> placeInRoom(Relation r) {
  switch (r) {
    case Relation::kLeft:
      return Placement::kLeft;
    case Relation::kRight:
      return Placement::kRight;
    case Relation::kFront:
      return Placement::kFront;
    case Relation::kBehind:
      return Placement::kBack;
    case Relation::kBetween:
      return Placement::kCentre;
    default:
      return std::nullopt;
  }
}

Constraint relationOf(Relation r, double weight = 1) {
  Constraint c;
  c.kind = Constraint::Kind::kRelation, c.relation = r, c.weight = weight;
  return c;
}

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
    if (noun.length > cue.length) {
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

Request SentenceReader::read() {
  for (at_ = 0; at_ < pieces_.size(); ++at_) {
    const Piece& piece = pieces_[at_];
    switch (piece.kind) {
      case Piece::Kind::kCue:
        takeCue(piece);
        break;
      case Piece::Kind::kBreak:
      case Piece::Kind::kStop:
        takeBreak(piece.kind == Piece::Kind::kStop);
        break;
      case Piece::Kind::kUnknown:
        ++request_.unread;
        break;
      case Piece::Kind::kNoun: {
        Phrase noun;
        noun.words = piece.words, noun.classes = piece.classes;
        // Of nouns in a row the last one is the thing, unless the map has no such thing.
        while (pieceAt(at_ + 1) != nullptr && pieceAt(at_ + 1)->kind == Piece::Kind::kNoun) {
          const Piece& next = pieces_[++at_];
          noun.words += " " + next.words;
          noun.classes = next.classes.empty() ? noun.classes : next.classes;
        }
        takeNoun(std::move(noun));
        break;
      }
    }
  }
  finish();
  return std::move(request_);
}

int SentenceReader::addPhrase(Phrase phrase) {
  request_.phrases.push_back(std::move(phrase));
  return static_cast<int>(request_.phrases.size()) - 1;
}

void SentenceReader::describe(int owner, Constraint constraint) {
  if (owner == kNobody) {
    orphans_.push_back(std::move(constraint));
  } else {
    phrase(owner).constraints.push_back(std::move(constraint));
  }
}

bool SentenceReader::sameKind(const Phrase& a, const Phrase& b) const {
  return std::ranges::any_of(a.classes, [&](const auto& fit) {
    const auto it = b.classes.find(fit.first);
    return it != b.classes.end() && fit.second * it->second > 0.2;
  });
}

bool SentenceReader::beginsNoun(std::size_t at) const {
  const Piece* piece = pieceAt(at);
  return piece != nullptr &&
         (piece->kind == Piece::Kind::kNoun || (piece->kind == Piece::Kind::kCue && piece->cue.kind == CueKind::kAny));
}

/// Whose relation it is that comes now: that of the thing spoken of last, or of the target.
int SentenceReader::ownerOf(double odds_of_target) {
  if (current_ == kNobody || current_ == request_.target || request_.target == kNobody || after_break_ || after_and_) {
    return current_ != kNobody && !after_break_ && !after_and_ ? current_
           : request_.target != kNobody && !in_view_           ? request_.target
                                                               : (after_break_ ? kNobody : current_);
  }
  const bool of_target = ((choices_ >> request_.choices++) & 1U) != 0;
  request_.log_prior += std::log(of_target ? odds_of_target : 1 - odds_of_target);
  return of_target ? request_.target : current_;
}

void SentenceReader::takeRelation(Constraint constraint, bool needs_anchor) {
  flushAdjectives();
  constraint.is_negated = is_negated_ || negates_clause_, is_negated_ = false;
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

void SentenceReader::flushAdjectives() {
  for (Constraint& c : std::exchange(adjectives_, {})) {
    describe(request_.target, std::move(c));
  }
}

void SentenceReader::anchorAt(int anchor) {
  Constraint relation = std::move(*open_);
  open_.reset();
  const int owner = open_owner_;
  if (phrase(anchor).is_room) {
    if (const std::optional<Placement> place = placeInRoom(relation.relation)) {
      relation.kind = Constraint::Kind::kPlace, relation.place = *place;
      describe(owner, std::move(relation));
    }
    return;
  }
  if (std::exchange(is_this_, false) && (request_.target == kNobody || owner == request_.target)) {
    // "there is a painting above this cabinet": the cabinet is meant.
    const int was = request_.target;
    becomeTarget(anchor);
    relation.relation = inverseOf(relation.relation), relation.anchors = {was};
    if (was != kNobody) {
      describe(anchor, std::move(relation));
    }
    return;
  }
  relation.anchors.push_back(anchor);
  last_relation_ = relation, last_owner_ = owner;
  describe(owner, std::move(relation));
  current_ = phrase(anchor).is_robot ? owner : anchor;
}

void SentenceReader::becomeTarget(int phrase_index) {
  request_.target = current_ = phrase_index;
  for (Constraint& c : std::exchange(orphans_, {})) {
    phrase(phrase_index).constraints.push_back(std::move(c));
  }
  in_view_ = false;
}

void SentenceReader::mention(int phrase_index) {
  if (!phrase(phrase_index).is_room && !phrase(phrase_index).is_robot) {
    Constraint c = relationOf(Relation::kNear, kMentionWeight);
    c.anchors.push_back(phrase_index), c.is_negated = negates_clause_;
    describe(request_.target, std::move(c));
    current_ = phrase_index;
  }
}

void SentenceReader::takeNoun(Phrase noun) {
  noun.count = std::exchange(count_, 0);
  noun.is_other = std::exchange(is_other_, false);
  const bool predicate = std::exchange(is_predicate_, false), determined = std::exchange(had_determiner_, false);
  const bool conjoined = std::exchange(after_and_, false), first_of_clause = std::exchange(after_break_, false);
  for (Constraint& c : std::exchange(adjectives_, {})) {
    if (c.kind == Constraint::Kind::kRelation) {
      dangling_ = c, dangling_owner_ = static_cast<int>(request_.phrases.size());
    } else {
      noun.constraints.push_back(std::move(c));
    }
  }
  if (rank_ != 0) {  // "the second chair": of a row, from where the reader begins
    Constraint c;
    c.kind = Constraint::Kind::kPlace, c.rank = std::exchange(rank_, 0), c.ranked = true;
    noun.constraints.push_back(std::move(c));
  }
  const int target = request_.target;
  if (open_view_) {
    const int k = addPhrase(std::move(noun));
    if (request_.view && request_.view->phrase >= 0 && phrase(k).is_room) {
      open_view_.reset();  // "looking at the couch from inside the room"
      return;
    }
    request_.view = View{*std::exchange(open_view_, std::nullopt), phrase(k).is_room ? -1 : k};
    in_view_ = true, current_ = k;
    return;
  }
  if (open_) {
    open_->is_negated = open_->is_negated != std::exchange(is_negated_, false);  // "with no person"
    anchorAt(addPhrase(std::move(noun)));
    return;
  }
  is_this_ = false;
  if (conjoined && last_relation_ && !predicate && !noun.is_any &&
      !(target != kNobody && sameKind(noun, phrase(target)))) {
    const int k = addPhrase(std::move(noun));  // "between the bed and the desk", "near the bed and the desk"
    std::vector<Constraint>& said = last_owner_ == kNobody ? orphans_ : phrase(last_owner_).constraints;
    if (last_relation_->relation == Relation::kBetween && !said.empty()) {
      said.back().anchors.push_back(k);
    } else {
      Constraint more = *last_relation_;
      more.anchors = {k};
      describe(last_owner_, std::move(more));
    }
    current_ = k;
    return;
  }
  if (noun.is_room || noun.is_robot || (is_negated_ && predicate && !noun.is_any)) {
    return;  // the last: "do not pick the curtain"
  }
  if (target == kNobody) {
    becomeTarget(addPhrase(std::move(noun)));
  } else if (noun.is_any || (sameKind(noun, phrase(target)) && !noun.is_other)) {
    if (is_negated_ && !noun.is_any) {
      negates_clause_ = true;
    }
    negates_clause_ = negates_clause_ || std::exchange(is_negated_, false);
    for (Constraint& c : noun.constraints) {
      c.is_negated = c.is_negated != negates_clause_;
      phrase(target).constraints.push_back(std::move(c));
    }
    phrase(target).count = std::max(phrase(target).count, noun.count);
    if (dangling_ && dangling_owner_ == static_cast<int>(request_.phrases.size())) {
      dangling_owner_ = target;
    }
    current_ = target;
  } else {
    const Piece* next = pieceAt(at_ + 1);
    const bool is_subject = first_of_clause && determined && next != nullptr && next->kind == Piece::Kind::kCue &&
                            next->cue.kind == CueKind::kIs;
    const bool was_modifier = phrase(target).classes.empty() && !phrase(target).is_any &&
                              phrase(target).constraints.empty() && !first_of_clause;
    const int k = addPhrase(std::move(noun));
    if (was_modifier) {  // "3 tier wall mounted bookshelf"
      becomeTarget(k);
    } else if ((predicate || is_subject) && !phrase(k).classes.empty()) {
      becomeTarget(k);
      mention(target);
      current_ = k;
    } else {
      mention(k);
    }
  }
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

void SentenceReader::takeBreak(bool is_stop) {
  flushAdjectives();
  if (open_ && is_stop) {
    open_.reset();
  }
  open_view_.reset();
  count_ = rank_ = 0;
  is_negated_ = negates_clause_ = is_other_ = had_determiner_ = is_predicate_ = in_view_ = after_and_ = false;
  after_break_ = true;
  current_ = request_.target;
  if (is_stop) {
    last_relation_.reset();
  }
}

void SentenceReader::takeCue(const Piece& piece) {
  const Cue& cue = piece.cue;
  Constraint c;
  switch (cue.kind) {
    case CueKind::kRelation:
      takeRelation(relationOf(static_cast<Relation>(cue.value)), piece.words.find(' ') != std::string::npos);
      break;
    case CueKind::kPlace:
      c.kind = Constraint::Kind::kPlace, c.place = static_cast<Placement>(cue.value);
      takePlace(std::move(c));
      break;
    case CueKind::kMeasure:
    case CueKind::kColour:
      c.kind = cue.kind == CueKind::kMeasure ? Constraint::Kind::kMeasure : Constraint::Kind::kColour;
      c.measure = static_cast<Measure>(cue.value), c.sign = cue.sign, c.is_superlative = cue.is_superlative;
      c.word = piece.words, c.is_negated = std::exchange(is_negated_, false) || negates_clause_;
      adjectives_.push_back(std::move(c));
      break;
    case CueKind::kOrdinal:
      rank_ = cue.value;
      break;
    case CueKind::kNumber:
      count_ = cue.value;
      break;
    case CueKind::kNot:
      is_negated_ = true;
      break;
    case CueKind::kFacing:
    case CueKind::kFrom:
    case CueKind::kEntering:
      if (dangling_ && cue.kind == CueKind::kFrom && piece.words == "from") {
        open_ = std::exchange(dangling_, std::nullopt), open_owner_ = dangling_owner_;
      } else {
        flushAdjectives();
        open_view_ = cue.kind == CueKind::kFacing ? View::Kind::kFacing
                     : cue.kind == CueKind::kFrom ? View::Kind::kFrom
                                                  : View::Kind::kEntering;
        if (cue.kind == CueKind::kEntering) {
          request_.view = View{View::Kind::kEntering, -1};
        }
      }
      break;
    case CueKind::kPronoun:
      takePronoun();
      break;
    case CueKind::kAny:
    case CueKind::kRobot:
    case CueKind::kRoom: {
      if ((cue.kind == CueKind::kRobot && !open_) ||              // "you want the ..."
          (cue.kind == CueKind::kRoom && beginsNoun(at_ + 1))) {  // "the bathroom door"
        break;
      }
      Phrase p;
      p.words = piece.words, p.is_any = cue.kind == CueKind::kAny;
      p.is_robot = cue.kind == CueKind::kRobot, p.is_room = cue.kind == CueKind::kRoom;
      takeNoun(std::move(p));
      break;
    }
    case CueKind::kDeterminer:
      had_determiner_ = true;
      break;
    case CueKind::kThis:
      is_this_ = pieceAt(at_ + 1) != nullptr &&
                 !(pieceAt(at_ + 1)->kind == Piece::Kind::kCue && pieceAt(at_ + 1)->cue.kind == CueKind::kIs);
      if (!is_this_) {
        takePronoun();
      }
      break;
    case CueKind::kOther:
      is_other_ = true;
      break;
    case CueKind::kAnd:
      flushAdjectives();
      after_and_ = true;
      break;
    case CueKind::kPick:
      is_predicate_ = true, after_break_ = true;
      break;
    case CueKind::kIs:
      is_predicate_ = is_predicate_ ||
                      (at_ > 0 && pieces_[at_ - 1].kind == Piece::Kind::kCue &&
                       (pieces_[at_ - 1].cue.kind == CueKind::kPronoun || pieces_[at_ - 1].cue.kind == CueKind::kAny));
      break;
    case CueKind::kFiller:
      if (dangling_ && piece.words == "to") {
        open_ = std::exchange(dangling_, std::nullopt), open_owner_ = dangling_owner_;
      }
      break;
    case CueKind::kShape:
    case CueKind::kPart:
    case CueKind::kThat:
    case CueKind::kOf:
      break;
  }
  if (cue.kind != CueKind::kFiller && cue.kind != CueKind::kDeterminer && cue.kind != CueKind::kPick &&
      cue.kind != CueKind::kNumber && cue.kind != CueKind::kOrdinal && cue.kind != CueKind::kMeasure &&
      cue.kind != CueKind::kColour && cue.kind != CueKind::kShape && cue.kind != CueKind::kPronoun &&
      cue.kind != CueKind::kIs && cue.kind != CueKind::kNot && cue.kind != CueKind::kAnd) {
    after_break_ = false, after_and_ = false;
  }
}

void SentenceReader::finish() {
  takeBreak(true);
  if (dangling_ && dangling_owner_ < static_cast<int>(request_.phrases.size())) {
    Phrase robot;  // "the closest chair": to who asks
    robot.words = "you", robot.is_robot = true;
    dangling_->anchors = {addPhrase(std::move(robot))};
    describe(dangling_owner_, *dangling_);
  }
  std::vector<Phrase>& phrases = request_.phrases;
  if (request_.target == kNobody && !phrases.empty()) {
    const auto counted =
        std::ranges::find_if(phrases, [](const Phrase& p) { return p.count > 1 && !p.classes.empty(); });
    const auto any = std::ranges::find_if(phrases, [](const Phrase& p) { return !p.is_room && !p.is_robot; });
    const auto chosen = counted != phrases.end() ? counted : any;
    if (chosen != phrases.end()) {
      becomeTarget(static_cast<int>(chosen - phrases.begin()));
    }
  }
  if (request_.target == kNobody) {
    return;
  }
  Phrase& target = phrase(request_.target);
  if (target.is_any) {  // "on the desk with three monitors, it is the one in the middle"
    const bool in_view = request_.view && request_.view->phrase >= 0;
    const Phrase* model = in_view ? &phrase(request_.view->phrase) : nullptr;
    for (const Phrase& p : phrases) {
      model = p.count > 1 && !p.classes.empty() ? &p : model;
    }
    if (model != nullptr && !model->classes.empty()) {
      target.classes = model->classes, target.words = model->words, target.is_any = false;
    }
  }
}

}  // namespace hgg
