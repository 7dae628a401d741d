#include "traversability/spread.h"

#include <algorithm>

namespace hgg {
namespace {

/// One farther than the next cell that way; 0 at a mark. Loops over rows of it take no branch.
std::uint8_t stepFrom(std::uint8_t next, std::uint8_t mark) {
  const auto farther = static_cast<std::uint8_t>(std::min<int>(next, kFarthestMark - 1) + 1);
  return mark != 0 ? std::uint8_t{0} : farther;
}

/// Takes into `nearest` how far the next mark is along the row, both ways.
void lookAlongRows(const GridShape& shape, const std::vector<std::uint8_t>& marks, std::uint8_t outside,
                   std::vector<std::uint8_t>& nearest) {
  for (std::int32_t row = 0; row < shape.height; ++row) {
    const auto first = static_cast<std::size_t>(shape.cell(0, row)),
               last = first + static_cast<std::size_t>(shape.width);
    std::uint8_t seen = outside;
    for (std::size_t cell = first; cell < last; ++cell) {
      seen = stepFrom(seen, marks[cell]);
      nearest[cell] = std::min(nearest[cell], seen);
    }
    seen = outside;
    for (std::size_t cell = last; cell-- > first;) {
      seen = stepFrom(seen, marks[cell]);
      nearest[cell] = std::min(nearest[cell], seen);
    }
  }
}

/// The same along columns or diagonals: `right` cells to the right for each row up, or down.
void lookAcrossRows(const GridShape& shape, const std::vector<std::uint8_t>& marks, int right, bool is_up,
                    std::uint8_t outside, std::vector<std::uint8_t>& nearest) {
  const auto width = static_cast<std::size_t>(shape.width);
  // A row with a cell more at either end, which lies outside.
  std::vector<std::uint8_t> next(width + 2, outside), here(width + 2, outside);
  for (std::int32_t k = 0; k < shape.height; ++k) {
    const auto first = static_cast<std::size_t>(shape.cell(0, is_up ? shape.height - 1 - k : k));
    const std::uint8_t* from = next.data() + 1 + right;
    const std::uint8_t* mark = marks.data() + first;
    std::uint8_t *to = here.data() + 1, *near = nearest.data() + first;
    for (std::size_t i = 0; i < width; ++i) {
      to[i] = stepFrom(from[i], mark[i]);
    }
    for (std::size_t i = 0; i < width; ++i) {
      near[i] = std::min(near[i], to[i]);
    }
    next.swap(here);
  }
}

}  // namespace

std::vector<std::uint8_t> distances(const GridShape& shape, const std::vector<std::uint8_t>& marks, bool is_moved) {
  std::vector<std::uint8_t> nearest(marks.size(), static_cast<std::uint8_t>(kFarthestMark));
  if (!is_moved && std::ranges::find(marks, 1) == marks.end()) {
    return nearest;
  }
  const auto outside = static_cast<std::uint8_t>(is_moved ? 0 : kFarthestMark);
  lookAlongRows(shape, marks, outside, nearest);
  for (const bool is_up : {false, true}) {
    for (const int right : {-1, 0, 1}) {
      lookAcrossRows(shape, marks, right, is_up, outside, nearest);
    }
  }
  return nearest;
}

std::vector<std::uint8_t> beside(const GridShape& shape, const std::vector<std::uint8_t>& marks, std::int32_t reach) {
  std::vector<std::uint8_t> wide(marks), out(marks.size(), 0);
  const auto width = static_cast<std::size_t>(shape.width);
  const auto take = [](const std::uint8_t* from, std::size_t count, std::uint8_t* to) {
    for (std::size_t i = 0; i < count; ++i) {
      to[i] |= from[i];
    }
  };
  for (std::int32_t row = 0; row < shape.height; ++row) {
    const auto first = static_cast<std::size_t>(shape.cell(0, row));
    for (std::size_t k = 1; k <= static_cast<std::size_t>(reach) && k < width; ++k) {
      take(marks.data() + first, width - k, wide.data() + first + k);
      take(marks.data() + first + k, width - k, wide.data() + first);
    }
  }
  for (std::int32_t row = 0; row < shape.height; ++row) {
    const std::int32_t low = std::max(0, row - reach), high = std::min(shape.height - 1, row + reach);
    for (std::int32_t r = low; r <= high; ++r) {
      take(wide.data() + shape.cell(0, r), width, out.data() + shape.cell(0, row));
    }
  }
  return out;
}

}  // namespace hgg
