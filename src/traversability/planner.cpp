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

/// A surface to begin or end at, or why there is none.
Result<std::uint32_t> anchorOf(const Footholds& holds, const TraversabilityConfig& limits, const PlanPoint& point,
                               double ground_z, const char* what) {
  using Found = Result<std::uint32_t>;
  const GridShape& shape = holds.grid().shape;
  const std::int32_t column = shape.columnOf(point.x), row = shape.rowOf(point.y);
  const std::string where = fmt::format("the {} ({:.2f}, {:.2f})", what, point.x, point.y);
  if (!shape.contains(column, row)) {
    return Found::fail(fmt::format("{} lies outside the map", where));
  }
  const double height = point.z.value_or(ground_z);
  const double reach = point.z ? kHeightReach : std::numeric_limits<double>::infinity();
  const std::int64_t here = holds.nearest(shape.cell(column, row), height, reach);
  if (here < 0) {
    return Found::fail(holds.grid().column(shape.cell(column, row)).empty()
                           ? fmt::format("{} lies on unknown ground", where)
                           : fmt::format("{} has no ground within {} m of height {:.2f}", where, kHeightReach, height));
  }
  const Support& s = holds.grid().supports[static_cast<std::size_t>(here)];
  if (!isWalkable(s.cost)) {
    return Found::fail(
        fmt::format("{} lies {}", where, s.cost == kCostBlocked ? "in an obstacle" : "on ground that is hardly known"));
  }
  // The robot may stand closer to something than it would walk: the nearest place that is clear will do.
  const auto around = 1 + static_cast<std::int32_t>(limits.footprint_radius / shape.resolution);
  std::int64_t best = -1;
  double best_distance = std::numeric_limits<double>::infinity();
  for (std::int32_t r = row - around; r <= row + around; ++r) {
    for (std::int32_t c = column - around; c <= column + around; ++c) {
      const double distance = std::hypot(r - row, c - column);
      const std::int64_t other =
          shape.contains(c, r) ? holds.nearest(shape.cell(c, r), s.height, limits.step_height) : -1;
      if (other >= 0 && holds.isClear(static_cast<std::uint32_t>(other)) && distance < best_distance) {
        best = other, best_distance = distance;
      }
    }
  }
  return best >= 0 ? Found::ok(static_cast<std::uint32_t>(best))
                   : Found::fail(fmt::format("{} has no room for the robot ({} m around its centre)", where,
                                             limits.footprint_radius));
}

/// What a step between two surfaces costs, m.
double stepCost(const Footholds& holds, std::uint32_t a, std::uint32_t b) {
  return (holds.place(a) - holds.place(b)).norm() * (holds.price(a) + holds.price(b)) / 2;
}

using Penalties = std::unordered_map<std::uint32_t, double>;  // of the surfaces that a way may end at, m

/// The way to the end that is cheapest with its penalty (A*); empty when none can be reached. `to_go`: of a surface, m,
/// no more than what is left of the cheapest way from there; 0 everywhere makes it Dijkstra's search.
template <typename ToGo>
Way search(const Footholds& holds, std::uint32_t start, const Penalties& ends, const ToGo& to_go) {
  const GridShape& shape = holds.grid().shape;
  constexpr auto kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<float> cost(holds.grid().supports.size(), std::numeric_limits<float>::infinity());
  std::vector<std::uint32_t> from(holds.grid().supports.size(), kNone);
  using Open = std::pair<float, std::uint32_t>;  // cost of the way through it at least; ties by index
  std::priority_queue<Open, std::vector<Open>, std::greater<>> open;
  cost[start] = 0;
  open.emplace(0.0F, start);
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

/// Path, length, cost and worst confidence of a way between two places near its ends.
Plan planOf(const Footholds& holds, const Way& way, const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
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
  plan.path.front().head<2>() = from;
  if (plan.path.size() == 1) {
    plan.path.push_back(plan.path.front());
  }
  plan.path.back().head<2>() = to;
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
  const Result<std::uint32_t> start = anchorOf(holds, limits, request.from, request.ground_z, "start");
  const Result<std::uint32_t> goal = anchorOf(holds, limits, request.to, request.ground_z, "goal");
  if (!start || !goal) {
    none.reason = start ? goal.error : start.error;
    return none;
  }
  const Vec3 p_goal = holds.place(*goal);
  const Way way = search(holds, *start, {{*goal, 0.0}},
                         [&](std::uint32_t surface) { return (holds.place(surface) - p_goal).norm(); });
  if (!way.empty()) {
    return planOf(holds, way, {request.from.x, request.from.y}, {request.to.x, request.to.y});
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
  const Result<std::uint32_t> start = anchorOf(holds, limits, from, ground_z, "start");
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
  out.plan = planOf(holds, way, {from.x, from.y}, holds.place(way.back()).head<2>());
  return out;
}

}  // namespace hgg
