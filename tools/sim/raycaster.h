#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "sim/bvh.h"
#include "sim/raycast.h"
#include "sim/scene.h"

namespace hgg {

/// Casts rays into a scene at one time. Answers what castRay() answers, in logarithmic time. Keeps a reference to the
/// scene, which must outlive it and not change.
class RayCaster {
 public:
  /// Time 0.
  explicit RayCaster(const Scene& scene);
  RayCaster(Scene&&) = delete;

  /// Poses what moves.
  void setTime(double time);

  /// The nearest hit up to `range_max` m. Safe from many threads while no one sets the time.
  std::optional<Hit> cast(const Ray& ray, double range_max = std::numeric_limits<double>::infinity()) const;

  /// Where a ray that enters the object at `hit` leaves the solid it hit, in m along the ray (>= hit.range): the depth
  /// in which foliage scatters it.
  double leavesAt(const Ray& ray, const Hit& hit) const;

 private:
  /// An object with a motion.
  struct Mover {
    std::vector<std::size_t> solids;
    Bounds bounds;                       // where it was added
    std::optional<Pose> T_object_world;  // at the time set; none: not there
  };
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

  /// The ray in the frame in which the object's solids were added.
  Ray inObject(std::size_t object, const Ray& ray) const;
  Hit hitAt(const Ray& ray, double range, std::size_t solid) const;

  const Scene* scene_;
  std::vector<std::size_t> unbounded_;  // solids: planes
  std::vector<std::size_t> static_;     // solids, the items of static_tree_
  Bvh static_tree_;
  std::vector<Mover> movers_;          // one a motion
  std::vector<std::size_t> mover_of_;  // by object
  std::vector<std::size_t> posed_;     // movers, the items of posed_tree_
  Bvh posed_tree_;
};

}  // namespace hgg
