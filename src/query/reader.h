#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "query/pieces.h"
#include "query/request.h"

namespace hgg {

/// Reads pieces from left to right into one request. It knows the thing asked for (the target), the thing spoken of
/// last (the current one), the adjectives that wait for their noun, and the relation that waits for its anchor.
/// Bit k of `choices` says to whom the k-th relation belongs of those that could belong to the current thing or to the
/// target.
class SentenceReader {
 public:
  SentenceReader(std::span<const Piece> pieces, unsigned choices) : pieces_(pieces), choices_(choices) {}
  Request read();

 private:
  static constexpr int kNobody = -1;

  void takeCue(const Piece& piece);
  void takeSmallWord(const Piece& piece);
  void takeRelation(Constraint constraint, bool needs_anchor);
  void takePlace(Constraint constraint);
  void takeNouns();
  void takeNoun(Phrase noun);
  void takeAdjectives(Phrase& noun);
  bool takeAsAnchor(Phrase& noun, bool is_conjoined);
  void takeAgain(Phrase noun);
  void takeAnother(Phrase noun, bool is_predicate, bool may_be_subject);
  void takeView(CueKind kind, bool is_from);
  void takeAttribute(const Piece& piece);
  void takeWord(const Piece& piece);
  void takeDangling();
  bool pieceIs(std::size_t at, CueKind kind) const;
  void takePronoun();
  void takeBreak(bool is_stop);
  void anchorAt(int anchor);
  void becomeTarget(int phrase_index);
  void mention(int phrase_index);
  void reject(Phrase noun);
  bool rejectsNoun() const;
  void describe(int owner, Constraint constraint);
  void flushAdjectives();
  void finish();
  int addPhrase(Phrase phrase);
  int ownerOf(double odds_of_target);
  bool sameKind(const Phrase& a, const Phrase& b) const;
  bool beginsNoun(std::size_t at) const;
  const Piece* pieceAt(std::size_t at) const { return at < pieces_.size() ? &pieces_[at] : nullptr; }
  Phrase& phrase(int k) { return request_.phrases[static_cast<std::size_t>(k)]; }

  std::span<const Piece> pieces_;
  unsigned choices_;
  Request request_;
  std::size_t at_ = 0;
  int current_ = kNobody;
  std::vector<Constraint> adjectives_;
  std::vector<Constraint> orphans_;  // of a target that is yet to come
  std::optional<Constraint> open_;   // relation that waits for its anchor
  int open_owner_ = kNobody;
  std::optional<Constraint> dangling_;  // "the closest chair", until "to the door" comes
  int dangling_owner_ = kNobody;
  std::optional<View::Kind> open_view_;
  int rejected_ = kNobody;  // "not the chair": what is said next is said of it
  int last_rejected_ = kNobody;
  std::size_t not_at_ = 0;  // piece of the last "not"
  int count_ = 0, rank_ = 0;
  bool is_negated_ = false, negates_clause_ = false, after_break_ = true, after_and_ = false, is_other_ = false;
  bool had_determiner_ = false, is_this_ = false, is_predicate_ = false, in_view_ = false;
  std::optional<Constraint> last_relation_;
  int last_owner_ = kNobody;
};

}  // namespace hgg
