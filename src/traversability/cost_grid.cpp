#include "traversability/cost_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/units.h"
#include "traversability/fill.h"
#include "traversability/sight.h"
#include "traversability/walked.h"

namespace hgg {
namespace {

/// Height of a kerb over the standard deviation of points of which half lie on it and half before it.
constexpr double kUneven = 2;

/// The surface of a column that a foot at `height` would step to: the nearest in height.
const Support* nearestTo(std::span<const Support> column, float height) {
  const Support* best = nullptr;
  for (const Support& s : column) {
    if (best == nullptr || std::abs(s.height - height) < std::abs(best->height - height)) {
      best = &s;
    }
  }
  return best;
}

/// Height from a surface to the one that a foot would step to in a column beside it, m; 0 where there is none. What
/// stands there is no step but stands there: its own column is blocked, and the footprint keeps away from it.
double stepTo(std::span<const Support> column, const Support& s, const TraversabilityConfig& limits) {
  const auto body = static_cast<float>(limits.body_height), step = static_cast<float>(limits.step_height);
  bool stands = false, all_above = true;
  for (const Support& other : column) {
    all_above = all_above && other.bottom >= s.height + body;
    stands = stands || std::abs(other.height - s.height) <= step;
  }
  const Support* next = all_above ? nullptr : nearestTo(column, s.height);
  return next != nullptr && (stands || next->height < s.height) ? std::abs(next->height - s.height) : 0;
}

/// Rise along one axis, per metre: the lower median of those to the columns beside and the next but one. Single heights
/// are off by some centimetres, and the edge of a stair is as flat as its tread.
double riseAlong(const CostGrid& grid, std::int32_t column, std::int32_t row, std::pair<int, int> way, float height) {
  std::array<double, 4> rises{};
  std::size_t count = 0;
  for (const int k : {-2, -1, 1, 2}) {
    const std::int32_t c = column + k * way.first, r = row + k * way.second;
    if (grid.shape.contains(c, r)) {
      if (const Support* next = nearestTo(grid.column(grid.shape.cell(c, r)), height)) {
        rises[count++] = std::abs(next->height - height) / (std::abs(k) * grid.shape.resolution);
      }
    }
  }
  if (count == 0) {
    return 0;
  }
  const auto middle = rises.begin() + static_cast<std::ptrdiff_t>((count - 1) / 2);
  std::nth_element(rises.begin(), middle, rises.begin() + static_cast<std::ptrdiff_t>(count));
  return *middle;
}

/// Columns around one that its slope looks at: two beside it, and those of its neighbours.
constexpr int kSlopeReach = 3;

double slopeAt(const CostGrid& grid, std::int32_t column, std::int32_t row, float height) {
  return std::atan(
      std::hypot(riseAlong(grid, column, row, {1, 0}, height), riseAlong(grid, column, row, {0, 1}, height)));
}

/// Slope of a surface, rad; where it is steeper than the robot can walk and the ground around is not, the gentlest of
/// the two steepest around: a single column with a wrong height is no slope.
double slopeOf(const CostGrid& grid, std::int32_t column, std::int32_t row, float height, double steepest) {
  const double own = slopeAt(grid, column, row, height);
  if (own <= steepest) {
    return own;
  }
  std::array<double, 2> steepest_around{};  // descending
  for (std::int32_t r = row - 1; r <= row + 1; ++r) {
    for (std::int32_t c = column - 1; c <= column + 1; ++c) {
      if ((c != column || r != row) && grid.shape.contains(c, r)) {
        const Support* next = nearestTo(grid.column(grid.shape.cell(c, r)), height);
        double slope = next != nullptr ? slopeAt(grid, c, r, next->height) : own;
        for (double& steep : steepest_around) {
          if (slope > steep) {
            std::swap(slope, steep);
          }
        }
      }
    }
  }
  return std::min(own, steepest_around.back());
}

/// How far beyond an edge the bottom of a drop may come into view. m
constexpr double kBeyondEdge = 2;

/// A leaf may reach a cell beyond the edge that it ends at.
constexpr int kOvershoot = 2;  // cells in which an edge is looked for whatever is in between

/// How far the ground has fallen that way, next to the surface or where it is seen again behind columns in which
/// nothing was seen; 0 when it goes on, or slopes no more than the robot can walk. An edge hides what lies right below
/// it.
double dropBeyond(const CostGrid& grid, std::int32_t column, std::int32_t row, std::pair<int, int> way, float height,
                  const TraversabilityConfig& limits, Reach& reach) {
  const double stride = grid.shape.resolution * strideOf(way);
  for (int k = 1; k * stride <= kBeyondEdge; ++k) {
    reach.look(k);
    const std::int32_t c = column + k * way.first, r = row + k * way.second;
    if (!grid.shape.contains(c, r)) {
      return 0;
    }
    const std::span<const Support> found = grid.column(grid.shape.cell(c, r));
    if (found.empty()) {
      continue;
    }
    // The highest surface below or about here: what is above hangs over both.
    double fall = std::numeric_limits<double>::infinity();
    for (const Support& s : found) {
      fall = std::min(fall, std::max(0.0, static_cast<double>(height) - s.top));
    }
    // The first of the two is cheap and most often the last.
    if (fall > limits.step_height &&
        fall > limits.step_height + k * stride * std::tan(limits.max_slope_deg * kDegree)) {
      return fall;
    }
    if (k >= kOvershoot) {
      return 0;
    }
  }
  return 0;
}

/// What lies this deep below the ground lies there for no error of range, poses or leaves. m
constexpr float kDeep = 0.1F;

/// True where something was seen below the ground and no ground beside it is as low: the beams that met it went through
/// ground that is claimed there, so that there is none. A kerb or a stair has the lower ground at its foot. Of a trench
/// that is looked at flatly, no more is seen than some centimetres of its far side.
bool hidesDrop(const CostGrid& grid, std::int32_t column, std::int32_t row, const Support& s) {
  if (!s.carries || s.height - s.beneath < kDeep) {
    return false;
  }
  const float middle = (s.height + s.beneath) / 2;
  const auto explains = [&](const Support& other) {
    return other.carries && other.height <= middle && other.top >= s.beneath - kDeep;
  };
  for (std::int32_t r = row - Reach::kBeside; r <= row + Reach::kBeside; ++r) {
    for (std::int32_t c = column - Reach::kBeside; c <= column + Reach::kBeside; ++c) {
      if (grid.shape.contains(c, r) && std::ranges::any_of(grid.column(grid.shape.cell(c, r)), explains)) {
        return false;
      }
    }
  }
  return true;
}

std::uint8_t costOf(const Support& s, bool was_walked, const TraversabilityConfig& limits) {
  const double slope = s.slope / (limits.max_slope_deg * kDegree), step = s.step / limits.step_height;
  const double roughness = kUneven * s.roughness / limits.step_height;
  const bool is_beyond_limits = !was_walked && (slope > 1 || step > 1 || roughness > 1);
  if (!(s.carries || (was_walked && s.spans_hole)) || is_beyond_limits || s.clearance < limits.body_height) {
    return kCostBlocked;
  }
  if (!was_walked && s.seen && s.confidence < limits.min_confidence) {
    return kCostUnknown;
  }
  // Six sevenths for how little is known of it, one for how hard it is to walk on: what is known and within the limits
  // is worth no long way around.
  const double hard = std::min(1.0, square(std::max({slope, step, roughness}))), doubt = 1 - s.confidence;
  return static_cast<std::uint8_t>(std::lround(kCostWorst * (hard + 6 * doubt) / 7));
}

}  // namespace

void judge(CostGrid& grid, const WalkedWay& walked, std::int32_t column, std::int32_t row,
           const TraversabilityConfig& limits, Reach& reach) {
  const auto cell = static_cast<std::size_t>(grid.shape.cell(column, row));
  for (std::size_t k = grid.first[cell]; k < grid.first[cell + 1]; ++k) {
    Support& s = grid.supports[k];
    double step = 0;
    for (std::int32_t r = row - 1; r <= row + 1; ++r) {
      for (std::int32_t c = column - 1; c <= column + 1; ++c) {
        if ((c != column || r != row) && grid.shape.contains(c, r)) {
          step = std::max({step, stepTo(grid.column(grid.shape.cell(c, r)), s, limits),
                           dropBeyond(grid, column, row, {c - column, r - row}, s.height, limits, reach)});
        }
      }
    }
    s.step = static_cast<float>(step);
    reach.look(kSlopeReach);
    s.slope = static_cast<float>(slopeOf(grid, column, row, s.height, limits.max_slope_deg * kDegree));
    s.hides_drop = hidesDrop(grid, column, row, s);
    const bool was_walked = wasWalkedOn(walked, grid, static_cast<std::int32_t>(cell), s);
    s.cost = costOf(s, was_walked, limits);
    s.trodden = was_walked && walked.is_core[cell] != 0;
  }
}

namespace {

/// Sorts patches by cell, in their order within one; returns where each cell begins, and the end.
std::vector<std::uint32_t> sortByCell(std::vector<SheetPatch>& patches, const GridShape& shape) {
  std::vector<std::uint32_t> begin(static_cast<std::size_t>(shape.cells()) + 1, 0);
  for (const SheetPatch& p : patches) {
    ++begin[static_cast<std::size_t>(p.cell) + 1];
  }
  for (std::size_t k = 1; k < begin.size(); ++k) {
    begin[k] += begin[k - 1];
  }
  std::vector<SheetPatch> sorted(patches.size());
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
  for (const SheetPatch& p : patches) {
    sorted[next[static_cast<std::size_t>(p.cell)]++] = p;
  }
  patches = std::move(sorted);
  return begin;
}

/// The verdict on every patch.
std::vector<Verdict> verdictsOn(const std::vector<SheetPatch>& patches, const std::vector<std::uint32_t>& begin,
                                std::size_t sheets) {
  std::vector<Verdict> verdicts(patches.size());
  std::vector<std::uint32_t> columns(sheets, 0), obsolete(sheets, 0);
  for (std::size_t cell = 0; cell + 1 < begin.size(); ++cell) {
    const std::span<const SheetPatch> column(patches.data() + begin[cell], patches.data() + begin[cell + 1]);
    for (std::size_t k = 0; k < column.size(); ++k) {
      const Verdict verdict = verdictOn(column, k);
      const auto sheet = static_cast<std::size_t>(column[k].sheet);
      verdicts[begin[cell] + k] = verdict;
      columns[sheet] += 1, obsolete[sheet] += verdict == Verdict::kObsolete ? 1 : 0;
    }
  }
  for (std::size_t k = 0; k < patches.size(); ++k) {
    const auto sheet = static_cast<std::size_t>(patches[k].sheet);
    if (isObsoleteInAll(obsolete[sheet], columns[sheet])) {
      verdicts[k] = Verdict::kObsolete;
    }
  }
  return verdicts;
}

/// The surfaces of the columns out of the patches of so many sheets; the patches get sorted by cell.
CostGrid gridOfPatches(std::vector<SheetPatch>& patches, std::size_t sheets, const GridShape& shape, double step_height,
                       const ShareDone& progress) {
  const std::vector<std::uint32_t> begin = sortByCell(patches, shape);
  const std::vector<Verdict> verdicts = verdictsOn(patches, begin, sheets);
  CostGrid grid{shape, {}, {}};
  grid.first.reserve(begin.size());
  std::vector<SheetPatch> column;
  for (std::size_t cell = 0; cell + 1 < begin.size(); ++cell) {
    grid.first.push_back(static_cast<std::uint32_t>(grid.supports.size()));
    column.clear();
    for (std::uint32_t k = begin[cell]; k < begin[cell + 1]; ++k) {
      if (verdicts[k] == Verdict::kHolds) {
        column.push_back(patches[k]);
      }
    }
    appendSurfaces(column, shape.resolution, step_height, grid.supports);
    if (progress && (cell + 1) % static_cast<std::size_t>(shape.width) == 0) {
      progress(static_cast<double>(cell + 1) / shape.cells());
    }
  }
  grid.first.push_back(static_cast<std::uint32_t>(grid.supports.size()));
  return grid;
}

}  // namespace

CostGrid buildCostGrid(const MapLeaves& map, const GridShape& shape, const TraversabilityConfig& limits,
                       const ShareDone& progress) {
  // What each part of the work takes of it, measured on a street. Floats: so a std::function needs no memory of its
  // own.
  const auto part = [&](float from, float to) -> ShareDone {
    return progress ? [&progress, from, to](double share) { progress(from + (to - from) * share); } : ShareDone();
  };
  std::vector<PlacedSheet> sheets;
  for (const auto& [id, node] : map.nodes) {
    if (isSolid(node)) {
      appendSheets(map, node, shape, sheets);
    }
  }
  std::vector<SheetPatch> patches = patchesOf(sheets, shape, part(0.05F, 0.35F));
  CostGrid grid = gridOfPatches(patches, sheets.size(), shape, limits.step_height, part(0.5F, 0.6F));
  sheets = {}, patches = {};
  joinRisers(grid, limits);
  const WalkedWay walked = walkedWayOf(map, grid, limits);
  fillGaps(grid, walked, limits);
  const ShareDone judged = part(0.65F, 0.8F);
  for (std::int32_t row = 0; row < shape.height; ++row) {
    for (std::int32_t column = 0; column < shape.width; ++column) {
      Reach reach;
      judge(grid, walked, column, row, limits, reach);
    }
    if (judged) {
      judged((row + 1.0) / shape.height);
    }
  }
  applySight(sightOn(SightLines(grid, map), limits, part(0.8F, 1.0F)), walked, limits, grid);
  return grid;
}

std::optional<GridRegion> regionOf(const MapLeaves& map) {
  Eigen::AlignedBox3d box;
  for (const auto& [id, node] : map.nodes) {
    if (!isSolid(node)) {
      continue;
    }
    for (const Leaf& leaf : leavesOf(node)) {
      box.extend(node.T_map_object * Eigen::Vector3f(leaf.mean.data()).cast<double>());
    }
  }
  if (box.isEmpty()) {
    return std::nullopt;
  }
  constexpr double kMargin = 1;  // m, beyond the means of the outermost leaves
  return GridRegion{box.min().x() - kMargin, box.min().y() - kMargin, box.max().x() + kMargin, box.max().y() + kMargin};
}

Result<GridRegion> regionWithin(const MapLeaves& map, const std::optional<GridRegion>& asked) {
  const std::optional<GridRegion> all = regionOf(map);
  if (!all) {
    return Result<GridRegion>::fail("the map is empty");
  }
  if (!asked) {
    return Result<GridRegion>::ok(*all);
  }
  if (const std::string why = whyNoRegion(*asked); !why.empty()) {
    return Result<GridRegion>::fail(why);
  }
  if (asked->x_min > all->x_max || asked->x_max < all->x_min || asked->y_min > all->y_max ||
      asked->y_max < all->y_min) {
    return Result<GridRegion>::fail(
        fmt::format("the region lies outside the map, which covers {:.1f},{:.1f},{:.1f},{:.1f}", all->x_min, all->y_min,
                    all->x_max, all->y_max));
  }
  return Result<GridRegion>::ok(*asked);
}

double groundHeight(const MapLeaves& map, const CostGrid& grid) {
  std::vector<float> heights;
  for (const TimedPose& pose : map.keyframes) {
    const Vec3 p = pose.T_map_body.translation();
    const std::int32_t column = grid.shape.columnOf(p.x()), row = grid.shape.rowOf(p.y());
    if (!grid.shape.contains(column, row)) {
      continue;
    }
    for (const Support& s : grid.column(grid.shape.cell(column, row))) {
      if (s.clearance == std::numeric_limits<float>::infinity() || s.height + s.clearance > p.z()) {
        heights.push_back(s.height);
        break;
      }
    }
  }
  if (heights.empty()) {
    return 0;
  }
  std::ranges::nth_element(heights, heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2));
  return heights[heights.size() / 2];
}

std::optional<double> groundBelow(const CostGrid& grid, const Vec3& p_map_body) {
  constexpr double kReach = 1;  // m: from close above, ground is not always in view
  const GridShape& shape = grid.shape;
  const std::int32_t column = shape.columnOf(p_map_body.x()), row = shape.rowOf(p_map_body.y());
  const auto reach = static_cast<std::int32_t>(kReach / shape.resolution);
  std::optional<double> best;
  double nearest = square(kReach / shape.resolution);  // cells^2
  for (std::int32_t r = row - reach; r <= row + reach; ++r) {
    for (std::int32_t c = column - reach; c <= column + reach; ++c) {
      const double distance = square(r - row) + square(c - column);
      if (!shape.contains(c, r) || distance >= nearest) {
        continue;
      }
      for (const Support& s : grid.column(shape.cell(c, r))) {
        if (s.carries && s.height < p_map_body.z()) {
          best = s.height, nearest = distance;  // ascending: the last one is the highest
        }
      }
    }
  }
  return best;
}

}  // namespace hgg
