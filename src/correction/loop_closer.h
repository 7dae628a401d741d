#pragma once

#include <deque>
#include <future>
#include <optional>
#include <string>
#include <vector>

#include "core/classes.h"
#include "correction/loop_agreement.h"
#include "correction/loop_closure.h"
#include "map/map.h"

namespace hgg {

/// When the result of a loop verification is taken.
enum class LoopTiming {
  kFixed,   // at a fixed later keyframe, waiting for it: the same log gives the same map
  kPrompt,  // when it is there; frames never wait
};

/// What became of a loop candidate.
struct LoopRecord {
  Micros before_us = 0, now_us = 0;  // of the two keyframes
  bool accepted = false;
  double score = 0;       // nats, of the alignment
  double deviations = 0;  // LoopVerification
  Pose T_before_now = Pose::Identity();
  std::string reason;
};

/// Closes loops: picks loop candidates at a keyframe, has them verified beside the frame work, and returns a correction
/// when two loops agree that the belief about the keyframes allows, or three that it does not: then the belief was
/// wrong. The candidates of one keyframe are verified at a time.
class LoopCloser {
 public:
  LoopCloser(const LoopConfig& config, std::vector<SimilarClasses> similar, LoopTiming timing)
      : config_(config), similar_(std::move(similar)), timing_(timing), agreement_(config) {}

  /// Describes the places of a stored map, so that they can be found again. Call it before the first step, while all of
  /// the map is active.
  void start(const Map& stored);
  /// Call it once after each new keyframe of `map`, and after each that was taken up again. Returns the correction that
  /// a verification which is due makes of the map as it is now: keyframes younger than the candidate move rigidly with
  /// the newest one it knew. Without one, and when no verification is under way, it picks a keyframe that may close a
  /// loop.
  std::optional<MapCorrection> step(const Map& map);
  /// The keyframes that step() has picked, whose surroundings startVerification() reads.
  const std::vector<LoopKeyframe>& picked() const { return picked_; }
  /// `place_radius` of them, m.
  double placeRadius() const { return config_.place_radius; }
  /// Starts verifying what step() has picked, if it has. What is paged out of the older places is read by `pages`.
  void startVerification(const Map& map, const PageReader& pages = nullptr);
  /// At the end of a drive: waits for the verification that is still running, and returns its correction.
  std::optional<MapCorrection> finish(const Map& map) { return take(map, true); }

  /// The newest, at most a thousand.
  const std::deque<LoopRecord>& records() const { return records_; }
  int accepted() const { return accepted_; }
  int rejected() const { return rejected_; }

 private:
  /// Candidates of one keyframe that have been verified: the one that was recognised, if any was, in the pose graph.
  struct Outcome {
    VerifiedLoop verified;
    bool is_recognised = false;
    LoopRecord record;
    std::vector<Pose> moves;  // T_map_map of the keyframes the candidate knew; empty unless accepted
    bool is_laid_out = true;  // false: the pose graph is still to be solved
  };

  /// Like verify(), but an exception (no memory, a solver) costs the loop and not the drive.
  static Outcome verifySafely(const std::vector<LoopCandidate>& candidates, std::optional<KeyframeGraph> graph,
                              const std::vector<SimilarClasses>& similar, const LoopConfig& config);
  static Outcome verify(const std::vector<LoopCandidate>& candidates, std::optional<KeyframeGraph> graph,
                        const std::vector<SimilarClasses>& similar, const LoopConfig& config);
  static Outcome layOut(Outcome outcome, KeyframeGraph graph);
  /// Takes the result of the verification; `is_last`: waits for all of it.
  std::optional<MapCorrection> take(const Map& map, bool is_last);
  /// Describes the place that the robot is at.
  void describe(const Map& map);
  bool isVerificationDue() const;
  void record(const LoopRecord& record);
  /// The correction by loops that agree although the keyframes speak against each of them; nullopt without such loops.
  std::optional<MapCorrection> overruled(const Map& map) const;

  LoopConfig config_;
  std::vector<SimilarClasses> similar_;
  LoopTiming timing_;
  std::vector<PlaceDescriptor> descriptors_;  // of each keyframe, as it was when it was made or stored
  std::vector<LoopKeyframe> picked_;
  LoopSearch search_;
  std::future<Outcome> verification_;
  std::int64_t steps_ = 0, picked_at_ = 0;  // calls of step(), and when the candidate was picked
  LoopAgreement agreement_;                 // loops that are not confirmed yet
  std::deque<LoopRecord> records_;
  int accepted_ = 0, rejected_ = 0;
};

}  // namespace hgg
