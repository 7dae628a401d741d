#include "eval/walk_paths.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>

#include "core/units.h"

namespace hgg {
namespace {

/// A LiDAR leaves gaps between its rings; ground this near to a return counts as seen.
constexpr double kSeenReach = 0.25;  // m

/// Visits the cells within `reach` of a cell's middle: their offsets.
void around(double resolution, double reach, const std::function<bool(int, int)>& visit) {
  const int cells = static_cast<int>(reach / resolution) + 1;
  for (int dy = -cells; dy <= cells; ++dy) {
    for (int dx = -cells; dx <= cells; ++dx) {
      if (std::hypot(dx, dy) * resolution <= reach && !visit(dx, dy)) {
        return;
      }
    }
  }
}

/// The surface of another cell that goes on from this one, over a distance in which it may rise as the limits allow.
std::optional<std::size_t> goesOn(const WalkGrid& grid, std::uint32_t cell, double z, int dx, int dy) {
  const int x = static_cast<int>(cell) % grid.width + dx, y = static_cast<int>(cell) / grid.width + dy;
  if (x < 0 || y < 0 || x >= grid.width || y >= grid.height) {
    return std::nullopt;
  }
  const double away = std::hypot(dx, dy) * grid.resolution;
  return surfaceNear(grid, grid.at(x, y), z, grid.limits.step + away * std::tan(grid.limits.slope_deg * kDegree));
}

}  // namespace

WalkPaths::WalkPaths(const WalkGrid& grid, const Walker& walker) : grid_(grid) {
  for (std::size_t cell = 0; cell < grid.cells(); ++cell) {
    cell_.insert(cell_.end(), grid.column(cell).size(), static_cast<std::uint32_t>(cell));
  }
  for (std::size_t i = 0; i < grid.surfaces.size(); ++i) {
    seen_.push_back(isSeen(i) ? 1 : 0);
  }
  for (std::size_t i = 0; i < grid.surfaces.size(); ++i) {
    const double reach = walker.radius + walker.margin + 0.5 * grid.resolution;  // to the cells' edges
    usable_.push_back(hasRoom(i, reach) ? 1 : 0);
  }
  ground_ = largestPart();
}

bool WalkPaths::isSeen(std::size_t surface) const {
  bool is_seen = false;
  around(grid_.resolution, kSeenReach, [&](int dx, int dy) {
    const auto other = goesOn(grid_, cell_[surface], static_cast<double>(grid_.surfaces[surface].height), dx, dy);
    is_seen = other && grid_.surfaces[*other].returns > 0;
    return !is_seen;
  });
  return is_seen;
}

bool WalkPaths::hasRoom(std::size_t surface, double reach) const {
  if (grid_.surfaces[surface].island || grid_.surfaces[surface].standing != Standing::kFree) {
    return false;
  }
  bool has_room = true;
  around(grid_.resolution, reach, [&](int dx, int dy) {
    const auto other = goesOn(grid_, cell_[surface], static_cast<double>(grid_.surfaces[surface].height), dx, dy);
    has_room = other && grid_.surfaces[*other].standing == Standing::kFree && seen_[*other] != 0;
    return has_room;
  });
  return has_room;
}

Vec3 WalkPaths::place(std::uint32_t surface) const {
  return grid_.middle(cell_[surface], static_cast<double>(grid_.surfaces[surface].height));
}

std::optional<std::uint32_t> WalkPaths::step(std::uint32_t surface, int dx, int dy) const {
  const std::uint32_t cell = cell_[surface];
  const int x = static_cast<int>(cell) % grid_.width + dx, y = static_cast<int>(cell) / grid_.width + dy;
  if (x < 0 || y < 0 || x >= grid_.width || y >= grid_.height) {
    return std::nullopt;
  }
  const auto next =
      surfaceNear(grid_, grid_.at(x, y), static_cast<double>(grid_.surfaces[surface].height), grid_.limits.step);
  return next && usable_[*next] != 0 ? std::optional(static_cast<std::uint32_t>(*next)) : std::nullopt;
}

std::array<std::optional<WalkPaths::Move>, 16> WalkPaths::movesFrom(std::uint32_t surface) const {
  std::array<std::optional<Move>, 16> moves;
  std::size_t n = 0;
  const auto offer = [&](const std::optional<std::uint32_t>& to) {
    moves[n++] = to ? std::optional(Move{*to, (place(*to) - place(surface)).norm()}) : std::nullopt;
  };
  for (const auto& [ax, ay] : {std::pair{1, 0}, {0, 1}, {-1, 0}, {0, -1}}) {
    const auto ahead = step(surface, ax, ay);
    offer(ahead);
    const int sx = -ay, sy = ax;  // to the left
    const auto left = step(surface, ax + sx, ay + sy), right = step(surface, ax - sx, ay - sy);
    offer(left && ahead && step(surface, sx, sy) ? left : std::nullopt);  // no cutting of corners
    offer(left && ahead ? step(*left, ax, ay) : std::nullopt);
    offer(right && ahead ? step(*right, ax, ay) : std::nullopt);
  }
  return moves;
}

std::vector<std::uint32_t> WalkPaths::largestPart() const {
  std::vector<std::uint8_t> reached(usable_.size(), 0);
  std::vector<std::uint32_t> largest;
  for (std::uint32_t start = 0; start < usable_.size(); ++start) {
    if (usable_[start] == 0 || reached[start] != 0) {
      continue;
    }
    std::vector<std::uint32_t> part{start};
    reached[start] = 1;
    for (std::size_t i = 0; i < part.size(); ++i) {
      for (const auto& move : movesFrom(part[i])) {
        if (move && reached[move->to] == 0) {
          reached[move->to] = 1;
          part.push_back(move->to);
        }
      }
    }
    if (part.size() > largest.size()) {
      largest = std::move(part);
    }
  }
  std::ranges::sort(largest);
  return largest;
}

std::optional<double> WalkPaths::shortest(std::uint32_t from, std::uint32_t to) const {
  using Waiting = std::pair<double, std::uint32_t>;  // length of the whole way at best, surface
  std::priority_queue<Waiting, std::vector<Waiting>, std::greater<>> frontier;
  std::vector<double> length(usable_.size(), std::numeric_limits<double>::infinity());
  if (usable_[from] == 0) {
    return std::nullopt;
  }
  const auto whole = [&](std::uint32_t s) { return length[s] + (place(s) - place(to)).norm(); };
  length[from] = 0.0;
  frontier.emplace(whole(from), from);
  while (!frontier.empty()) {
    const auto [at_best, at] = frontier.top();
    frontier.pop();
    if (at == to) {
      return length[to];
    }
    if (at_best > whole(at)) {
      continue;
    }
    for (const auto& move : movesFrom(at)) {
      if (move && length[at] + move->length < length[move->to]) {
        length[move->to] = length[at] + move->length;
        frontier.emplace(whole(move->to), move->to);
      }
    }
  }
  return std::nullopt;
}

}  // namespace hgg
