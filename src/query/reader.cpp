#include "query/reader.h"

#include <algorithm>
#include <cmath>

namespace hgg {
namespace {

/// A thing that is spoken of without a relation is somewhere near.
constexpr double kMentionWeight = 0.5;

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

}  // namespace

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
      case Piece::Kind::kNoun:
        takeNouns();
        break;
    }
  }
  finish();
  return std::move(request_);
}

/// Of nouns in a row the last one is the thing, unless the map has no such thing.
void SentenceReader::takeNouns() {
  Phrase noun;
  noun.words = pieces_[at_].words, noun.classes = pieces_[at_].classes;
  while (pieceAt(at_ + 1) != nullptr && pieceAt(at_ + 1)->kind == Piece::Kind::kNoun) {
    const Piece& next = pieces_[++at_];
    noun.words += " " + next.words;
    noun.classes = next.classes.empty() ? noun.classes : next.classes;
  }
  takeNoun(std::move(noun));
}

int SentenceReader::addPhrase(Phrase phrase) {
  request_.phrases.push_back(std::move(phrase));
  return static_cast<int>(request_.phrases.size()) - 1;
}

void SentenceReader::describe(int owner, Constraint constraint) {
  std::vector<Constraint>& said = owner == kNobody ? orphans_ : phrase(owner).constraints;
  const auto bare = std::ranges::find_if(said, &Constraint::is_bare);
  if (constraint.kind == Constraint::Kind::kPlace && !constraint.ranked && bare != said.end()) {
    bare->place = constraint.place, bare->word = constraint.word,
    bare->is_bare = false;  // "the second chair from the left"
  } else {
    said.push_back(std::move(constraint));
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
    c.anchors.push_back(phrase_index);
    c.is_negated = std::exchange(is_negated_, false) || negates_clause_;
    describe(request_.target, std::move(c));
    current_ = phrase_index;
  }
}

/// "not the chair": a thing that is not asked for. What follows is said of it, and nothing of the target.
void SentenceReader::reject(Phrase noun) {
  is_negated_ = false;
  rejected_ = last_rejected_ = current_ = addPhrase(std::move(noun));
}

/// Whether the negation is that of the noun at hand: "not the window". "No window" tells what is missing, and "not
/// blocking the window" denies what is done to it.
bool SentenceReader::rejectsNoun() const {
  const bool denies_other = std::any_of(pieces_.begin() + static_cast<std::ptrdiff_t>(not_at_),
                                        pieces_.begin() + static_cast<std::ptrdiff_t>(at_),
                                        [](const Piece& piece) { return piece.kind == Piece::Kind::kUnknown; });
  return is_negated_ && !denies_other && pieces_[not_at_].words != "no";
}

/// What was said before the noun: its adjectives, its number, its place in a row.
void SentenceReader::takeAdjectives(Phrase& noun) {
  noun.count = std::exchange(count_, 0);
  noun.is_other = std::exchange(is_other_, false);
  for (Constraint& c : std::exchange(adjectives_, {})) {
    if (c.kind == Constraint::Kind::kRelation) {
      dangling_ = c, dangling_owner_ = static_cast<int>(request_.phrases.size());
    } else {
      noun.constraints.push_back(std::move(c));
    }
  }
  if (rank_ != 0) {
    Constraint c;
    c.kind = Constraint::Kind::kPlace, c.rank = std::exchange(rank_, 0), c.ranked = c.is_bare = true;
    noun.constraints.push_back(std::move(c));
  }
}

/// A noun that a view or a relation waits for, or that is added to one by "and". False when none does.
bool SentenceReader::takeAsAnchor(Phrase& noun, bool is_conjoined) {
  if (open_view_) {
    const bool is_second = request_.view && request_.view->phrase >= 0 && noun.is_room;
    const View::Kind kind = *std::exchange(open_view_, std::nullopt);
    if (!is_second) {  // not "looking at the couch from inside the room"
      const bool is_room = noun.is_room;
      current_ = addPhrase(std::move(noun));
      request_.view = View{kind, is_room ? kNobody : current_};
      in_view_ = true;
    }
    return true;
  }
  if (open_) {
    open_->is_negated = open_->is_negated != std::exchange(is_negated_, false);  // "with no person"
    anchorAt(addPhrase(std::move(noun)));
    return true;
  }
  const int target = request_.target;
  if (!is_conjoined || !last_relation_ || noun.is_any || (target != kNobody && sameKind(noun, phrase(target)))) {
    return false;
  }
  current_ = addPhrase(std::move(noun));  // "between the bed and the desk", "near the bed and the desk"
  std::vector<Constraint>& said = last_owner_ == kNobody ? orphans_ : phrase(last_owner_).constraints;
  if (last_relation_->relation == Relation::kBetween && !said.empty()) {
    said.back().anchors.push_back(current_);
  } else {
    Constraint more = *last_relation_;
    more.anchors = {current_};
    describe(last_owner_, std::move(more));
  }
  return true;
}

/// The target, spoken of again.
void SentenceReader::takeAgain(Phrase noun) {
  Phrase& target = phrase(request_.target);
  negates_clause_ = negates_clause_ || std::exchange(is_negated_, false);
  for (Constraint& c : noun.constraints) {
    c.is_negated = c.is_negated != negates_clause_;
    target.constraints.push_back(std::move(c));
  }
  target.count = std::max(target.count, noun.count);
  if (dangling_ && dangling_owner_ == static_cast<int>(request_.phrases.size())) {
    dangling_owner_ = request_.target;
  }
  current_ = request_.target;
}

/// A thing beside the target, or the true target: "facing the desk it is the lamp".
void SentenceReader::takeAnother(Phrase noun, bool is_predicate, bool may_be_subject) {
  const int target = request_.target;
  const Phrase& old = phrase(target);
  // "3 tier wall mounted bookshelf": a tier is no thing of the map, and nothing is said of it.
  const bool was_modifier = old.classes.empty() && !old.is_any && old.constraints.empty() && !may_be_subject;
  const bool is_subject = may_be_subject && pieceIs(at_ + 1, CueKind::kIs);
  const int k = addPhrase(std::move(noun));
  if (was_modifier) {
    becomeTarget(k);
  } else if ((is_predicate || is_subject) && !phrase(k).classes.empty()) {
    becomeTarget(k);
    mention(target);
    current_ = k;
  } else {
    mention(k);
  }
}

void SentenceReader::takeNoun(Phrase noun) {
  takeAdjectives(noun);
  const bool predicate = std::exchange(is_predicate_, false), determined = std::exchange(had_determiner_, false);
  const bool conjoined = std::exchange(after_and_, false), first = std::exchange(after_break_, false);
  if (takeAsAnchor(noun, conjoined && !predicate)) {
    return;
  }
  is_this_ = false;
  const int target = request_.target;
  if (noun.is_room || noun.is_robot) {
    return;
  }
  const bool again = target != kNobody && (noun.is_any || (sameKind(noun, phrase(target)) && !noun.is_other));
  if (is_negated_ && !noun.is_any && (predicate || (!again && rejectsNoun()))) {
    reject(std::move(noun));  // the first: "do not pick the curtain"
  } else if (target == kNobody) {
    becomeTarget(addPhrase(std::move(noun)));
  } else if (again) {
    takeAgain(std::move(noun));
  } else {
    takeAnother(std::move(noun), predicate, first && determined);
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
  rejected_ = kNobody;
  if (is_stop) {
    last_relation_.reset();
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
    if (chosen != phrases.end() && last_rejected_ == kNobody) {
      becomeTarget(static_cast<int>(chosen - phrases.begin()));
    }
  }
  if (request_.target == kNobody) {
    return;
  }
  Phrase& target = phrase(request_.target);
  if (target.is_any) {  // "on the desk with three monitors, it is the one in the middle"
    const bool in_view = request_.view && request_.view->phrase >= 0;
    const Phrase* model = in_view                     ? &phrase(request_.view->phrase)
                          : last_rejected_ != kNobody ? &phrase(last_rejected_)  // "not the chair here, the one there"
                                                      : nullptr;
    for (const Phrase& p : phrases) {
      model = p.count > 1 && !p.classes.empty() ? &p : model;
    }
    if (model != nullptr && !model->classes.empty()) {
      target.classes = model->classes, target.words = model->words, target.is_any = false;
    }
  }
}

}  // namespace hgg
