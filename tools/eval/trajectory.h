#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/result.h"
#include "map/map.h"

namespace hgg {

/// True and estimated pose of the body at one time, each in its own world.
struct PosePair {
  Pose T_truth_body = Pose::Identity();
  Pose T_map_body = Pose::Identity();
  Micros utime_us = 0;  // of the estimate
};

/// Pairs an estimated trajectory with the true poses, which come one a frame: by row when `truth_times_us` is missing
/// and the counts agree, by nearest time within 5 ms when it is there (poses without a partner are left out). Errors:
/// unlike counts without times, unlike numbers of times and poses, fewer than two pairs.
Result<std::vector<PosePair>> pairPoses(const std::vector<TimedPose>& estimate, const std::vector<Pose>& truth,
                                        const std::optional<std::vector<Micros>>& truth_times_us);

/// The pair whose estimate is of this time, give or take 5 ms; nullopt without one.
std::optional<std::size_t> indexAt(std::span<const PosePair> pairs, Micros time_us);

/// True path from the first pose to each pose, m.
std::vector<double> distancesAlong(std::span<const PosePair> pairs);

/// The map's frame is a gauge: T_truth_map that lays the estimate over the truth. Rotation = chordal mean of R_truth
/// R_map^T over all pairs, translation from the means of the positions. Positions alone would leave the roll about a
/// nearly straight path free.
Pose alignMap(const std::vector<PosePair>& pairs);

/// Absolute trajectory error: RMSE of the positions in m after the rigid alignment that fits positions best (Umeyama,
/// no scale).
double absoluteTrajectoryError(const std::vector<PosePair>& pairs);

/// m, the largest error along the truth's vertical after alignMap().
double heightError(const std::vector<PosePair>& pairs);

/// Drift over stretches of the true path, scaled to 100 m. Every pose starts a stretch; it ends at the first pose at
/// least `stretch` m of true path further on, and is compared as a motion, so no alignment is involved.
struct RelativeError {
  double stretch = 0;       // m: 100, or half of a path of less than 200 m
  std::size_t count = 0;    // stretches
  double translation = 0;   // m per 100 m, mean; NaN without stretches
  double rotation_deg = 0;  // per 100 m, mean
};
RelativeError relativeError(const std::vector<PosePair>& pairs);

/// Error of every pose after the rigid alignment of absoluteTrajectoryError(), m.
std::vector<double> positionErrors(const std::vector<PosePair>& pairs);

}  // namespace hgg
