#pragma once

#include <deque>
#include <future>
#include <optional>
#include <string>
#include <vector>

#include "config.h"
#include "core/classes.h"
#include "correction/loop_closure.h"
#include "map/map.h"

namespace hgg {

/// When the answer to a question about a loop is taken.
enum class LoopTiming {
  kFixed,   // at a fixed later keyframe, waiting for it: the same log gives the same map
  kPrompt,  // when it is there; frames never wait
};

/// What became of a question.
struct LoopRecord {
  Micros before_us = 0, now_us = 0;  // of the two keyframes
  bool accepted = false;
  double score = 0;       // nats, of the alignment
  double deviations = 0;  // LoopVerification
  Pose T_before_now = Pose::Identity();
  std::string reason;
};

/// Closes loops: asks at keyframes, lets the question be answered beside the frame work, and makes a correction of what
/// two answers agree in. One question at a time.
class LoopCloser {
 public:
  LoopCloser(const Config& config, std::vector<SimilarClasses> similar, LoopTiming timing)
      : config_(config), similar_(std::move(similar)), timing_(timing) {}

  /// To be called first with the map that is gone on from, as long as all of it is active: its places may be met again.
  void start(const Map& stored);
  /// To be called once after each new keyframe of `map`. Returns what an answer that is due makes of the map as it is
  /// now: keyframes that are younger than the question go along with the newest of it.
  std::optional<MapCorrection> step(const Map& map);
  /// At the end of a drive: what a question that is still open comes to. Waits for it.
  std::optional<MapCorrection> finish(const Map& map);

  /// The newest, at most a thousand.
  const std::deque<LoopRecord>& records() const { return records_; }
  int accepted() const { return accepted_; }
  int rejected() const { return rejected_; }

 private:
  struct Closure {
    BetweenConstraint loop;
    LoopRecord record;
    std::vector<Pose> moves;  // T_map_map of the keyframes there were when it was asked; empty unless accepted
  };

  /// What goes wrong in it (memory, a solver) costs the loop, not the drive.
  static Closure closeSafely(const LoopCandidate& question, KeyframeGraph graph,
                             const std::vector<SimilarClasses>& similar, const Config& config);
  static Closure close(const LoopCandidate& question, KeyframeGraph graph, const std::vector<SimilarClasses>& similar,
                       const Config& config);
  void ask(const Map& map);
  void record(const LoopRecord& record);
  /// Whether an accepted loop says the same as the one before it; if not it waits for the next to say so.
  bool isConfirmed(const Map& map, const BetweenConstraint& loop);
  bool isDue(const Map& map) const;

  Config config_;
  std::vector<SimilarClasses> similar_;
  LoopTiming timing_;
  std::vector<PlaceDescriptor> descriptors_;  // of each keyframe, as it was when it was made or stored
  std::future<Closure> pending_;
  std::optional<BetweenConstraint> unconfirmed_;  // accepted, and not yet found a second time
  KeyframeId asked_at_ = -1;
  std::deque<LoopRecord> records_;
  int accepted_ = 0, rejected_ = 0;
};

}  // namespace hgg
