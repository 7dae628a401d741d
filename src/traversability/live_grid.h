#pragma once

#include <vector>

#include "traversability/cost_grid.h"
#include "traversability/held_sheets.h"
#include "traversability/walked.h"

namespace hgg {

/// A grid that is kept while the map goes on and its window moves: as buildCostGrid makes it of the map and the window,
/// but only columns in which a leaf changed are put together again, and only those judged anew whose verdict looked
/// that far. What was in sight from where depends on all that lies between: it is found out again for columns that
/// changed, and for the others in turn. So the grid is the same, byte for byte, once the map has rested for kTurns
/// updates.
class LiveGrid {
 public:
  static constexpr int kTurns = 16;

  explicit LiveGrid(const TraversabilityConfig& limits) : limits_(limits) {}

  const CostGrid& update(const MapLeaves& map, const GridShape& window);

  /// Columns that the last update put together, judged, and looked at from the sensor's places anew.
  struct Work {
    std::size_t columns = 0, judged = 0, looked_at = 0;
  };
  const Work& work() const { return work_; }

 private:
  void forget();
  void findObsolete(const ChangedColumns* changed, ChangedColumns& others);
  void fill(const CostGrid& before, const std::vector<std::uint8_t>& near, std::vector<std::uint8_t>& changed);
  void judgeNear(const CostGrid& before, const std::vector<std::uint8_t>& near);
  void lookAgain(const MapLeaves& map, const CostGrid& before, const std::vector<std::uint8_t>& changed);

  TraversabilityConfig limits_;
  HeldSheets sheets_;
  CostGrid seen_;    // as the leaves have it
  CostGrid joined_;  // with what stairs add, before gaps were filled
  WalkedWay walked_;
  CostGrid grid_;                    // as judged, whatever is in sight
  std::vector<std::uint8_t> sight_;  // of each of its surfaces (traversability/sight.h)
  int turn_ = 0;                     // 0 .. kTurns - 1
  CostGrid result_;
  std::vector<std::uint8_t> fill_reach_, judge_reach_;  // cells; of each cell
  Work work_;
};

}  // namespace hgg
