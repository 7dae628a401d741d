#include "sim/motion.h"

#include <algorithm>

namespace hgg {

std::optional<Pose> poseAt(const Scene& scene, std::size_t object, double time) {
  const auto motion = std::ranges::find(scene.motions, object, &Motion::object);
  return motion == scene.motions.end() ? Pose::Identity() : motion->T_world_object(time);
}

void markMotion(std::vector<TruthObject>& objects, const Scene& scene, double end_time) {
  for (TruthObject& object : objects) {
    const auto index = static_cast<std::size_t>(object.id - 1);
    object.dynamic = scene.world.objects[index].dynamic;
    object.gone = !poseAt(scene, index, end_time);
  }
}

}  // namespace hgg
