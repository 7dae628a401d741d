#include "sim/world_cloud.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "sim/motion.h"
#include "sim/raycaster.h"
#include "sim/sensor.h"
#include "sim/world_surface.h"

namespace hgg {
namespace {

/// The scene as it stands at a time, for good: what moves by itself is gone.
Scene frozen(const Scene& scene, double time) {
  Scene still{.world = scene.world, .T_world_body = scene.T_world_body, .motions = {}};
  for (const Motion& motion : scene.motions) {
    auto pose = scene.world.objects[motion.object].dynamic ? std::nullopt : motion.T_world_object(time);
    still.motions.push_back({motion.object, [pose = std::move(pose)](double /*now*/) { return pose; }});
  }
  return still;
}

/// From where places are looked at.
class Viewpoints {
 public:
  Viewpoints(const std::vector<Pose>& T_world_body, double reach) : drift_reach_(reach) {
    constexpr double kApart = 0.7;  // m; a second lap adds few
    for (const Pose& pose : T_world_body) {
      const bool is_new = std::ranges::none_of(
          points_, [&](const Vec3& p) { return (pose.translation() - p).squaredNorm() < kApart * kApart; });
      if (is_new) {
        points_.push_back(pose.translation());
      }
    }
  }

  Bounds bounds() const {
    Bounds bounds;
    for (const Vec3& p : points_) {
      bounds = join(bounds, {p - Vec3::Constant(drift_reach_), p + Vec3::Constant(drift_reach_)});
    }
    return bounds;
  }

  /// Whether any viewpoint within reach of `p` sees it: near ones first, but before them that which saw the last place
  /// asked for. Remembers: not for many threads.
  template <typename Sees>
  bool anySees(const Vec3& p, Sees sees) {
    const Cell cell{static_cast<int>(std::floor(p.x() / kCell)), static_cast<int>(std::floor(p.y() / kCell))};
    auto known = cells_.find(cell);
    if (known == cells_.end()) {
      known = cells_.emplace(cell, nearFirst(cell)).first;
    }
    for (std::size_t& i : known->second) {
      if (sees(points_[i])) {
        std::swap(i, known->second.front());
        return true;
      }
    }
    return false;
  }

 private:
  using Cell = std::pair<int, int>;
  static constexpr double kCell = 2.0;

  std::vector<std::size_t> nearFirst(const Cell& cell) const {
    const Eigen::Vector2d center = kCell * Eigen::Vector2d(cell.first + 0.5, cell.second + 0.5);
    std::vector<std::pair<double, std::size_t>> by_distance;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const double distance = (points_[i].head<2>() - center).norm();
      if (distance < drift_reach_) {
        by_distance.emplace_back(distance, i);
      }
    }
    std::ranges::sort(by_distance);
    std::vector<std::size_t> near;
    for (const auto& [distance, i] : by_distance) {
      near.push_back(i);
    }
    return near;
  }

  double drift_reach_;
  std::vector<Vec3> points_;
  std::map<Cell, std::vector<std::size_t>> cells_;
};

/// Whether the view from `eye` to a point of a surface is free.
bool canSee(const RayCaster& caster, const World& world, const Vec3& eye, const Vec3& p) {
  constexpr double kClose = 0.01;  // m before the point: its own surface
  const double distance = (p - eye).norm();
  const Vec3 direction = (p - eye) / distance;
  double passed = 0.0;
  for (;;) {
    const Ray ray{eye + passed * direction, direction};
    const auto hit = caster.cast(ray, distance - kClose - passed);
    if (!hit) {
      return true;
    }
    if (!world.objects[hit->object].foliage) {
      return false;
    }
    passed += caster.leavesAt(ray, *hit) + 1e-6;
    if (passed >= distance - kClose) {
      return true;
    }
  }
}

struct Sampler {
  const Scene& scene;
  const RayCaster& caster;
  Viewpoints viewpoints;  // each thread its own: they remember
  double spacing;

  std::vector<CloudPoint> sample(std::size_t first_solid, std::size_t end_solid, const Pose& T_map_world) {
    std::vector<CloudPoint> cloud;
    const Bounds bounds = viewpoints.bounds();
    for (std::size_t i = first_solid; i < end_solid; ++i) {
      const Solid& solid = scene.world.solids[i];
      if (!poseAt(scene, solid.object, 0.0)) {
        continue;
      }
      const WorldObject& object = scene.world.objects[solid.object];
      sampleSurface(solid.shape, spacing, bounds, [&](const Vec3& p, const Vec3& normal) {
        const auto sees = [&](const Vec3& eye) {
          const bool is_turned_away = !object.foliage && normal.dot(eye - p) < 0.0;
          return !is_turned_away && canSee(caster, scene.world, eye, p);
        };
        if (viewpoints.anySees(p, sees)) {
          const Eigen::Vector3f m = (T_map_world * p).cast<float>();
          cloud.push_back({m.x(), m.y(), m.z(), object.label, object.id});
        }
      });
    }
    return cloud;
  }
};

/// All solids, in blocks over the threads; the order is that of the solids whatever their number.
std::vector<CloudPoint> sampleAll(const Sampler& sampler, const Pose& T_map_world, int threads) {
  constexpr std::size_t kBlocks = 64;
  const std::size_t solids = sampler.scene.world.solids.size();
  std::vector<std::vector<CloudPoint>> parts(kBlocks);
  parallelFor(kBlocks, threads, [&](int block) {
    const auto b = static_cast<std::size_t>(block);
    Sampler mine = sampler;
    parts[b] = mine.sample(b * solids / kBlocks, (b + 1) * solids / kBlocks, T_map_world);
  });
  std::vector<CloudPoint> cloud;
  for (const auto& part : parts) {
    cloud.insert(cloud.end(), part.begin(), part.end());
  }
  return cloud;
}

}  // namespace

std::vector<CloudPoint> sampleSurfaces(const Scene& scene, const std::vector<Pose>& T_world_body, double end_time,
                                       const CloudOptions& options) {
  constexpr double kCoarser = 6.0;
  const Scene still = frozen(scene, end_time);
  const RayCaster caster(still);
  const Pose T_map_world = T_world_body.front().inverse();
  // A coarse cloud first: how many points there are is known only when the hidden ones are gone.
  Sampler sampler{still, caster, Viewpoints(T_world_body, options.reach), kCoarser * options.spacing};
  const auto coarse = static_cast<double>(sampleAll(sampler, T_map_world, options.threads).size());
  const double expected = coarse * kCoarser * kCoarser / static_cast<double>(options.max_points);
  sampler.spacing = options.spacing * std::max(1.0, std::sqrt(expected));
  return sampleAll(sampler, T_map_world, options.threads);
}

}  // namespace hgg
