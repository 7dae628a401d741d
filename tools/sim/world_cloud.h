#pragma once

#include <vector>

#include "sim/scene.h"
#include "truth/cloud.h"

namespace hgg {

struct CloudOptions {
  double spacing = 0.05;               // m between points
  double reach = 25.0;                 // m from the way, on the ground
  std::size_t max_points = 1'500'000;  // about: beyond it the spacing grows
  int threads = 1;                     // they change the time it takes, nothing else
};

/// The labelled reference cloud of a drive: points spread evenly over the surfaces of what stands still at `end_time`
/// (s, the last frame's), near the way (`T_world_body`, one pose a frame). Only surface that could be seen is in it: a
/// point stays when the view to it is free from anywhere on the way within reach, in whatever direction; foliage blocks
/// no view. So the inside of furniture, undersides on the floor and the far sides of houses are left out. Map frame
/// (the first pose's).
std::vector<CloudPoint> sampleSurfaces(const Scene& scene, const std::vector<Pose>& T_world_body, double end_time,
                                       const CloudOptions& options);

}  // namespace hgg
