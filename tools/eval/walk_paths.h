#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "truth/walk_grid.h"

namespace hgg {

/// The robot that plans are asked for.
struct Walker {
  double radius = 0.30;  // m, of the circle it stands in
  double margin = 0.10;  // m, kept free around it where a plan is to be found for certain
};

/// Ways over free ground of a walk grid on which every cell below the robot and its margin is free and was seen.
class WalkPaths {
 public:
  /// Keeps a reference to the grid.
  WalkPaths(const WalkGrid& grid, const Walker& walker);
  WalkPaths(WalkGrid&&, const Walker&) = delete;

  /// The surfaces (indices into the grid's) of the largest connected part, ascending.
  const std::vector<std::uint32_t>& ground() const { return ground_; }
  Vec3 place(std::uint32_t surface) const;
  /// Length of the shortest way, m: steps to 16 neighbours, so at most 3 % longer than the straight one. nullopt
  /// without a way.
  std::optional<double> shortest(std::uint32_t from, std::uint32_t to) const;

 private:
  struct Move {
    std::uint32_t to;
    double length;
  };
  bool isSeen(std::size_t surface) const;
  bool hasRoom(std::size_t surface, double reach) const;
  std::optional<std::uint32_t> step(std::uint32_t surface, int dx, int dy) const;
  std::array<std::optional<Move>, 16> movesFrom(std::uint32_t surface) const;
  std::vector<std::uint32_t> largestPart() const;

  const WalkGrid& grid_;
  std::vector<std::uint32_t> cell_;   // by surface
  std::vector<std::uint8_t> seen_;    // by surface
  std::vector<std::uint8_t> usable_;  // by surface
  std::vector<std::uint32_t> ground_;
};

}  // namespace hgg
