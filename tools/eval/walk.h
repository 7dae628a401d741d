#pragma once

#include <map>
#include <span>
#include <vector>

#include "eval/map_grid.h"
#include "eval/trajectory.h"
#include "truth/walk_grid.h"

namespace hgg {

/// Lays a map over the truth.
class Laying {
 public:
  /// All of it by one transform.
  explicit Laying(const Pose& T_truth_map);
  /// Every place by the pose nearest to it: what is left of the drift does not count, as it does not for a robot that
  /// knows its place in the map.
  explicit Laying(std::span<const PosePair> pairs);

  Vec3 toTruth(const Vec3& p_map) const;
  Vec3 toMap(const Vec3& p_truth) const;

 private:
  std::vector<PosePair> pairs_;  // thinned
};

/// Shares of cells; NaN where there is none to take a share of.
struct WalkShares {
  double blocked_called_walkable = 0;  // of the truly blocked ones
  double precision = 0;                // of the map's walkable ones that can be walked on
  double recall = 0;                   // of the truly free ones near the way that the map calls walkable
};

/// How a map's grid compares with the truth. The truth's cells are ground a beam came back from; those near a limit are
/// left out.
struct WalkScore {
  std::size_t confusion[2][3] = {};  // truth: free, blocked; map: as Walkability
  /// The map's walkable cells where the truth knows the ground: free, blocked, near a limit, islands, and those with no
  /// surface at their height. Precision: free of (free + blocked + nothing there).
  std::size_t free = 0, blocked = 0, close = 0, islands = 0, nothing = 0;
  std::size_t free_near = 0, blocked_touched = 0;  // truly free within kNearWay, truly blocked
  /// Truly blocked cells by what blocks them (WalkSurface::cause), and those of them that the map calls walkable.
  struct Cause {
    std::size_t cells = 0, walkable = 0;
  };
  std::map<ClassId, Cause> causes;
  WalkShares strict;    // cell for cell
  WalkShares tolerant;  // right when any of the 3 x 3 cells around is
};

inline constexpr double kNearWay = 12.0;     // m, how far from the way free ground is asked for
inline constexpr double kSameSurface = 0.3;  // m, surfaces of map and truth this near in height are one

/// `T_truth_body`: the way.
WalkScore scoreWalk(const MapGrid& map, const WalkGrid& truth, const Laying& laying,
                    std::span<const Pose> T_truth_body);

}  // namespace hgg
