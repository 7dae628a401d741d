#include "traversability/live_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "traversability/fill.h"
#include "traversability/sight.h"

namespace hgg {
namespace {

constexpr int kFarthest = std::numeric_limits<std::uint8_t>::max();  // cells; more is not told apart

/// Which cell of the window before a cell of the window now was; -1: none.
class Shift {
 public:
  Shift(const GridShape& before, const GridShape& now)
      : before_(before), columns_(now.first_column - before.first_column), rows_(now.first_row - before.first_row) {}
  std::int32_t cellBefore(std::int32_t column, std::int32_t row) const {
    column += columns_, row += rows_;
    return before_.contains(column, row) ? before_.cell(column, row) : -1;
  }

 private:
  const GridShape& before_;
  std::int32_t columns_, rows_;
};

template <typename Visit>
void forEachCell(const GridShape& shape, Visit visit) {
  for (std::int32_t row = 0; row < shape.height; ++row) {
    for (std::int32_t column = 0; column < shape.width; ++column) {
      visit(column, row, static_cast<std::size_t>(shape.cell(column, row)));
    }
  }
}

bool isSameWindow(const GridShape& a, const GridShape& b) {
  return a.first_column == b.first_column && a.first_row == b.first_row && a.width == b.width && a.height == b.height;
}

/// Takes into `nearest` how far from each cell the next one with a mark is that way, one of eight, in cells; 0: it has
/// one itself. `outside`: the same of what lies outside.
void lookThatWay(const GridShape& shape, const std::vector<std::uint8_t>& marks, std::pair<int, int> way,
                 std::uint8_t outside, std::vector<std::uint8_t>& seen, std::vector<std::uint8_t>& nearest) {
  const bool is_up = way.second > 0 || (way.second == 0 && way.first > 0);  // what is looked at comes first
  for (std::int32_t k = 0; k < shape.height; ++k) {
    const std::int32_t row = is_up ? shape.height - 1 - k : k;
    for (std::int32_t i = 0; i < shape.width; ++i) {
      const std::int32_t column = is_up ? shape.width - 1 - i : i;
      const std::int32_t c = column + way.first, r = row + way.second;
      const auto cell = static_cast<std::size_t>(shape.cell(column, row));
      const std::uint8_t next = shape.contains(c, r) ? seen[static_cast<std::size_t>(shape.cell(c, r))] : outside;
      seen[cell] = marks[cell] != 0 ? std::uint8_t{0} : static_cast<std::uint8_t>(next + (next < kFarthest ? 1 : 0));
      nearest[cell] = std::min(nearest[cell], seen[cell]);
    }
  }
}

/// Of each cell, how far the nearest one with a mark is along the eight ways that verdicts look, in cells. Where
/// `is_moved`, what is outside has a mark too: it was a part of the window, or is none any more.
std::vector<std::uint8_t> distances(const GridShape& shape, const std::vector<std::uint8_t>& marks, bool is_moved) {
  std::vector<std::uint8_t> nearest(marks.size(), static_cast<std::uint8_t>(kFarthest)), seen(marks.size());
  if (!is_moved && std::ranges::find(marks, 1) == marks.end()) {
    return nearest;
  }
  const auto outside = static_cast<std::uint8_t>(is_moved ? 0 : kFarthest);
  for (const int up : {-1, 0, 1}) {
    for (const int right : {-1, 0, 1}) {
      if (up != 0 || right != 0) {
        lookThatWay(shape, marks, {right, up}, outside, seen, nearest);
      }
    }
  }
  return nearest;
}

/// The marks, and one on every column that is no farther from a mark than a verdict looks all around.
std::vector<std::uint8_t> beside(const GridShape& shape, const std::vector<std::uint8_t>& marks) {
  std::vector<std::uint8_t> wide(marks.size(), 0), out(marks.size(), 0);
  const auto spread = [&](const std::vector<std::uint8_t>& from, std::pair<int, int> way,
                          std::vector<std::uint8_t>& to) {
    forEachCell(shape, [&](std::int32_t column, std::int32_t row, std::size_t cell) {
      for (int k = -Reach::kBeside; from[cell] != 0 && k <= Reach::kBeside; ++k) {
        const std::int32_t c = column + k * way.first, r = row + k * way.second;
        if (shape.contains(c, r)) {
          to[static_cast<std::size_t>(shape.cell(c, r))] = 1;
        }
      }
    });
  };
  spread(marks, {1, 0}, wide);
  spread(wide, {0, 1}, out);
  return out;
}

bool isSame(float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); }

bool isWithin(int distance, std::uint8_t reach) { return distance <= reach || reach == kFarthest; }

std::uint8_t reachOf(const Reach& reach) { return static_cast<std::uint8_t>(std::min(reach.cells(), kFarthest)); }

/// Calls visit(sheet, patch, cell) for all patches in marked columns.
template <typename Visit>
void forEachPatchIn(const ChangedColumns& columns, const std::vector<HeldSheet*>& sheets, Visit visit) {
  for (std::size_t k = 0; k < sheets.size(); ++k) {
    if (!columns.mayHave(*sheets[k])) {
      continue;
    }
    for (HeldPatch& p : sheets[k]->patches) {
      if (const std::int64_t cell = columns.cellOf(p); cell >= 0 && columns.has(static_cast<std::size_t>(cell))) {
        visit(static_cast<std::int32_t>(k), p, static_cast<std::size_t>(cell));
      }
    }
  }
}

/// The patches of marked columns, column by column, in the order of the sheets within one.
struct Gathered {
  std::vector<std::uint32_t> begin;  // of each cell; one more entry than there are cells
  std::vector<SheetPatch> patches;
  std::vector<HeldPatch*> held;  // where each is from
};

Gathered gather(const ChangedColumns& columns, const std::vector<HeldSheet*>& sheets) {
  Gathered g;
  g.begin.assign(static_cast<std::size_t>(columns.window().cells()) + 1, 0);
  forEachPatchIn(columns, sheets, [&](std::int32_t, HeldPatch&, std::size_t cell) { ++g.begin[cell + 1]; });
  for (std::size_t k = 1; k < g.begin.size(); ++k) {
    g.begin[k] += g.begin[k - 1];
  }
  g.patches.resize(g.begin.back()), g.held.resize(g.begin.back());
  std::vector<std::uint32_t> next(g.begin.begin(), g.begin.end() - 1);
  forEachPatchIn(columns, sheets, [&](std::int32_t sheet, HeldPatch& p, std::size_t cell) {
    const std::uint32_t k = next[cell]++;
    g.patches[k] = sheets[static_cast<std::size_t>(sheet)]->common;
    g.patches[k].cell = static_cast<std::int32_t>(cell), g.patches[k].sheet = sheet;
    g.patches[k].bottom = p.bottom, g.patches[k].top = p.top, g.patches[k].height = p.height;
    g.held[k] = &p;
  });
  return g;
}

/// Columns with their patches.
struct Marked {
  ChangedColumns columns;
  Gathered patches;
};

void findVerdicts(const Gathered& g) {
  for (std::size_t cell = 0; cell + 1 < g.begin.size(); ++cell) {
    const std::span<const SheetPatch> column(g.patches.data() + g.begin[cell], g.patches.data() + g.begin[cell + 1]);
    for (std::size_t k = 0; k < column.size(); ++k) {
      g.held[g.begin[cell] + k]->verdict = verdictOn(column, k);
    }
  }
}

/// The surfaces of marked columns out of those of the sheets that hold, of all others as they were.
CostGrid assemble(const CostGrid& before, const GridShape& window, const Marked& changed, const Marked& others,
                  const std::vector<HeldSheet*>& sheets, double step_height) {
  const Shift shift(before.shape, window);
  CostGrid seen{window, {}, {}};
  seen.first.reserve(static_cast<std::size_t>(window.cells()) + 1);
  seen.supports.reserve(before.supports.size() + before.supports.size() / 8);
  std::vector<SheetPatch> column;
  forEachCell(window, [&](std::int32_t c, std::int32_t r, std::size_t cell) {
    seen.first.push_back(static_cast<std::uint32_t>(seen.supports.size()));
    const bool is_changed = changed.columns.has(cell);
    if (!is_changed && !others.columns.has(cell)) {
      const std::span<const Support> old = before.column(shift.cellBefore(c, r));
      seen.supports.insert(seen.supports.end(), old.begin(), old.end());
      return;
    }
    const Gathered& g = is_changed ? changed.patches : others.patches;
    column.clear();
    for (std::uint32_t k = g.begin[cell]; k < g.begin[cell + 1]; ++k) {
      if (g.held[k]->verdict == Verdict::kHolds && !sheets[static_cast<std::size_t>(g.patches[k].sheet)]->is_obsolete) {
        column.push_back(g.patches[k]);
      }
    }
    appendSurfaces(column, window.resolution, step_height, seen.supports);
  });
  seen.first.push_back(static_cast<std::uint32_t>(seen.supports.size()));
  return seen;
}

}  // namespace

const CostGrid& LiveGrid::update(const MapLeaves& map, const GridShape& window) {
  if (seen_.shape.resolution != window.resolution) {
    forget();
  }
  const bool is_moved = !isSameWindow(seen_.shape, window);
  const Shift shift(seen_.shape, window);
  ChangedColumns changed(window);
  forEachCell(window, [&](std::int32_t column, std::int32_t row, std::size_t) {
    if (shift.cellBefore(column, row) < 0) {
      changed.add(column, row);
    }
  });
  sheets_.update(map, changed);
  const Marked anew{changed, gather(changed, sheets_.believed())};
  findVerdicts(anew.patches);
  ChangedColumns freed(window);
  findObsolete(is_moved ? nullptr : &changed, freed);
  const Marked others{freed, gather(freed, sheets_.believed())};
  CostGrid seen = assemble(seen_, window, anew, others, sheets_.believed(), limits_.step_height);
  CostGrid joined = seen;
  joinRisers(joined, limits_);
  WalkedWay walked = walkedWayOf(map, joined, limits_);
  std::vector<std::uint8_t> marks(static_cast<std::size_t>(window.cells()), 0);
  work_ = {};
  forEachCell(window, [&](std::int32_t column, std::int32_t row, std::size_t cell) {
    const std::int32_t before = shift.cellBefore(column, row);
    work_.columns += changed.has(cell) || freed.has(cell) ? 1 : 0;
    marks[cell] = before < 0 ||
                          !std::ranges::equal(joined.column(static_cast<std::int32_t>(cell)), joined_.column(before)) ||
                          !isSame(walked.height[cell], walked_.height[static_cast<std::size_t>(before)]) ||
                          walked.is_core[cell] != walked_.is_core[static_cast<std::size_t>(before)]
                      ? 1
                      : 0;
  });
  const CostGrid before = std::exchange(grid_, {});
  seen_ = std::move(seen), joined_ = std::move(joined), walked_ = std::move(walked);
  fill(before, distances(window, beside(window, marks), is_moved), marks);
  judgeNear(before, distances(window, beside(window, marks), is_moved));
  lookAgain(map, before, marks);
  result_ = grid_;
  applySight(sight_, walked_, limits_, result_);
  return result_;
}

void LiveGrid::forget() {
  sheets_ = {};
  seen_ = joined_ = grid_ = CostGrid{{}, {0}, {}};
  walked_ = {}, sight_.clear();
  fill_reach_.clear(), judge_reach_.clear();
}

/// Sheets that have become obsolete in all of their columns, or are so no more, change them all. `changed`: only sheets
/// with a column among these can have; nullptr: any.
void LiveGrid::findObsolete(const ChangedColumns* changed, ChangedColumns& others) {
  for (HeldSheet* sheet : sheets_.believed()) {
    if (changed != nullptr && !changed->mayHave(*sheet)) {
      continue;
    }
    std::uint32_t columns = 0, obsolete = 0;
    for (const HeldPatch& p : sheet->patches) {
      if (others.cellOf(p) >= 0) {
        columns += 1, obsolete += p.verdict == Verdict::kObsolete ? 1 : 0;
      }
    }
    const bool is_obsolete = isObsoleteInAll(obsolete, columns);
    if (is_obsolete != sheet->is_obsolete) {
      others.add(*sheet);
      sheet->is_obsolete = is_obsolete;
    }
  }
}

/// `near`: how far the next column is that changed. Marks columns whose filling changed, too.
void LiveGrid::fill(const CostGrid& before, const std::vector<std::uint8_t>& near, std::vector<std::uint8_t>& changed) {
  const GridShape& window = seen_.shape;
  const Shift shift(before.shape, window);
  const std::vector<std::uint8_t> reach_before = std::exchange(fill_reach_, {});
  fill_reach_.resize(near.size());
  grid_ = CostGrid{window, {}, {}};
  grid_.first.reserve(seen_.first.size());
  grid_.supports.reserve(seen_.supports.size() + seen_.supports.size() / 8);
  forEachCell(window, [&](std::int32_t column, std::int32_t row, std::size_t cell) {
    grid_.first.push_back(static_cast<std::uint32_t>(grid_.supports.size()));
    const std::span<const Support> seen = joined_.column(static_cast<std::int32_t>(cell));
    const std::int32_t old = shift.cellBefore(column, row);
    const std::span<const Support> was = old >= 0 ? before.column(old) : std::span<const Support>();
    const bool was_filled = !was.empty() && !was.front().seen;
    if (isOpen(seen, limits_)) {
      if (old >= 0 && !isWithin(near[cell], reach_before[static_cast<std::size_t>(old)])) {
        fill_reach_[cell] = reach_before[static_cast<std::size_t>(old)];
        if (was_filled) {
          grid_.supports.push_back(was.front());
        }
      } else {
        Reach reach;
        const std::optional<Support> filled = fillColumn(joined_, walked_, column, row, limits_, reach);
        fill_reach_[cell] = reachOf(reach);
        if (filled) {
          grid_.supports.push_back(*filled);
        }
        // What was judged of it is no part of it.
        if (was_filled != filled.has_value() ||
            (filled && (was.front().height != filled->height || was.front().roughness != filled->roughness ||
                        was.front().clearance != filled->clearance))) {
          changed[cell] = 1;
        }
      }
    }
    grid_.supports.insert(grid_.supports.end(), seen.begin(), seen.end());
  });
  grid_.first.push_back(static_cast<std::uint32_t>(grid_.supports.size()));
}

void LiveGrid::judgeNear(const CostGrid& before, const std::vector<std::uint8_t>& near) {
  const GridShape& window = grid_.shape;
  const Shift shift(before.shape, window);
  const std::vector<std::uint8_t> reach_before = std::exchange(judge_reach_, {});
  judge_reach_.resize(near.size());
  forEachCell(window, [&](std::int32_t column, std::int32_t row, std::size_t cell) {
    if (grid_.first[cell] == grid_.first[cell + 1]) {
      return;
    }
    const std::int32_t old = shift.cellBefore(column, row);
    if (old < 0 || isWithin(near[cell], reach_before[static_cast<std::size_t>(old)])) {
      Reach reach;
      judge(grid_, walked_, column, row, limits_, reach);
      judge_reach_[cell] = reachOf(reach);
      ++work_.judged;
      return;
    }
    judge_reach_[cell] = reach_before[static_cast<std::size_t>(old)];
    std::ranges::copy(before.column(old), grid_.supports.begin() + grid_.first[cell]);
  });
}

/// `changed`: columns whose surfaces are not what they were.
void LiveGrid::lookAgain(const MapLeaves& map, const CostGrid& before, const std::vector<std::uint8_t>& changed) {
  constexpr std::int32_t kBlock = 8;  // columns, its edge: blocks take turns
  const GridShape& window = grid_.shape;
  const Shift shift(before.shape, window);
  const SightLines sight(grid_, map);
  const std::vector<std::uint8_t> sight_before = std::exchange(sight_, {});
  sight_.resize(grid_.supports.size());
  turn_ = (turn_ + 1) % kTurns;
  forEachCell(window, [&](std::int32_t column, std::int32_t row, std::size_t cell) {
    const std::int32_t old = shift.cellBefore(column, row);
    const std::int32_t block = (window.first_column + column) / kBlock + 3 * ((window.first_row + row) / kBlock);
    const bool is_its_turn = (block % kTurns + kTurns) % kTurns == turn_;
    const bool is_new = old < 0 || changed[cell] != 0;
    work_.looked_at += is_new || is_its_turn ? 1 : 0;
    for (std::uint32_t k = grid_.first[cell], i = 0; k < grid_.first[cell + 1]; ++k, ++i) {
      const std::size_t k_before = is_new ? 0 : before.first[static_cast<std::size_t>(old)] + i;
      const bool is_asked_first =
          !is_new && isWalkable(grid_.supports[k].cost) && !isWalkable(before.supports[k_before].cost);
      sight_[k] = is_new || is_its_turn || is_asked_first ? sightOn(sight, column, row, grid_.supports[k], limits_)
                                                          : sight_before[k_before];
    }
  });
}

}  // namespace hgg
