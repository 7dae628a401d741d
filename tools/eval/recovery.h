#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "eval/trajectory.h"

namespace hgg {

/// A pose as it was published at its time, not as it was corrected later.
struct LivePose {
  TimedPose pose;
  std::string status;  // such as "aligned"; empty where the file has none
};

/// Rows t x y z qx qy qz qw, and a word for the status where there is one.
Result<std::vector<LivePose>> readLive(const std::filesystem::path& path);

/// A pose held against its truth.
struct TrackedPose {
  Micros utime_us = 0;
  double error = 0;                          // m, with the map laid over the truth at the first pose
  bool has_status = false, is_sure = false;  // sure: it says "aligned"
};
/// `live` are the poses of `truth_times_us`, as pairPoses() finds them.
Result<std::vector<TrackedPose>> trackPoses(const std::vector<LivePose>& live, const std::vector<Pose>& truth,
                                            const std::optional<std::vector<Micros>>& truth_times_us);

/// Within this, m, a pose is right; beyond the other it is in a wrong place.
inline constexpr double kRightPlace = 0.3, kWrongPlace = 1.0;

/// What became of poses that went wrong.
struct RecoveryScore {
  double end_error = 0;              // m
  double worst_error = 0;            // m
  double longest_off = 0;            // s, beyond kRightPlace
  std::optional<double> said_after;  // s from the fault to the first status other than "aligned"; nullopt: never
  double longest_wrong = 0;          // s, beyond kWrongPlace with a status that says aligned
  std::optional<double> back_after;  // s from the fault until it is right and stays so for kStays; nullopt: never
};
/// s a pose has to stay right to be back; less at the end of the drive is enough.
inline constexpr double kStays = 5.0;

/// `fault_us`: when something went wrong; the first pose's time where nothing did. `poses` are in order, not empty.
RecoveryScore scoreRecovery(std::span<const TrackedPose> poses, Micros fault_us);

}  // namespace hgg
