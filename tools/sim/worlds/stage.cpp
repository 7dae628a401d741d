#include "sim/worlds/stage.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace hgg {
namespace {

constexpr double kCell = 4.0;  // m, of the grid over the ways

Shape moved(const Plane& plane, const Pose& T) { return Plane{T * plane.point, T.linear() * plane.normal}; }
Shape moved(const Box& box, const Pose& T) { return Box{T * box.T_world_box, box.half}; }
Shape moved(const Cylinder& cylinder, const Pose& T) {
  return Cylinder{T * cylinder.base, cylinder.radius, cylinder.height};
}
Shape moved(const Ellipsoid& ellipsoid, const Pose& T) { return Ellipsoid{T * ellipsoid.center, ellipsoid.half}; }
Shape moved(const Triangle& t, const Pose& T) { return Triangle{T * t.a, T * t.b, T * t.c}; }

std::int64_t cellOf(const Vec2& p) {
  const auto x = static_cast<std::int64_t>(std::floor(p.x() / kCell));
  const auto y = static_cast<std::int64_t>(std::floor(p.y() / kCell));
  return x * (std::int64_t{1} << 32) + y;
}

Vec2 axis(const Footprint& f, int i) {
  return i == 0 ? Vec2(std::cos(f.yaw), std::sin(f.yaw)) : Vec2(-std::sin(f.yaw), std::cos(f.yaw));
}

double reachAlong(const Footprint& f, const Vec2& direction) {
  return f.half.x() * std::abs(axis(f, 0).dot(direction)) + f.half.y() * std::abs(axis(f, 1).dot(direction));
}

}  // namespace

Pose poseOf(const Spot& spot) {
  Pose pose = Pose::Identity();
  pose.translation() = spot.ground;
  pose.linear() = Eigen::AngleAxisd(spot.yaw, Vec3::UnitZ()).toRotationMatrix();
  return pose;
}

Shapes placed(const Shapes& local, const Spot& spot) { return moved(local, poseOf(spot)); }

Shapes moved(const Shapes& local, const Pose& T) {
  Shapes result;
  for (const Shape& shape : local) {
    result.push_back(std::visit([&](const auto& s) { return moved(s, T); }, shape));
  }
  return result;
}

Box block(double x, double y, double z, double length, double width, double height) {
  return uprightBox(Vec3(x, y, z), Vec3(length, width, height), 0.0);
}

Shapes personShapes(Dice& dice, double stride) {
  const double height = dice.between(1.6, 1.9), hip = 0.5 * height;
  const double step = 0.2 * stride;
  return {Cylinder{Vec3(step, 0.1, 0.0), 0.08, hip}, Cylinder{Vec3(-step, -0.1, 0.0), 0.08, hip},
          Ellipsoid{Vec3(0, 0, hip + 0.17 * height), Vec3(0.2, 0.2, 0.2 * height)},
          Ellipsoid{Vec3(0, 0, 0.93 * height), Vec3(0.1, 0.1, 0.07 * height)}};
}

Footprint footprintOf(const Shapes& local, const Spot& spot) {
  constexpr double kOverhead = 2.5;  // m: one may pass below
  Bounds bounds;
  for (const Shape& shape : local) {
    const Bounds b = boundsOf(shape);
    bounds = b.lo.z() < kOverhead ? join(bounds, b) : bounds;
  }
  const Vec3 center = poseOf(spot) * Vec3(0.5 * (bounds.lo + bounds.hi));
  return {center.head<2>(), 0.5 * (bounds.hi - bounds.lo).head<2>(), spot.yaw};
}

double gapBetween(const Footprint& a, const Footprint& b) {
  double gap = 0.0;
  for (const Vec2& direction : {axis(a, 0), axis(a, 1), axis(b, 0), axis(b, 1)}) {
    const double apart = std::abs((a.center - b.center).dot(direction));
    gap = std::max(gap, apart - reachAlong(a, direction) - reachAlong(b, direction));
  }
  return gap;
}

double distanceTo(const Footprint& a, const Vec2& p) {
  const Vec2 local(axis(a, 0).dot(p - a.center), axis(a, 1).dot(p - a.center));
  return (local.cwiseAbs() - a.half).cwiseMax(0.0).norm();
}

void Layout::keepOff(const std::vector<Vec2>& points, double clearance) {
  clearance_ = std::max(clearance_, clearance);
  for (const Vec2& p : points) {
    ways_[cellOf(p)].push_back(p);
  }
}

bool Layout::isFree(const Footprint& footprint, double gap) const {
  if (std::ranges::any_of(taken_, [&](const Footprint& other) { return gapBetween(footprint, other) < gap; })) {
    return false;
  }
  const double reach = footprint.half.norm() + clearance_ + kCell;
  for (double dx = -reach; dx <= reach; dx += kCell) {
    for (double dy = -reach; dy <= reach; dy += kCell) {
      const auto cell = ways_.find(cellOf(footprint.center + Vec2(dx, dy)));
      if (cell != ways_.end() &&
          std::ranges::any_of(cell->second, [&](const Vec2& p) { return distanceTo(footprint, p) < clearance_; })) {
        return false;
      }
    }
  }
  return true;
}

void addGround(World& world, const std::vector<double>& xs, const std::vector<double>& ys, const Height& height,
               const std::function<std::optional<std::size_t>(const Vec2& center)>& object_of) {
  const auto corner = [&](std::size_t i, std::size_t j) { return Vec3(xs[i], ys[j], height(Vec2(xs[i], ys[j]))); };
  for (std::size_t i = 0; i + 1 < xs.size(); ++i) {
    for (std::size_t j = 0; j + 1 < ys.size(); ++j) {
      const auto object = object_of(Vec2(0.5 * (xs[i] + xs[i + 1]), 0.5 * (ys[j] + ys[j + 1])));
      if (object) {
        addSolid(world, *object, Triangle{corner(i, j), corner(i + 1, j), corner(i + 1, j + 1)});
        addSolid(world, *object, Triangle{corner(i, j), corner(i + 1, j + 1), corner(i, j + 1)});
      }
    }
  }
}

std::vector<double> gridLines(const std::vector<double>& stops, double widest) {
  std::vector<double> lines{stops.front()};
  for (std::size_t i = 1; i < stops.size(); ++i) {
    const double steps = std::ceil((stops[i] - stops[i - 1]) / widest);
    for (double k = 1; k <= steps; ++k) {
      lines.push_back(stops[i - 1] + (stops[i] - stops[i - 1]) * (k / steps));
    }
  }
  return lines;
}

namespace {

constexpr double kHalfBody = 0.5;  // m: the slope is felt between its ends

/// `ahead`, `behind`: the ground below the ends of the body.
Pose bodyAt(const WayPoint& at, double ground, double ahead, double behind, const Gait& gait, double time) {
  const double rise = (ahead - behind) / 2.0;
  Pose pose = Pose::Identity();
  pose.translation() << at.position, ground + gait.height + gait.bob * std::sin(kTau * time / 1.3);
  pose.linear() =
      (Eigen::AngleAxisd(std::atan2(at.along.y(), at.along.x()), Vec3::UnitZ()) *
       Eigen::AngleAxisd(gait.sway * std::sin(kTau * time / 2.9) - std::atan2(rise, kHalfBody), Vec3::UnitY()) *
       Eigen::AngleAxisd(gait.sway * std::sin(kTau * time / 3.7), Vec3::UnitX()))
          .toRotationMatrix();
  return pose;
}

}  // namespace

std::function<Pose(double)> bodyOn(const Journey& travel, const Height& ground, const Gait& gait) {
  return [=](double time) {
    const WayPoint at = travel.way().at(travel.progress(time));
    return bodyAt(at, ground(at.position), ground(at.position + kHalfBody * at.along),
                  ground(at.position - kHalfBody * at.along), gait, time);
  };
}

std::function<Pose(double)> bodyAlong(const Journey& travel, const std::function<double(double s)>& ground,
                                      const Gait& gait) {
  return [=](double time) {
    const double s = travel.progress(time);
    return bodyAt(travel.way().at(s), ground(s), ground(s + kHalfBody), ground(s - kHalfBody), gait, time);
  };
}

std::optional<std::size_t> Stage::put(const WorldObject& object, const Shapes& local, const Spot& spot, double gap) {
  const Footprint footprint = footprintOf(local, spot);
  if (!layout_.isFree(footprint, gap)) {
    return std::nullopt;
  }
  layout_.claim(footprint);
  return addObject(scene_.world, object, placed(local, spot));
}

void Stage::send(WorldObject object, const Shapes& local, const Journey& travel, double start) {
  constexpr double kAgain = 0.07;  // of the way
  for (int i = 0; static_cast<double>(i) * kAgain < 1.0; ++i) {
    const double s = std::fmod(start + kAgain * i * travel.way().length(), travel.way().length());
    if (keepsClear(local, travel, travel.timeAt(s))) {
      addMover(std::move(object), local, travel, travel.timeAt(s));
      return;
    }
  }
}

bool Stage::keepsClear(const Shapes& local, const Journey& travel, double start_time) const {
  constexpr double kStep = 0.2, kBody = 0.35;
  const Footprint mover = footprintOf(local, {Vec3::Zero(), 0.0});
  for (double time = 0.0; time < scene_.duration; time += kStep) {
    const WayPoint at = travel.way().at(travel.progress(start_time + time));
    const Footprint there{at.position, mover.half, std::atan2(at.along.y(), at.along.x())};
    if (distanceTo(there, scene_.T_world_body(time).translation().head<2>()) < kBody) {
      return false;
    }
  }
  return true;
}

void Stage::addMover(WorldObject object, const Shapes& local, const Journey& travel, double start_time) {
  object.dynamic = true;
  const auto pose_at = [travel, start_time, ground = ground_](double time) {
    const WayPoint at = travel.way().at(travel.progress(start_time + time));
    return poseOf(
        {Vec3(at.position.x(), at.position.y(), ground(at.position)), std::atan2(at.along.y(), at.along.x())});
  };
  const std::size_t index = addObject(scene_.world, std::move(object), moved(local, pose_at(0.0)));
  const Pose T_start_world = pose_at(0.0).inverse();
  scene_.motions.push_back({index, [=](double time) { return std::optional(pose_at(time) * T_start_world); }});
}

void Stage::takeAway(std::size_t object, double time) {
  scene_.motions.push_back(
      {object, [time](double now) { return now < time ? std::optional(Pose::Identity()) : std::nullopt; }});
}

void Stage::bring(std::size_t object, double time) {
  scene_.motions.push_back(
      {object, [time](double now) { return now < time ? std::nullopt : std::optional(Pose::Identity()); }});
}

double Stage::changeTime(std::size_t object) const {
  constexpr double kStep = 0.5;
  const auto solid = std::ranges::find(scene_.world.solids, object, &Solid::object);
  const auto apart = [&](double time) {
    return (scene_.T_world_body(time).translation() - solid->bound_center).norm();
  };
  double nearest = 0.0;
  for (double time = 0.0; time < lap_time_; time += kStep) {
    nearest = apart(time) < apart(nearest) ? time : nearest;
  }
  double farthest = nearest;
  for (double time = nearest; time < nearest + lap_time_; time += kStep) {
    farthest = apart(time) > apart(farthest) ? time : farthest;
  }
  return farthest;
}

}  // namespace hgg
