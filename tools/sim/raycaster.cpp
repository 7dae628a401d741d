#include "sim/raycaster.h"

#include "sim/motion.h"

namespace hgg {
namespace {

/// What is nearest so far; of equally near ones the solid added first, whatever the order they are tried in.
struct Nearest {
  double range;
  std::size_t solid = 0;
  bool found = false;

  bool offer(std::optional<double> at, std::size_t index) {
    if (!at || *at > range || (found && *at == range && index > solid)) {
      return false;
    }
    *this = {*at, index, true};
    return true;
  }
};

Bounds transformed(const Pose& T, const Bounds& b) {
  const Vec3 center = T * Vec3(0.5 * (b.lo + b.hi));
  const Vec3 half = T.linear().cwiseAbs() * (0.5 * (b.hi - b.lo));
  return {center - half, center + half};
}

Ray transformed(const Pose& T, const Ray& ray) { return {T * ray.origin, T.linear() * ray.direction}; }

std::optional<double> intersectSolid(const Solid& solid, const Ray& ray) {
  return std::visit([&](const auto& shape) { return intersect(shape, ray); }, solid.shape);
}

bool isBounded(const Solid& solid) { return !std::holds_alternative<Plane>(solid.shape); }

std::vector<Bounds> boundsOfSolids(const World& world, const std::vector<std::size_t>& solids) {
  std::vector<Bounds> bounds;
  for (const std::size_t solid : solids) {
    bounds.push_back(boundsOf(world.solids[solid].shape));
  }
  return bounds;
}

}  // namespace

RayCaster::RayCaster(const Scene& scene) : scene_(&scene), mover_of_(scene.world.objects.size(), kNone) {
  for (std::size_t i = 0; i < scene.motions.size(); ++i) {
    mover_of_[scene.motions[i].object] = i;
  }
  movers_.resize(scene.motions.size());
  for (std::size_t i = 0; i < scene.world.solids.size(); ++i) {
    const Solid& solid = scene.world.solids[i];
    const std::size_t mover = mover_of_[solid.object];
    if (mover != kNone && isBounded(solid)) {
      movers_[mover].solids.push_back(i);
      movers_[mover].bounds = join(movers_[mover].bounds, boundsOf(solid.shape));
    } else {
      (isBounded(solid) ? static_ : unbounded_).push_back(i);
    }
  }
  static_tree_ = Bvh(boundsOfSolids(scene.world, static_));
  setTime(0.0);
}

void RayCaster::setTime(double time) {
  std::vector<Bounds> bounds;
  posed_.clear();
  for (std::size_t i = 0; i < movers_.size(); ++i) {
    const auto T_world_object = scene_->motions[i].T_world_object(time);
    movers_[i].T_object_world = T_world_object ? std::optional(T_world_object->inverse()) : std::nullopt;
    if (T_world_object && !movers_[i].solids.empty()) {
      posed_.push_back(i);
      bounds.push_back(transformed(*T_world_object, movers_[i].bounds));
    }
  }
  posed_tree_ = Bvh(bounds);
}

Ray RayCaster::inObject(std::size_t object, const Ray& ray) const {
  const std::size_t mover = mover_of_[object];
  return mover == kNone || !movers_[mover].T_object_world ? ray : transformed(*movers_[mover].T_object_world, ray);
}

std::optional<Hit> RayCaster::cast(const Ray& ray, double range_max) const {
  const std::vector<Solid>& solids = scene_->world.solids;
  Nearest nearest{range_max};
  for (const std::size_t solid : unbounded_) {
    nearest.offer(intersectSolid(solids[solid], ray), solid);
  }
  const RaySlabs slabs(ray.origin, ray.direction);
  static_tree_.visit(slabs, nearest.range, [&](std::uint32_t item) {
    nearest.offer(intersectSolid(solids[static_[item]], ray), static_[item]);
  });
  posed_tree_.visit(slabs, nearest.range, [&](std::uint32_t item) {
    const Mover& mover = movers_[posed_[item]];
    const Ray local = transformed(*mover.T_object_world, ray);
    for (const std::size_t solid : mover.solids) {
      nearest.offer(intersectSolid(solids[solid], local), solid);
    }
  });
  return nearest.found ? std::optional(hitAt(ray, nearest.range, nearest.solid)) : std::nullopt;
}

Hit RayCaster::hitAt(const Ray& ray, double range, std::size_t solid) const {
  const std::size_t object = scene_->world.solids[solid].object;
  const Ray local = inObject(object, ray);
  const Vec3 facing = facingNormal(scene_->world.solids[solid].shape, local, range);
  const std::size_t mover = mover_of_[object];
  const bool turned = mover != kNone && movers_[mover].T_object_world.has_value();
  return {range, object, turned ? Vec3(movers_[mover].T_object_world->linear().transpose() * facing) : facing, solid};
}

double RayCaster::leavesAt(const Ray& ray, const Hit& hit) const {
  constexpr double kJustInside = 1e-6;
  const Ray local = inObject(hit.object, ray);
  const double from = hit.range + kJustInside;
  const auto rest =
      intersectSolid(scene_->world.solids[hit.solid], {local.origin + from * local.direction, local.direction});
  return rest ? from + *rest : hit.range;
}

}  // namespace hgg
