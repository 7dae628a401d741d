#include "region/furniture.h"

#include <algorithm>
#include <cmath>

#include "core/spd.h"
#include "core/units.h"

namespace hgg {
namespace {

constexpr double kWayRound = 1.0, kSmallRoom = 5.0;  // m, from corner to corner

/// Connected cells of wall.
struct WallPiece {
  std::vector<std::int32_t> cells;
  std::int32_t columns[2], rows[2];  // least and largest
  double height = 0;                 // m, map frame
};

WallPiece pieceAt(std::int32_t first, const FloorPlan& plan, std::vector<bool>& done) {
  const PlanCell& start = plan.cells[static_cast<std::size_t>(first)];
  WallPiece piece{{first}, {start.column, start.column}, {start.row, start.row}, static_cast<double>(start.height)};
  done[static_cast<std::size_t>(first)] = true;
  for (std::size_t i = 0; i < piece.cells.size(); ++i) {
    const auto k = static_cast<std::size_t>(piece.cells[i]);
    const PlanCell& from = plan.cells[k];
    piece.columns[0] = std::min(piece.columns[0], from.column);
    piece.columns[1] = std::max(piece.columns[1], from.column);
    piece.rows[0] = std::min(piece.rows[0], from.row), piece.rows[1] = std::max(piece.rows[1], from.row);
    for (const std::int32_t next : plan.neighbors[k]) {
      const auto n = static_cast<std::size_t>(next);
      if (next >= 0 && plan.cells[n].is_wall && !done[n]) {
        done[n] = true;
        piece.cells.push_back(next);
      }
    }
  }
  return piece;
}

/// True for pieces about as wide as long, and false for straight walls, however they are turned.
bool isCompact(const WallPiece& piece, const FloorPlan& plan) {
  constexpr double kLeastWidth = 0.25;  // of the length
  Moments moments(Vec3(piece.columns[0], piece.rows[0], 0));
  for (const std::int32_t k : piece.cells) {
    const PlanCell& cell = plan.cells[static_cast<std::size_t>(k)];
    moments.add(cell.column, cell.row, 0);
  }
  const Vec3 squares = eigenSymmetric(moments.belief().cov).values;
  return squares[1] > square(kLeastWidth) * squares[2];
}

/// True where ground was seen all around the piece, and little inside: a block, and no walls that meet.
bool isIsland(const WallPiece& piece, const FloorPlan& plan) {
  constexpr std::int32_t kBeside = 3;  // cells
  constexpr double kAllAround = 0.8;   // share
  constexpr double kMostInside = 0.6;  // share: around a block that is turned by 45 degrees one half is ground
  constexpr double kStep = 0.5;        // m
  int ground_around = 0, around = 0, ground_inside = 0, inside = 0;
  for (std::int32_t row = piece.rows[0] - kBeside; row <= piece.rows[1] + kBeside; ++row) {
    for (std::int32_t column = piece.columns[0] - kBeside; column <= piece.columns[1] + kBeside; ++column) {
      const std::int32_t out = std::max(std::max(piece.rows[0] - row, row - piece.rows[1]),
                                        std::max(piece.columns[0] - column, column - piece.columns[1]));
      const bool is_ground = std::ranges::any_of(plan.at(column, row), [&](const PlanCell& c) {
        return c.was_seen && !c.is_wall && std::abs(static_cast<double>(c.height) - piece.height) < kStep;
      });
      around += out == kBeside ? 1 : 0, ground_around += out == kBeside && is_ground ? 1 : 0;
      inside += out <= 0 ? 1 : 0, ground_inside += out <= 0 && is_ground ? 1 : 0;
    }
  }
  return ground_around >= kAllAround * around && ground_inside <= kMostInside * inside;
}

}  // namespace

void removeFurniture(FloorPlan& plan) {
  std::vector<bool> done(plan.cells.size(), false);
  for (std::size_t k = 0; k < plan.cells.size(); ++k) {
    if (!plan.cells[k].is_wall || done[k]) {
      continue;
    }
    const WallPiece piece = pieceAt(static_cast<std::int32_t>(k), plan, done);
    const double across =
        plan.shape.resolution * std::hypot(piece.columns[1] - piece.columns[0], piece.rows[1] - piece.rows[0]);
    if (across < kWayRound || (across < kSmallRoom && isCompact(piece, plan) && isIsland(piece, plan))) {
      std::ranges::for_each(piece.cells,
                            [&](std::int32_t i) { plan.cells[static_cast<std::size_t>(i)].is_wall = false; });
    }
  }
}

}  // namespace hgg
