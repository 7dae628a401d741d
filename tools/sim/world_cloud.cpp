#include "sim/world_cloud.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <thread>

#include "sim/motion.h"
#include "sim/raycaster.h"
#include "sim/world_surface.h"

namespace hgg {
namespace {

/// The scene as it stands at a time, for good: what moves by itself is gone.
Scene frozen(const Scene& scene, double time) {
  Scene still{.world = scene.world, .T_world_body = scene.T_world_body, .motions = {}};
  for (const Motion& motion : scene.motions) {
    const auto pose = scene.world.objects[motion.object].dynamic ? std::nullopt : motion.T_world_object(time);
    still.motions.push_back({motion.object, [pose](double /*now*/) { return pose; }});
  }
  return still;
}

/// From where a place is looked at: some of the viewpoints near it, near ones first.
class Viewpoints {
 public:
  Viewpoints(const std::vector<Pose>& T_world_body, double reach) : reach_(reach) {
    constexpr double kApart = 0.7;  // m
    for (const Pose& pose : T_world_body) {
      if (points_.empty() || (pose.translation() - points_.back()).norm() > kApart) {
        points_.push_back(pose.translation());
      }
    }
  }

  Bounds bounds() const {
    Bounds bounds;
    for (const Vec3& p : points_) {
      bounds = join(bounds, {p - Vec3::Constant(reach_), p + Vec3::Constant(reach_)});
    }
    return bounds;
  }

  /// Empty when the place is out of reach. Remembers answers: not for many threads.
  const std::vector<Vec3>& near(const Vec3& p) {
    const Cell cell{static_cast<int>(std::floor(p.x() / kCell)), static_cast<int>(std::floor(p.y() / kCell))};
    const auto known = cells_.find(cell);
    return known != cells_.end() ? known->second : cells_.emplace(cell, choose(cell)).first->second;
  }

 private:
  using Cell = std::pair<int, int>;
  static constexpr double kCell = 2.0;

  std::vector<Vec3> choose(const Cell& cell) const {
    const Eigen::Vector2d center = kCell * Eigen::Vector2d(cell.first + 0.5, cell.second + 0.5);
    std::vector<std::pair<double, std::size_t>> by_distance;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const double distance = (points_[i].head<2>() - center).norm();
      if (distance < reach_) {
        by_distance.emplace_back(distance, i);
      }
    }
    std::ranges::sort(by_distance);
    // The nearest, and ever farther ones, so that the angles differ.
    std::vector<Vec3> chosen;
    for (std::size_t rank = 0; rank < by_distance.size(); rank = 2 * rank + 1) {
      chosen.push_back(points_[by_distance[rank].second]);
    }
    return chosen;
  }

  double reach_;
  std::vector<Vec3> points_;
  std::map<Cell, std::vector<Vec3>> cells_;
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
  Viewpoints viewpoints;  // each its own: it remembers
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
        if (std::ranges::any_of(viewpoints.near(p), sees)) {
          const Eigen::Vector3f m = (T_map_world * p).cast<float>();
          cloud.push_back({m.x(), m.y(), m.z(), object.label, object.id});
        }
      });
    }
    return cloud;
  }
};

/// All solids, in blocks over some threads; the order is that of the solids whatever their number.
std::vector<CloudPoint> sampleAll(const Sampler& sampler, const Pose& T_map_world) {
  const std::size_t solids = sampler.scene.world.solids.size();
  const std::size_t workers = std::max(1U, std::thread::hardware_concurrency()), blocks = 16 * workers;
  std::vector<std::vector<CloudPoint>> parts(blocks);
  std::vector<std::thread> threads;
  for (std::size_t w = 0; w < workers; ++w) {
    threads.emplace_back([&, w, mine = sampler]() mutable {
      for (std::size_t b = w; b < blocks; b += workers) {
        parts[b] = mine.sample(b * solids / blocks, (b + 1) * solids / blocks, T_map_world);
      }
    });
  }
  std::vector<CloudPoint> cloud;
  for (std::size_t w = 0; w < workers; ++w) {
    threads[w].join();
  }
  for (const auto& part : parts) {
    cloud.insert(cloud.end(), part.begin(), part.end());
  }
  return cloud;
}

}  // namespace

std::vector<CloudPoint> sampleSurfaces(const Scene& scene, const std::vector<Pose>& T_world_body,
                                       const CloudOptions& options) {
  constexpr double kFrame_s = 0.1;
  constexpr double kCoarser = 6.0;
  const double end_time = options.end_time.value_or(kFrame_s * static_cast<double>(T_world_body.size() - 1));
  const Scene still = frozen(scene, end_time);
  const RayCaster caster(still);
  const Pose T_map_world = T_world_body.front().inverse();
  // A coarse cloud first: how many points there are is known only when the hidden ones are gone.
  Sampler sampler{still, caster, Viewpoints(T_world_body, options.reach), kCoarser * options.spacing};
  const auto coarse = static_cast<double>(sampleAll(sampler, T_map_world).size());
  const double expected = coarse * kCoarser * kCoarser / static_cast<double>(options.max_points);
  sampler.spacing = options.spacing * std::max(1.0, std::sqrt(expected));
  return sampleAll(sampler, T_map_world);
}

}  // namespace hgg
