#pragma once

#include <vector>

#include "traversability/cost_grid.h"
#include "traversability/held_sheets.h"

namespace hgg {

/// A grid that is kept while the map goes on and its window moves: the same, byte for byte, as buildCostGrid makes of
/// the map and the window, but only columns in which a leaf changed are put together again, and only those judged anew
/// whose verdict looked that far.
class LiveGrid {
 public:
  explicit LiveGrid(const TraversabilityConfig& limits) : limits_(limits) {}

  const CostGrid& update(const MapLeaves& map, const GridShape& window);

  /// Columns that the last update put together and judged anew.
  struct Work {
    std::size_t columns = 0, judged = 0;
  };
  const Work& work() const { return work_; }

 private:
  void forget();
  void findObsolete(const ChangedColumns* changed, ChangedColumns& others);
  void fill(const CostGrid& before, const std::vector<std::uint8_t>& near, std::vector<std::uint8_t>& changed);
  void judgeNear(const CostGrid& before, const std::vector<std::uint8_t>& near);

  TraversabilityConfig limits_;
  HeldSheets sheets_;
  CostGrid seen_;                                       // before gaps were filled
  CostGrid grid_;                                       // as judged
  std::vector<std::uint8_t> fill_reach_, judge_reach_;  // cells; of each cell
  Work work_;
};

}  // namespace hgg
