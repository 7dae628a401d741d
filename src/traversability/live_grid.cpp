#include "traversability/live_grid.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "traversability/fill.h"
#include "traversability/sight.h"
#include "traversability/spread.h"

namespace hgg {
namespace {

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

bool isSame(float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); }

bool isWithin(int distance, std::uint8_t reach) { return distance <= reach || reach == kFarthestMark; }

std::uint8_t reachOf(const Reach& reach) { return static_cast<std::uint8_t>(std::min(reach.cells(), kFarthestMark)); }

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
      if (const std::int32_t cell_before = shift.cellBefore(c, r); cell_before >= 0) {
        const std::span<const Support> old = before.column(cell_before);
        seen.supports.insert(seen.supports.end(), old.begin(), old.end());
      }
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

const CostGrid& LiveGrid::update(const MapLeaves& map, const GridShape& window, const Eigen::Vector2d& p_robot) {
  if (seen_.shape.resolution != window.resolution) {
    forget();
  }
  const bool is_moved = !isSameWindow(seen_.shape, window);
  const Shift shift(seen_.shape, window);
  const Turn turn = turnFor(window, p_robot);
  ChangedColumns changed = columnsThatCame(window, turn);
  ++turn_;
  sheets_.update(map, turn, changed);
  const Marked anew{changed, gather(changed, sheets_.believed())};
  findVerdicts(anew.patches);
  ChangedColumns freed(window);
  freed.hold(waiting_);
  findObsolete(is_moved ? nullptr : &changed, freed);
  const Marked others{freed, gather(freed, sheets_.believed())};
  CostGrid seen = assemble(seen_, window, anew, others, sheets_.believed(), limits_.step_height);
  CostGrid joined = seen;
  joinRisers(joined, limits_);
  WalkedWay walked = walkedWayOf(map, joined, limits_);
  std::vector<std::uint8_t> marks(static_cast<std::size_t>(window.cells()), 0);
  work_ = {};
  for (std::size_t cell = 0; cell < marks.size(); ++cell) {
    marks[cell] = changed.has(cell) || freed.has(cell) ? 1 : 0;
    work_.columns += marks[cell];
  }
  // Stairs join a column to those beside it.
  const std::vector<std::uint8_t> may_differ = beside(window, marks, Reach::kBeside);
  forEachCell(window, [&](std::int32_t column, std::int32_t row, std::size_t cell) {
    const std::int32_t before = shift.cellBefore(column, row);
    marks[cell] = before < 0 || !isSame(walked.height[cell], walked_.height[static_cast<std::size_t>(before)]) ||
                          walked.is_core[cell] != walked_.is_core[static_cast<std::size_t>(before)] ||
                          (may_differ[cell] != 0 &&
                           !std::ranges::equal(joined.column(static_cast<std::int32_t>(cell)), joined_.column(before)))
                      ? 1
                      : 0;
  });
  const CostGrid before = std::exchange(grid_, {});
  seen_ = std::move(seen), joined_ = std::move(joined), walked_ = std::move(walked);
  fill(before, distances(window, beside(window, marks, Reach::kBeside), is_moved), marks);
  judgeNear(before, distances(window, beside(window, marks, Reach::kBeside), is_moved));
  lookAgain(map, before, marks);
  result_ = grid_;
  applySight(sight_, walked_, limits_, result_);
  return result_;
}

/// Whose turn it is; everybody's in a new grid.
Turn LiveGrid::turnFor(const GridShape& window, const Eigen::Vector2d& p_robot) const {
  if (turns_ == 1 || seen_.shape.cells() == 0) {
    return {};
  }
  return {turns_, turn_ % turns_, static_cast<std::int32_t>(std::floor(p_robot.x() / window.resolution)),
          static_cast<std::int32_t>(std::floor(p_robot.y() / window.resolution)), kNear / window.resolution};
}

/// Those that are new in the window and have their turn; the others wait.
ChangedColumns LiveGrid::columnsThatCame(const GridShape& window, const Turn& turn) {
  const Shift shift(seen_.shape, window);
  ChangedColumns changed(window);
  const std::vector<std::uint8_t> waited = std::exchange(waiting_, {});
  waiting_.assign(static_cast<std::size_t>(window.cells()), 0);
  forEachCell(window, [&](std::int32_t column, std::int32_t row, std::size_t cell) {
    const std::int32_t before = shift.cellBefore(column, row);
    if (before < 0 || waited[static_cast<std::size_t>(before)] != 0) {
      if (turn.isDue(window.first_column + column, window.first_row + row)) {
        changed.add(column, row);
      } else {
        waiting_[cell] = 1;
      }
    }
  });
  changed.hold(waiting_);
  return changed;
}

void LiveGrid::forget() {
  sheets_ = {};
  seen_ = joined_ = grid_ = CostGrid{{}, {0}, {}};
  walked_ = {}, sight_.clear(), waiting_.clear();
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
      if (const std::int64_t cell = others.cellOf(p); cell >= 0 && !others.waits(static_cast<std::size_t>(cell))) {
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
  const GridShape& window = grid_.shape;
  const Shift shift(before.shape, window);
  const SightLines sight(grid_, map);
  const std::vector<std::uint8_t> sight_before = std::exchange(sight_, {});
  sight_.resize(grid_.supports.size());
  const int turns = std::max(kTurns, turns_);
  const Turn turn{turns, turn_ % turns};
  forEachCell(window, [&](std::int32_t column, std::int32_t row, std::size_t cell) {
    const std::int32_t old = shift.cellBefore(column, row);
    const bool is_its_turn = turn.isDue(window.first_column + column, window.first_row + row);
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
