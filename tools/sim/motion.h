#pragma once

#include <vector>

#include "sim/scene.h"
#include "truth/objects.h"

namespace hgg {

/// nullopt when the object is not there at that time; identity for what never moves.
std::optional<Pose> poseAt(const Scene& scene, std::size_t object, double time);

/// Marks what moved by itself (`dynamic`) and what was taken away by `end_time` (`gone`). Ids are the scene's.
void markMotion(std::vector<TruthObject>& objects, const Scene& scene, double end_time);

}  // namespace hgg
