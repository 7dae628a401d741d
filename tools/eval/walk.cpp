#include "eval/walk.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>

namespace hgg {
namespace {

constexpr double kApart = 0.5;  // m between the poses that are kept

double share(std::size_t part, std::size_t whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : std::numeric_limits<double>::quiet_NaN();
}

/// By cell: whether the way comes near.
std::vector<std::uint8_t> nearWay(const WalkGrid& truth, std::span<const Pose> T_truth_body) {
  std::vector<std::uint8_t> near(truth.cells(), 0);
  std::optional<Vec3> last;
  for (const Pose& pose : T_truth_body) {
    const Vec3 p = truth.T_grid_map * pose.translation();
    if (last && (p - *last).head<2>().norm() < kApart) {
      continue;
    }
    last = p;
    for (int y = 0; y < truth.height; ++y) {
      const double dy = truth.origin_y + (y + 0.5) * truth.resolution - p.y();
      if (std::abs(dy) > kNearWay) {
        continue;
      }
      const double half = std::sqrt(kNearWay * kNearWay - dy * dy);
      const int begin =
          std::max(static_cast<int>(std::ceil((p.x() - half - truth.origin_x) / truth.resolution - 0.5)), 0);
      const int end = std::min(
          static_cast<int>(std::floor((p.x() + half - truth.origin_x) / truth.resolution - 0.5)) + 1, truth.width);
      for (int x = begin; x < end; ++x) {
        near[truth.at(x, y)] = 1;
      }
    }
  }
  return near;
}

/// What a map's walkable cell turns out to be.
enum class Found : std::uint8_t { kFree, kBlocked, kClose, kIsland, kNothing, kNotAsked };

Found foundAt(const WalkGrid& truth, int x, int y, double z) {
  if (x < 0 || y < 0 || x >= truth.width || y >= truth.height || truth.known[truth.at(x, y)] == 0) {
    return Found::kNotAsked;
  }
  const auto surface = surfaceNear(truth, truth.at(x, y), z, kSameSurface);
  if (!surface) {
    return Found::kNothing;
  }
  const WalkSurface& s = truth.surfaces[*surface];
  return s.island                         ? Found::kIsland
         : s.standing == Standing::kFree  ? Found::kFree
         : s.standing == Standing::kClose ? Found::kClose
                                          : Found::kBlocked;
}

/// Whether `is_right` holds of any of the 3 x 3 cells around.
bool anyAround(int x, int y, const std::function<bool(int, int)>& is_right) {
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if (is_right(x + dx, y + dy)) {
        return true;
      }
    }
  }
  return false;
}

/// Where the map may have the k-th surface of a column, relative to its height: no farther than kSameSurface, and not
/// where another one is nearer, such as the top of the box below which the floor is.
HeightRange rangeOf(std::span<const WalkSurface> column, std::size_t k) {
  const auto z = [&](std::size_t i) { return static_cast<double>(column[i].height); };
  return {0.0, k > 0 ? std::max(-kSameSurface, 0.5 * (z(k - 1) - z(k))) : -kSameSurface,
          k + 1 < column.size() ? std::min(kSameSurface, 0.5 * (z(k + 1) - z(k))) : kSameSurface};
}

struct Right {
  std::size_t strict = 0, tolerant = 0;
};

/// The truth's cells, asked of the map.
void askMap(const MapGrid& map, const WalkGrid& truth, const Laying& laying, std::span<const Pose> T_truth_body,
            WalkScore& score) {
  const std::vector<std::uint8_t> near = nearWay(truth, T_truth_body);
  const Pose T_truth_grid = truth.T_grid_map.inverse();
  Right walkable, wrong;  // of the free ones; of the blocked ones
  for (std::size_t cell = 0; cell < truth.cells(); ++cell) {
    const auto column = truth.column(cell);
    for (std::size_t k = 0; k < column.size(); ++k) {
      const WalkSurface& s = column[k];
      if (s.returns == 0 || s.island || s.standing == Standing::kClose) {
        continue;
      }
      const Vec3 p = laying.toMap(T_truth_grid * truth.middle(cell, static_cast<double>(s.height)));
      const int x = static_cast<int>(std::floor((p.x() - map.origin_x) / map.resolution));
      const int y = static_cast<int>(std::floor((p.y() - map.origin_y) / map.resolution));
      const HeightRange around = rangeOf(column, k);
      const HeightRange range{p.z(), p.z() + around.lo, p.z() + around.hi};
      const auto says = [&](Walkability verdict) {
        return [&, verdict](int cx, int cy) { return walkabilityAt(map, cx, cy, range) == verdict; };
      };
      const Walkability verdict = walkabilityAt(map, x, y, range);
      const bool is_walkable = verdict == Walkability::kWalkable;
      const bool is_free = s.standing == Standing::kFree;
      ++score.confusion[is_free ? 0 : 1][static_cast<std::size_t>(verdict)];
      if (is_free && near[cell] != 0) {
        ++score.free_near;
        walkable.strict += is_walkable ? 1 : 0;
        walkable.tolerant += is_walkable || anyAround(x, y, says(Walkability::kWalkable)) ? 1 : 0;
      } else if (!is_free) {
        ++score.blocked_touched;
        wrong.strict += is_walkable ? 1 : 0;
        ++score.causes[s.cause].cells;
        score.causes[s.cause].walkable += is_walkable ? 1 : 0;
        wrong.tolerant += is_walkable && !anyAround(x, y, says(Walkability::kBlocked)) ? 1 : 0;
      }
    }
  }
  score.strict.recall = share(walkable.strict, score.free_near);
  score.tolerant.recall = share(walkable.tolerant, score.free_near);
  score.strict.blocked_called_walkable = share(wrong.strict, score.blocked_touched);
  score.tolerant.blocked_called_walkable = share(wrong.tolerant, score.blocked_touched);
}

/// The map's walkable cells, asked of the truth.
void askTruth(const MapGrid& map, const WalkGrid& truth, const Laying& laying, WalkScore& score) {
  std::size_t forgiven = 0;
  const auto look = [&](int level, int x, int y) {
    const std::size_t i = map.at(level, x, y);
    if (walkabilityOf(map.cost[i]) != Walkability::kWalkable) {
      return;
    }
    const auto height = static_cast<double>(map.heights[i]);
    const Vec3 p_map(map.origin_x + (x + 0.5) * map.resolution, map.origin_y + (y + 0.5) * map.resolution,
                     std::isnan(height) ? map.reference_z : height);
    const Vec3 p = truth.T_grid_map * laying.toTruth(p_map);
    const int tx = static_cast<int>(std::floor((p.x() - truth.origin_x) / truth.resolution));
    const int ty = static_cast<int>(std::floor((p.y() - truth.origin_y) / truth.resolution));
    const Found found = foundAt(truth, tx, ty, p.z());
    const bool is_wrong = found == Found::kBlocked || found == Found::kNothing;
    forgiven +=
        is_wrong && anyAround(tx, ty, [&](int cx, int cy) { return foundAt(truth, cx, cy, p.z()) == Found::kFree; });
    score.free += found == Found::kFree, score.blocked += found == Found::kBlocked;
    score.close += found == Found::kClose, score.islands += found == Found::kIsland;
    score.nothing += found == Found::kNothing;
  };
  for (int level = 0; level < map.levels; ++level) {
    for (int y = 0; y < map.height; ++y) {
      for (int x = 0; x < map.width; ++x) {
        look(level, x, y);
      }
    }
  }
  const std::size_t judged = score.free + score.blocked + score.nothing;
  score.strict.precision = share(score.free, judged);
  score.tolerant.precision = share(score.free + forgiven, judged);
}

}  // namespace

Laying::Laying(const Pose& T_truth_map) : pairs_{{T_truth_map, Pose::Identity(), 0}} {}

Laying::Laying(std::span<const PosePair> pairs) {
  for (const PosePair& pair : pairs) {
    const bool is_new = std::ranges::none_of(pairs_, [&](const PosePair& kept) {
      return (kept.T_truth_body.translation() - pair.T_truth_body.translation()).norm() < kApart;
    });
    if (is_new) {
      pairs_.push_back(pair);
    }
  }
}

Vec3 Laying::toTruth(const Vec3& p_map) const {
  const auto nearest = std::ranges::min_element(
      pairs_, {}, [&](const PosePair& pair) { return (pair.T_map_body.translation() - p_map).squaredNorm(); });
  return nearest->T_truth_body * (nearest->T_map_body.inverse() * p_map);
}

Vec3 Laying::toMap(const Vec3& p_truth) const {
  const auto nearest = std::ranges::min_element(
      pairs_, {}, [&](const PosePair& pair) { return (pair.T_truth_body.translation() - p_truth).squaredNorm(); });
  return nearest->T_map_body * (nearest->T_truth_body.inverse() * p_truth);
}

WalkScore scoreWalk(const MapGrid& map, const WalkGrid& truth, const Laying& laying,
                    std::span<const Pose> T_truth_body) {
  WalkScore score;
  askMap(map, truth, laying, T_truth_body, score);
  askTruth(map, truth, laying, score);
  return score;
}

}  // namespace hgg
