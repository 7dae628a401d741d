#pragma once

#include <vector>

#include "sim/scene.h"
#include "truth/walk_grid.h"

namespace hgg {

struct WalkOptions {
  WalkLimits limits;
  double resolution = 0.1;  // m
  double reach = 15.0;      // m from the way, on the ground
  int threads = 1;          // they change the time it takes, nothing else
};

/// The grid while returns are counted.
struct WalkTruth {
  WalkGrid grid;                  // its frame is the scene's
  std::vector<float> counts_to;   // by surface: m, how high a return may lie to count for it
  std::vector<bool> stays_there;  // by object of the scene: returns from others say nothing of the ground
};

/// The surfaces of what stands still at `end_time` (s, the last frame's) near the way (`T_world_body`, one pose a
/// frame), straight from the solids. A surface is judged at the cell's middle; what else stands anywhere in the cell
/// takes room from it (16 places a cell are tried, so that nothing wider than 3.6 cm is missed). Foliage carries
/// nobody, but is in the way.
WalkTruth walkTruth(const Scene& scene, const std::vector<Pose>& T_world_body, double end_time,
                    const WalkOptions& options);

/// Counts a beam that came back from `object` at a point of the scene's frame. On free ground it counts when it lies on
/// the surface; where the way is blocked also when it comes from what blocks it.
void countReturn(WalkTruth& truth, const Vec3& p_world, std::size_t object);

/// The grid, without the islands that no beam met.
WalkGrid finishedGrid(WalkTruth truth);

}  // namespace hgg
