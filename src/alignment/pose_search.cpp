#include "alignment/pose_search.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <tuple>

#include "alignment/fit.h"
#include "core/units.h"

namespace hgg {
namespace {

constexpr double kCellLeaves = 1.5;          // edge of a grid cell, in leaf sizes: the leaves of a wall leave no gap
constexpr double kBandCells = 2;             // height of a band, in cells
constexpr std::size_t kMostLeaves = 600;     // of the frame that take part: spread evenly over it
constexpr double kFinestTurn = kDegree / 2;  // rad, of the steps in yaw

/// A leaf as the grid sees it: where it is, and a bit for its class and height.
struct Mark {
  Vec3 mean = Vec3::Zero();
  ClassId label = 0;
};

std::uint64_t bitOf(ClassId label, double z, double band) {
  const auto k = static_cast<std::int64_t>(std::floor(z / band));
  const std::uint64_t mixed =
      (static_cast<std::uint64_t>(label) * 0x9E3779B97F4A7C15U) ^ (static_cast<std::uint64_t>(k) * 0xC2B2AE3D27D4EB4FU);
  return std::uint64_t{1} << (mixed >> 58U);
}

/// The upright leaves of the frame, thinned out, turned as `T_map_body` and about its origin.
std::vector<Mark> marksOf(const LocalGraph& local, const Pose& T_map_body, double radius) {
  std::vector<Mark> marks;
  for (const LocalObject& object : local.objects) {
    const Pose T_map_object = T_map_body * object.T_body_object;
    const Mat3& R = T_map_object.linear();
    for (const LocalLeaf& leaf : object.leaves) {
      const Vec3 mean = T_map_object * leaf.mean;
      const bool is_near = (mean - T_map_body.translation()).head<2>().norm() < radius;
      if (is_near && isUpright(R * leaf.cov * R.transpose())) {
        marks.push_back({mean - Vec3(T_map_body.translation().x(), T_map_body.translation().y(), 0), object.label});
      }
    }
  }
  const std::size_t stride = std::max<std::size_t>(1, (marks.size() + kMostLeaves - 1) / kMostLeaves);
  std::vector<Mark> thinned;
  for (std::size_t k = 0; k < marks.size(); k += stride) {
    thinned.push_back(marks[k]);
  }
  return thinned;
}

/// What the map has in each cell of a square around a centre: a set of bits (bitOf).
class Raster {
 public:
  Raster(const Map& map, const Vec3& centre, double extent, double cell)
      : cell_(cell), half_(static_cast<int>(std::ceil(extent / cell))), bits_(indexOf(0, side())) {
    for (const NodeId id : map.near(centre, std::numbers::sqrt2 * extent + map.tileSize())) {
      const MapNode& node = *map.find(id);
      for (const Leaf& packed : leavesOf(node)) {
        const Belief leaf = transform(node.T_map_object, unpackLeaf(packed));
        if (isUpright(leaf.cov)) {
          mark(leaf.mean - Vec3(centre.x(), centre.y(), 0), node.label);
        }
      }
    }
  }

  int side() const { return 2 * half_ + 1; }
  double band() const { return kBandCells * cell_; }
  int cellOf(double coordinate) const { return static_cast<int>(std::floor(coordinate / cell_)) + half_; }
  std::uint64_t at(int x, int y) const { return bits_[indexOf(x, y)]; }

 private:
  std::size_t indexOf(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(side()) + static_cast<std::size_t>(x);
  }

  /// Leaves near the rim of a band count for the next one too: heights are known to a fraction of it only.
  void mark(const Vec3& p, ClassId label) {
    const int x = cellOf(p.x()), y = cellOf(p.y());
    if (x >= 0 && y >= 0 && x < side() && y < side()) {
      const double slack = band() / 4;
      bits_[indexOf(x, y)] |= bitOf(label, p.z() - slack, band()) | bitOf(label, p.z() + slack, band());
    }
  }

  double cell_;
  int half_;
  std::vector<std::uint64_t> bits_;
};

/// A pose of the search: yaw step, cells in x and y, and the leaves that lie on the map there.
struct Place {
  int score = 0;
  int turn = 0, x = 0, y = 0;
};

/// The leaves of a frame in cells, turned by one yaw.
struct Turned {
  std::vector<std::tuple<int, int, std::uint64_t>> cells;  // x, y, bit
};

Turned turnedBy(const std::vector<Mark>& marks, double yaw, const Raster& raster) {
  const double c = std::cos(yaw), s = std::sin(yaw);
  Turned turned;
  for (const Mark& mark : marks) {
    const double x = c * mark.mean.x() - s * mark.mean.y(), y = s * mark.mean.x() + c * mark.mean.y();
    turned.cells.emplace_back(raster.cellOf(x), raster.cellOf(y), bitOf(mark.label, mark.mean.z(), raster.band()));
  }
  return turned;
}

int scoreOf(const Turned& turned, const Raster& raster, int dx, int dy) {
  int score = 0;
  for (const auto& [x, y, bit] : turned.cells) {
    score += (raster.at(x + dx, y + dy) & bit) != 0 ? 1 : 0;
  }
  return score;
}

/// Steps in yaw so fine that the leaves move by no more than a cell from one to the next.
double turnStep(const std::vector<Mark>& marks, double cell) {
  double square = 0;
  for (const Mark& mark : marks) {
    square += mark.mean.head<2>().squaredNorm();
  }
  return std::max(kFinestTurn, cell / std::max(cell, std::sqrt(square / static_cast<double>(marks.size()))));
}

Pose poseAt(const Pose& T_map_body, const Place& place, double turn_step, double cell) {
  Pose T = T_map_body;
  T.linear() = Eigen::AngleAxisd(place.turn * turn_step, Vec3::UnitZ()).toRotationMatrix() * T_map_body.linear();
  T.translation() += cell * Vec3(place.x, place.y, 0);
  return T;
}

}  // namespace

bool areDistinctPoses(const Pose& a, const Pose& b) {
  const Pose off = a.inverse() * b;
  return off.translation().norm() > kDistinctDistance || turnOf(off) > kDistinctTurn;
}

std::vector<Pose> searchPoses(const LocalGraph& local, const Map& map, const Pose& T_map_body, const SearchReach& reach,
                              double radius, double leaf_size, std::size_t count) {
  const double cell = kCellLeaves * leaf_size;
  const std::vector<Mark> marks = marksOf(local, T_map_body, radius);
  if (marks.empty()) {
    return {};
  }
  const Raster raster(map, T_map_body.translation(), radius + reach.distance + 2 * cell, cell);
  const double turn_step = turnStep(marks, cell);
  const int turns = static_cast<int>(std::ceil(reach.turn / turn_step));
  const int cells = static_cast<int>(std::ceil(reach.distance / cell));
  std::vector<Place> places;
  for (int turn = -turns; turn <= turns; ++turn) {
    const Turned turned = turnedBy(marks, turn * turn_step, raster);
    for (int y = -cells; y <= cells; ++y) {
      for (int x = -cells; x <= cells; ++x) {
        places.push_back({scoreOf(turned, raster, x, y), turn, x, y});
      }
    }
  }
  const auto nearness = [](const Place& p) { return p.x * p.x + p.y * p.y + p.turn * p.turn; };
  std::stable_sort(places.begin(), places.end(), [&](const Place& a, const Place& b) {
    return a.score != b.score ? a.score > b.score : nearness(a) < nearness(b);
  });
  std::vector<Pose> found;
  for (std::size_t k = 0; k < places.size() && found.size() < count; ++k) {
    const Pose T = poseAt(T_map_body, places[k], turn_step, cell);
    if (std::ranges::none_of(found, [&](const Pose& other) { return !areDistinctPoses(T, other); })) {
      found.push_back(T);
    }
  }
  return found;
}

}  // namespace hgg
