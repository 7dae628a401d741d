#include "eval/ghosts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <unordered_map>

namespace hgg {
namespace {

constexpr double kOnThing = 2.0;  // deviations of its points: an even line or face ends at 1.73
constexpr double kSlackShare = 1.0 / 6.0, kSurfaceShare = 0.2;  // of the radius
constexpr double kTrackGap = 5.0;         // m: it was out of sight in between, and nobody knows where it went
constexpr std::size_t kMostLeaves = 200;  // looked at of a ghost

/// Squared deviations of a place from a thing's points.
double deviations(const Vec3& p, const Belief& thing, double slack) {
  const Mat3 cov = thing.cov + slack * slack * Mat3::Identity();
  const Vec3 error = p - thing.mean;
  return error.dot(cov.inverse() * error);
}

/// m from a place to a track, seen from above.
double distanceTo(const std::vector<Vec3>& track, const Vec3& p) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < track.size(); ++i) {
    const auto from = track[i].head<2>(), to = track[std::min(i + 1, track.size() - 1)].head<2>();
    const Eigen::Vector2d step = to - from, off = p.head<2>() - from;
    const bool is_seen = step.norm() > 0 && step.norm() < kTrackGap;
    const double share = is_seen ? std::clamp(off.dot(step) / step.squaredNorm(), 0.0, 1.0) : 0.0;
    nearest = std::min(nearest, (off - share * step).norm());
  }
  return nearest;
}

/// Places of the reference cloud by their cell.
class Surfaces {
 public:
  Surfaces(std::span<const CloudPoint> cloud, double reach) : cloud_(cloud), reach_(reach) {
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      cells_[keyOf(cellOf(positionOf(cloud[i])))].push_back(static_cast<std::uint32_t>(i));
    }
  }

  /// The nearest place within reach; nullptr when there is none.
  const CloudPoint* near(const Vec3& p) const {
    const CloudPoint* nearest = nullptr;
    double distance = reach_;
    const Cell at = cellOf(p);
    for (int n = 0; n < 27; ++n) {
      const auto cell = cells_.find(keyOf({at[0] + n % 3 - 1, at[1] + n / 3 % 3 - 1, at[2] + n / 9 - 1}));
      for (std::size_t k = 0; cell != cells_.end() && k < cell->second.size(); ++k) {
        const CloudPoint& place = cloud_[cell->second[k]];
        if ((positionOf(place) - p).norm() < distance) {
          distance = (positionOf(place) - p).norm();
          nearest = &place;
        }
      }
    }
    return nearest;
  }

 private:
  using Cell = std::array<std::int64_t, 3>;
  static Vec3 positionOf(const CloudPoint& p) { return Eigen::Vector3f(p.x, p.y, p.z).cast<double>(); }
  Cell cellOf(const Vec3& p) const {
    const auto along = [&](double x) { return static_cast<std::int64_t>(std::floor(x / reach_)); };
    return {along(p.x()), along(p.y()), along(p.z())};
  }
  static std::int64_t keyOf(const Cell& cell) {  // 21 bits each
    const auto part = [](std::int64_t x) { return (x + (std::int64_t{1} << 20)) & ((std::int64_t{1} << 21) - 1); };
    return part(cell[0]) << 42 | part(cell[1]) << 21 | part(cell[2]);
  }

  std::span<const CloudPoint> cloud_;
  double reach_;
  std::unordered_map<std::int64_t, std::vector<std::uint32_t>> cells_;
};

/// Where a prediction's surface is: some of its leaves, else its mean.
std::vector<Vec3> placesOf(const MappedObject& object) {
  std::vector<Vec3> places;
  const std::size_t step = object.geometry.size() / kMostLeaves + 1;
  for (std::size_t i = 0; i < object.geometry.size(); i += step) {
    places.push_back(object.geometry[i].mean);
  }
  return places.empty() ? std::vector<Vec3>{object.belief.mean} : places;
}

/// The true object most of the places lie on, if most lie on one class's surface: label and id.
std::optional<std::pair<ClassId, std::int64_t>> surfaceBelow(const std::vector<Vec3>& places,
                                                             const Surfaces& surfaces) {
  std::map<ClassId, std::map<std::int64_t, std::size_t>> on;
  std::map<ClassId, std::size_t> total;
  for (const Vec3& p : places) {
    if (const CloudPoint* below = surfaces.near(p)) {
      ++on[below->label][below->object];
      ++total[below->label];
    }
  }
  for (const auto& [label, number] : total) {
    if (2 * number > places.size()) {
      const auto most = std::ranges::max_element(on[label], {}, [](const auto& entry) { return entry.second; });
      return std::pair(label, most->first);
    }
  }
  return std::nullopt;
}

struct Judge {
  std::span<const TruthObject> truth;
  const Surfaces& surfaces;
  double radius;

  /// The true object a place lies on, the nearest by its deviations, among those that `fits` names; 0: none.
  template <typename Fits>
  std::int64_t thingAt(const Vec3& p, Fits fits) const {
    std::int64_t id = 0;
    double least = kOnThing * kOnThing;
    for (const TruthObject& object : truth) {
      const double off = fits(object) ? deviations(p, object.belief, kSlackShare * radius) : least;
      if (off < least) {
        least = off;
        id = object.id;
      }
    }
    return id;
  }

  /// Something that moves and came by; 0: none.
  template <typename Fits>
  std::int64_t moverAt(const Vec3& p, Fits fits) const {
    std::int64_t id = 0;
    double nearest = radius;
    for (const TruthObject& object : truth) {
      const double off = object.dynamic && fits(object) ? distanceTo(object.track, p) : nearest;
      if (off < nearest) {
        nearest = off;
        id = object.id;
      }
    }
    return id;
  }

  Ghost judge(const MappedObject& ghost) const {
    const Vec3& p = ghost.belief.mean;
    const auto is_same = [&](const TruthObject& t) { return t.label == ghost.label; };
    const auto stays = [&](const TruthObject& t) { return is_same(t) && !t.dynamic && !t.gone; };
    if (const std::int64_t id = thingAt(p, stays)) {
      return {ghost.id, GhostCause::kSecond, id};
    }
    if (const std::int64_t id = moverAt(p, is_same)) {
      return {ghost.id, GhostCause::kMover, id};
    }
    if (const std::int64_t id = thingAt(p, [&](const TruthObject& t) { return is_same(t) && t.gone; })) {
      return {ghost.id, GhostCause::kGone, id};
    }
    if (const auto below = surfaceBelow(placesOf(ghost), surfaces)) {
      return {ghost.id, below->first == ghost.label ? GhostCause::kSecond : GhostCause::kSurface, below->second};
    }
    if (const std::int64_t id = moverAt(p, [](const TruthObject&) { return true; })) {
      return {ghost.id, GhostCause::kMover, id};
    }
    if (const std::int64_t id = thingAt(p, [&](const TruthObject& t) { return !is_same(t) && !t.dynamic; })) {
      return {ghost.id, GhostCause::kSurface, id};
    }
    return {ghost.id, GhostCause::kNothing, 0};
  }
};

/// The nearest true object of the prediction's class within the radius; nullptr: none.
const TruthObject* nearestOfClass(const MappedObject& prediction, std::span<const TruthObject> truth, double radius) {
  const TruthObject* nearest = nullptr;
  double distance = radius;
  for (const TruthObject& object : truth) {
    const double apart = (object.belief.mean - prediction.belief.mean).norm();
    if (object.label == prediction.label && apart <= distance) {
      distance = apart;
      nearest = &object;
    }
  }
  return nearest;
}

}  // namespace

std::string nameOf(GhostCause cause) {
  switch (cause) {
    case GhostCause::kSecond:
      return "second";
    case GhostCause::kMover:
      return "mover";
    case GhostCause::kGone:
      return "gone";
    case GhostCause::kSurface:
      return "surface";
    case GhostCause::kNothing:
      break;
  }
  return "nothing";
}

std::vector<Twins> findTwins(std::span<const MappedObject> predictions, std::span<const TruthObject> truth,
                             double radius) {
  std::vector<Twins> twins;
  for (const MappedObject& a : predictions) {
    for (const MappedObject& b : predictions) {
      const double apart = (a.belief.mean - b.belief.mean).norm();
      if (a.stuff || b.stuff || a.dynamic || b.dynamic || a.id >= b.id || a.label != b.label || apart > kTwinReach) {
        continue;
      }
      const TruthObject *of_a = nearestOfClass(a, truth, radius), *of_b = nearestOfClass(b, truth, radius);
      if (of_a != nullptr && of_a == of_b) {
        twins.push_back({a.id, b.id, of_a->id, apart});
      }
    }
  }
  std::ranges::sort(twins, {}, [](const Twins& t) { return std::pair(t.a, t.b); });
  return twins;
}

MovingScore scoreMoving(std::span<const MappedObject> predictions, std::span<const TruthObject> truth, double radius) {
  MovingScore score;
  std::set<std::int64_t> said;
  const Surfaces none({}, kSurfaceShare * radius);
  for (const MappedObject& p : predictions) {
    const Judge judge{truth, none, radius};
    const auto is_same = [&](const TruthObject& t) { return t.label == p.label; };
    if (!p.dynamic || p.stuff) {
      continue;
    }
    if (const std::int64_t id = judge.moverAt(p.belief.mean, is_same)) {
      said.insert(id);
    } else {
      const bool is_parked =
          judge.thingAt(p.belief.mean, [&](const TruthObject& t) { return is_same(t) && !t.dynamic; }) != 0;
      (is_parked ? score.parked : score.elsewhere).push_back(p.id);
    }
  }
  for (const TruthObject& object : truth) {
    const bool counts = object.dynamic && object.frames >= kSeenFrames;
    score.truth += counts ? 1 : 0;
    score.said += counts && said.contains(object.id) ? 1 : 0;
  }
  return score;
}

std::vector<Ghost> explainGhosts(std::span<const MappedObject> predictions, std::span<const TruthObject> truth,
                                 const ObjectEvaluation& evaluation, std::span<const CloudPoint> cloud, double radius) {
  std::vector<Ghost> ghosts;
  const Surfaces surfaces(cloud, kSurfaceShare * radius);
  const std::set<NodeId> ids(evaluation.overall.ghosts.begin(), evaluation.overall.ghosts.end());
  for (const MappedObject& prediction : predictions) {
    if (ids.contains(prediction.id)) {
      ghosts.push_back(Judge{truth, surfaces, radius}.judge(prediction));
    }
  }
  std::ranges::sort(ghosts, {}, &Ghost::prediction);
  return ghosts;
}

}  // namespace hgg
