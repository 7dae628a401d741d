#include "traversability/spread.h"

#include <gtest/gtest.h>

#include <array>
#include <random>

#include "traversability/turn.h"

namespace hgg::spread_test {
namespace {

GridShape shapeOf(std::int32_t width, std::int32_t height) {
  GridShape shape;
  shape.resolution = 0.1, shape.width = width, shape.height = height;
  return shape;
}

std::vector<std::uint8_t> someMarks(const GridShape& shape, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::uint8_t> marks(static_cast<std::size_t>(shape.cells()), 0);
  for (std::uint8_t& mark : marks) {
    mark = random() % 40 == 0 ? 1 : 0;
  }
  return marks;
}

bool isMarked(const GridShape& shape, const std::vector<std::uint8_t>& marks, std::int32_t column, std::int32_t row) {
  return marks[static_cast<std::size_t>(shape.cell(column, row))] != 0;
}

/// One cell after the other.
int distanceOf(const GridShape& shape, const std::vector<std::uint8_t>& marks, std::int32_t column, std::int32_t row,
               bool is_moved) {
  for (int k = 0; k < kFarthestMark; ++k) {
    for (const int up : {-k, 0, k}) {
      for (const int right : {-k, 0, k}) {
        const std::int32_t c = column + right, r = row + up;
        if (shape.contains(c, r) ? isMarked(shape, marks, c, r) : is_moved) {
          return k;
        }
      }
    }
  }
  return kFarthestMark;
}

TEST(Spread, DistancesAreThoseToTheNearestMarkAlongEightWays) {
  const GridShape shape = shapeOf(31, 17);
  for (const unsigned seed : {1U, 2U}) {
    const std::vector<std::uint8_t> marks = someMarks(shape, seed);
    for (const bool is_moved : {false, true}) {
      const std::vector<std::uint8_t> found = distances(shape, marks, is_moved);
      for (std::int32_t row = 0; row < shape.height; ++row) {
        for (std::int32_t column = 0; column < shape.width; ++column) {
          ASSERT_EQ(found[static_cast<std::size_t>(shape.cell(column, row))],
                    distanceOf(shape, marks, column, row, is_moved))
              << column << ", " << row << (is_moved ? ", moved" : "");
        }
      }
    }
  }
}

TEST(Spread, BesideAMarkIsAllInTheSquareAroundIt) {
  const GridShape shape = shapeOf(23, 19);
  const std::vector<std::uint8_t> marks = someMarks(shape, 3), found = beside(shape, marks, 3);
  for (std::int32_t row = 0; row < shape.height; ++row) {
    for (std::int32_t column = 0; column < shape.width; ++column) {
      bool is_near = false;
      for (std::int32_t r = row - 3; r <= row + 3; ++r) {
        for (std::int32_t c = column - 3; c <= column + 3; ++c) {
          is_near = is_near || (shape.contains(c, r) && isMarked(shape, marks, c, r));
        }
      }
      ASSERT_EQ(isMarked(shape, found, column, row), is_near) << column << ", " << row;
    }
  }
}

TEST(Turn, EveryCellHasOneTurnOfAllAndOneOfEightNearTheRobot) {
  constexpr int kTurns = 64;
  const std::array<std::pair<std::int32_t, std::int32_t>, 4> cells{{{300, -200}, {-400, 33}, {10, 10}, {-1, -33}}};
  for (const auto& [column, row] : cells) {
    int turns = 0;
    for (int now = 0; now < kTurns; ++now) {
      turns += Turn{kTurns, now, 0, 0, 50}.isDue(column, row) ? 1 : 0;
    }
    const bool is_near = column * column + row * row < 50 * 50;
    EXPECT_EQ(turns, is_near ? kTurns / Turn::kNearTurns : 1) << column << ", " << row;
  }
}

}  // namespace
}  // namespace hgg::spread_test
