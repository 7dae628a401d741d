#pragma once

#include <optional>
#include <vector>

#include "alignment/align.h"
#include "alignment/pose_search.h"
#include "core/classes.h"
#include "frame/frame.h"

namespace hgg {

/// A frame that was laid on the map from another start than odometry's: its graph, whose tiles are cut under the pose
/// that was found, and its alignment.
struct Recovery {
  LocalGraph local;
  Alignment alignment;
};

/// Lays a frame on the map from a start that is known as well as the search tells it.
Recovery alignFrom(const Pose& T_map_start, const Frame& frame, const Map& map, const ClassTable& classes,
                   const Config& config);

/// Whether the search alone, without alignment, finds a frame where it was aligned, to two cells of its grid: 1.2 m
/// with leaves of 0.4 m. Some 25 times cheaper than recover().
bool isFoundAt(const Pose& T_map_body, const LocalGraph& local, const Map& map, const SearchReach& reach,
               const Config& config);

/// Whether clearly more of the frame lies on the map in `a` than in `b`.
bool fitsClearlyBetter(const Fit& a, const Fit& b);

/// Lays a frame on the map whose alignment from odometry's prior has collapsed. Starts are `guesses` (T_map_body) and
/// what searchPoses() finds within `reach` of the first of them; from each the frame is created and aligned again, with
/// a prior as loose as the search is coarse. The start with the most leaves on the map wins, if these are at least
/// `least_share` of those the map should know, enough to tell, and clearly more than at any place elsewhere: places
/// that repeat themselves must not be taken for each other. nullopt when there is none.
std::optional<Recovery> recover(const Frame& frame, const Map& map, const std::vector<Pose>& guesses,
                                const SearchReach& reach, double least_share, const ClassTable& classes,
                                const Config& config);

}  // namespace hgg
