#pragma once

#include <cstdint>

namespace hgg {

/// Which parts of the map an update of a grid takes up: squares of columns have turns, those around the robot more
/// often.
struct Turn {
  static constexpr std::int32_t kSquare = 32;  // columns, its edge: most leaves reach over little more than one
  static constexpr int kNearTurns = 8;

  int of = 1, now = 0;                           // a multiple of kNearTurns, or 1: everything has every turn
  std::int32_t robot_column = 0, robot_row = 0;  // among all cells of the map
  double near = 0;                               // cells

  /// `column`, `row`: among all cells of the map.
  bool isDue(std::int32_t column, std::int32_t row) const {
    const double x = column - robot_column, y = row - robot_row;
    const bool is_near = x * x + y * y < near * near;
    const int turns = of > 1 && is_near ? kNearTurns : of;
    return of == 1 || numberOf(column, row) % turns == now % turns;
  }

 private:
  static std::int32_t squareOf(std::int32_t k) { return (k >= 0 ? k : k - kSquare + 1) / kSquare; }
  /// Of the square of a cell: neighbours have their turns far apart.
  int numberOf(std::int32_t column, std::int32_t row) const {
    constexpr int kRow = 13;
    const int number = squareOf(column) + kRow * squareOf(row);
    return (number % of + of) % of;
  }
};

}  // namespace hgg
