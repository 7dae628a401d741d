#include "traversability/planner.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <unordered_map>

#include "traversability/foothold.h"

namespace hgg {
namespace {

/// A height that was given may be the body's or a guess: it picks the surface within this distance. m
constexpr double kHeightReach = 1.5;
/// Farthest that one straight leg of a smoothed path goes, steps of the search.
constexpr std::size_t kLongestLeg = 300;

/// Ground rises or falls by no more than this from a straight leg over it: a path is on the ground, not in it. m
constexpr double kMostSag = 0.1;

using Way = std::vector<std::uint32_t>;  // surfaces, from start to goal

/// Surfaces that a path may begin or end at, with how far each is from the place that was asked for, m. Not empty.
struct Anchors {
  std::vector<std::pair<std::uint32_t, double>> surfaces;
  double within = 0;  // m: from these the robot may step to the place itself

  bool isThere(std::uint32_t surface) const {
    return std::ranges::find(surfaces, surface, &std::pair<std::uint32_t, double>::first)->second <= within;
  }
};

/// Where an end of a path was asked for, and what is known of it.
struct AskedPlace {
  std::int32_t column = 0, row = 0;
  double height = 0, reach = 0;  // m, map frame; how far off in height ground may be
  std::string trouble;           // why nobody can stand there; empty: one can
  bool is_obstacle = false;
};

Result<AskedPlace> lookAt(const Footholds& holds, const PlanPoint& point, double ground_z, const std::string& where) {
  const GridShape& shape = holds.grid().shape;
  AskedPlace asked{shape.columnOf(point.x), shape.rowOf(point.y), point.z.value_or(ground_z),
                   point.z ? kHeightReach : std::numeric_limits<double>::infinity(), ""};
  if (!shape.contains(asked.column, asked.row)) {
    return Result<AskedPlace>::fail(fmt::format("{} lies outside the map", where));
  }
  const std::int32_t cell = shape.cell(asked.column, asked.row);
  const std::int64_t here = holds.nearest(cell, asked.height, asked.reach);
  if (here < 0) {
    asked.trouble = holds.grid().column(cell).empty() ? fmt::format("{} lies on unknown ground", where)
                                                      : fmt::format("{} has no ground within {} m of height {:.2f}",
                                                                    where, kHeightReach, asked.height);
    return Result<AskedPlace>::ok(asked);
  }
  const Support& s = holds.grid().supports[static_cast<std::size_t>(here)];
  if (!isWalkable(s.cost)) {
    asked.is_obstacle = s.cost == kCostBlocked;
    asked.trouble =
        fmt::format("{} lies {}", where, asked.is_obstacle ? "in an obstacle" : "on ground that is hardly known");
  } else {
    asked.height = s.height, asked.reach = holds.stepHeight();
  }
  return Result<AskedPlace>::ok(asked);
}

/// True when nothing stands on the straight line from the place that was asked for to a surface. Where that place is
/// itself in something, as in the column beside a wall that is drawn too wide, the line may leave it but not enter
/// anything else.
bool isOpenBetween(const Footholds& holds, const TraversabilityConfig& limits, const AskedPlace& asked,
                   std::uint32_t surface) {
  const GridShape& shape = holds.grid().shape;
  const Support& end = holds.grid().supports[surface];
  const auto stands = [&](const Support& s) {
    return s.cost == kCostBlocked && s.bottom < end.height + limits.body_height &&
           s.top > end.height - limits.step_height;
  };
  const std::int32_t columns = holds.cellOf(surface) % shape.width - asked.column;
  const std::int32_t rows = holds.cellOf(surface) / shape.width - asked.row;
  const int steps = 2 * std::max(std::abs(columns), std::abs(rows));
  bool is_free = false;
  for (int k = 0; k <= steps; ++k) {
    const double share = steps > 0 ? static_cast<double>(k) / steps : 0;
    const std::int32_t cell = shape.cell(asked.column + static_cast<std::int32_t>(std::lround(share * columns)),
                                         asked.row + static_cast<std::int32_t>(std::lround(share * rows)));
    const bool is_blocked = std::ranges::any_of(holds.grid().column(cell), stands);
    if (is_blocked && is_free) {
      return false;
    }
    is_free = is_free || !is_blocked;
  }
  return true;
}

/// The surfaces within `tolerance` (m) of a place where the robot has room.
Anchors clearAround(const Footholds& holds, const TraversabilityConfig& limits, const AskedPlace& asked,
                    double tolerance) {
  const GridShape& shape = holds.grid().shape;
  Anchors anchors;
  // By a cell more: the footprint is measured so, too.
  anchors.within = asked.trouble.empty() ? limits.footprint_radius + shape.resolution : 0;
  const double reach = std::max(tolerance > 0 ? tolerance + shape.resolution : 0, anchors.within);
  const auto around = static_cast<std::int32_t>(reach / shape.resolution);
  for (std::int32_t r = asked.row - around; r <= asked.row + around; ++r) {
    for (std::int32_t c = asked.column - around; c <= asked.column + around; ++c) {
      const double distance = shape.resolution * std::hypot(r - asked.row, c - asked.column);
      const bool is_near = shape.contains(c, r) && distance <= reach;
      const std::int64_t other = is_near ? holds.nearest(shape.cell(c, r), asked.height, asked.reach) : -1;
      if (other >= 0 && holds.isClear(static_cast<std::uint32_t>(other)) &&
          isOpenBetween(holds, limits, asked, static_cast<std::uint32_t>(other))) {
        anchors.surfaces.emplace_back(static_cast<std::uint32_t>(other), distance);
      }
    }
  }
  return anchors;
}

/// Where a path may begin or end, or why it cannot. The robot may stand closer to something than it would walk, and
/// where it stands may be hardly known. What stands may be drawn a column too wide; who asks for a place deeper in it
/// is told so.
Result<Anchors> anchorsOf(const Footholds& holds, const TraversabilityConfig& limits, const PlanPoint& point,
                          double ground_z, double tolerance, const char* what) {
  const std::string where = fmt::format("the {} ({:.2f}, {:.2f})", what, point.x, point.y);
  const Result<AskedPlace> asked = lookAt(holds, point, ground_z, where);
  if (!asked) {
    return Result<Anchors>::fail(asked.error);
  }
  Anchors anchors =
      clearAround(holds, limits, *asked, asked->is_obstacle ? std::min(tolerance, limits.footprint_radius) : tolerance);
  if (anchors.surfaces.empty()) {
    return Result<Anchors>::fail(
        !asked->trouble.empty()
            ? asked->trouble
            : fmt::format("{} has no room for the robot ({} m around its centre)", where, limits.footprint_radius));
  }
  return Result<Anchors>::ok(std::move(anchors));
}

/// What a step between two surfaces costs, m.
double stepCost(const Footholds& holds, std::uint32_t a, std::uint32_t b) {
  return (holds.place(a) - holds.place(b)).norm() * (holds.price(a) + holds.price(b)) / 2;
}

using Penalties = std::unordered_map<std::uint32_t, double>;  // of the surfaces that a way may end at, m

/// A metre that a path begins or ends beside what was asked for weighs more than this many of walking: it does so only
/// where the nearer place cannot be reached.
constexpr double kBeside = 20;

/// The way to the end that is cheapest with its penalty (A*), from any of the surfaces to start at, which weigh by
/// their distance; empty when none can be reached. `to_go`: of a surface, m, no more than what is left of the cheapest
/// way from there; 0 everywhere makes it Dijkstra's search.
template <typename ToGo>
Way search(const Footholds& holds, const Anchors& starts, const Penalties& ends, const ToGo& to_go) {
  const GridShape& shape = holds.grid().shape;
  constexpr auto kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<float> cost(holds.grid().supports.size(), std::numeric_limits<float>::infinity());
  std::vector<std::uint32_t> from(holds.grid().supports.size(), kNone);
  using Open = std::pair<float, std::uint32_t>;  // cost of the way through it at least; ties by index
  std::priority_queue<Open, std::vector<Open>, std::greater<>> open;
  for (const auto& [start, distance] : starts.surfaces) {
    cost[start] = static_cast<float>(kBeside * distance);
    open.emplace(cost[start] + static_cast<float>(to_go(start)), start);
  }
  std::vector<bool> closed(holds.grid().supports.size(), false);
  Open best{std::numeric_limits<float>::infinity(), kNone};  // of the ends
  while (!open.empty() && open.top().first < best.first) {
    const std::uint32_t here = open.top().second;
    open.pop();
    if (closed[here]) {
      continue;
    }
    closed[here] = true;
    if (const auto end = ends.find(here); end != ends.end()) {
      best = std::min(best, {cost[here] + static_cast<float>(end->second), here});
    }
    const std::int32_t column = holds.cellOf(here) % shape.width, row = holds.cellOf(here) / shape.width;
    for (std::int32_t r = row - 1; r <= row + 1; ++r) {
      for (std::int32_t c = column - 1; c <= column + 1; ++c) {
        if ((r == row && c == column) || !shape.contains(c, r)) {
          continue;
        }
        const auto cell = static_cast<std::size_t>(shape.cell(c, r));
        for (std::uint32_t next = holds.grid().first[cell]; next < holds.grid().first[cell + 1]; ++next) {
          const double rise = holds.grid().supports[next].height - holds.grid().supports[here].height;
          if (!holds.isClear(next) || closed[next] || std::abs(rise) > holds.stepHeight()) {
            continue;
          }
          const auto through = static_cast<float>(cost[here] + stepCost(holds, here, next));
          if (through < cost[next]) {
            cost[next] = through, from[next] = here;
            open.emplace(through + static_cast<float>(to_go(next)), next);
          }
        }
      }
    }
  }
  Way way;
  for (std::uint32_t k = best.second; k != kNone; k = from[k]) {
    way.push_back(k);
  }
  std::ranges::reverse(way);
  return way;
}

/// Cost of the straight leg between two surfaces, m; infinite where it leaves clear ground, or the ground it.
double legCost(const Footholds& holds, std::uint32_t a, std::uint32_t b) {
  const GridShape& shape = holds.grid().shape;
  const Vec3 from = holds.place(a), to = holds.place(b);
  const double way = std::hypot(to.x() - from.x(), to.y() - from.y());
  const int steps = 1 + static_cast<int>(way / (shape.resolution / 4));
  double cost = 0;
  std::uint32_t last = a;
  Vec3 p_last = from;
  for (int k = 1; k <= steps; ++k) {
    Vec3 p = from + (to - from) * k / steps;
    const std::int64_t next = holds.nearest(shape.cell(shape.columnOf(p.x()), shape.rowOf(p.y())),
                                            holds.grid().supports[last].height, holds.stepHeight());
    if (next < 0 || !holds.isClear(static_cast<std::uint32_t>(next))) {
      return std::numeric_limits<double>::infinity();
    }
    const auto surface = static_cast<std::uint32_t>(next);
    if (std::abs(holds.grid().supports[surface].height - p.z()) > kMostSag) {
      return std::numeric_limits<double>::infinity();
    }
    p.z() = holds.grid().supports[surface].height;
    cost += (p - p_last).norm() * (holds.price(last) + holds.price(surface)) / 2;
    last = surface, p_last = p;
  }
  return last == b ? cost : std::numeric_limits<double>::infinity();
}

/// The way with straight legs wherever those cost no more: the search only knows eight directions.
Way straightened(const Footholds& holds, const Way& way) {
  Way out{way.front()};
  for (std::size_t k = 0; k + 1 < way.size();) {
    std::size_t best = k + 1;
    double cost = 0;
    for (std::size_t other = k + 1; other < std::min(way.size(), k + kLongestLeg); ++other) {
      cost += stepCost(holds, way[other - 1], way[other]);
      // The leg passes over the steps between cells that the search took at once.
      constexpr double kSlack = 1.001;
      if (other > k + 1 && legCost(holds, way[k], way[other]) <= kSlack * cost) {
        best = other;
      }
    }
    out.push_back(way[best]);
    k = best;
  }
  return out;
}

/// Path, length, cost and worst confidence of a way from a start to a goal. It begins at the start, where the robot is,
/// and ends at the goal or, where that is no place to stand, at the nearest that is.
Plan planOf(const Footholds& holds, const Way& way, const Eigen::Vector2d& start, bool starts_there,
            const Eigen::Vector2d& goal, bool ends_there) {
  Plan plan;
  plan.found = true;
  plan.worst_confidence = 1;
  for (std::size_t k = 0; k < way.size(); ++k) {
    plan.worst_confidence = std::min<double>(plan.worst_confidence, holds.grid().supports[way[k]].confidence);
    plan.cost += k > 0 ? stepCost(holds, way[k - 1], way[k]) : 0;
  }
  for (const std::uint32_t k : straightened(holds, way)) {
    plan.path.push_back(holds.place(k));
    plan.worst_confidence = std::min<double>(plan.worst_confidence, holds.grid().supports[k].confidence);
  }
  if (!starts_there || plan.path.size() == 1) {
    plan.path.insert(plan.path.begin(), plan.path.front());
  }
  plan.path.front().head<2>() = start;
  if (ends_there) {
    plan.path.back().head<2>() = goal;
  }
  plan.goal_distance = (plan.path.back().head<2>() - goal).norm();
  for (std::size_t k = 1; k < plan.path.size(); ++k) {
    plan.length += (plan.path[k] - plan.path[k - 1]).norm();
  }
  return plan;
}

}  // namespace

Plan planPath(const CostGrid& grid, const TraversabilityConfig& limits, const PlanRequest& request) {
  Plan none;
  const CostGrid opened = request.allow_unknown ? withUnknownAsGround(grid) : CostGrid{};
  const Footholds holds(request.allow_unknown ? opened : grid, limits);
  const Result<Anchors> start = anchorsOf(holds, limits, request.from, request.ground_z, request.tolerance, "start");
  const Result<Anchors> goal = anchorsOf(holds, limits, request.to, request.ground_z, request.tolerance, "goal");
  if (!start || !goal) {
    none.reason = start ? goal.error : start.error;
    return none;
  }
  const Eigen::Vector2d p_start(request.from.x, request.from.y), p_goal(request.to.x, request.to.y);
  Penalties ends;
  double beside = 0;
  for (const auto& [surface, distance] : goal->surfaces) {
    ends.emplace(surface, kBeside * distance);
    beside = std::max(beside, distance + grid.shape.resolution);
  }
  const Way way = search(holds, *start, ends, [&](std::uint32_t surface) {
    return std::max(0.0, (holds.place(surface).head<2>() - p_goal).norm() - beside);
  });
  if (!way.empty()) {
    return planOf(holds, way, p_start, start->isThere(way.front()), p_goal, goal->isThere(way.back()));
  }
  none.reason = "obstacles or steps lie between start and goal on every way";
  if (!request.allow_unknown) {
    PlanRequest bolder = request;
    bolder.allow_unknown = true;
    if (planPath(grid, limits, bolder).found) {
      none.reason = "every way from start to goal leads over unknown ground (--allow-unknown takes it)";
    }
  }
  return none;
}

PlanToAny planToAny(const CostGrid& grid, const TraversabilityConfig& limits, const PlanPoint& from, double ground_z,
                    std::span<const PlanEnd> ends) {
  PlanToAny out;
  const Footholds holds(grid, limits);
  const Result<Anchors> start = anchorsOf(holds, limits, from, ground_z, kPlanTolerance, "start");
  if (!start) {
    out.plan.reason = start.error;
    return out;
  }
  Penalties penalties;
  for (const PlanEnd& end : ends) {
    penalties.emplace(end.surface, end.penalty);
  }
  const Way way = search(holds, *start, penalties, [](std::uint32_t) { return 0.0; });
  if (way.empty()) {
    out.plan.reason = "obstacles, steps or unknown ground lie on every way";
    return out;
  }
  out.end = static_cast<std::size_t>(std::ranges::find(ends, way.back(), &PlanEnd::surface) - ends.begin());
  out.plan = planOf(holds, way, {from.x, from.y}, start->isThere(way.front()), holds.place(way.back()).head<2>(), true);
  return out;
}

}  // namespace hgg
