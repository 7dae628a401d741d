#pragma once

#include <algorithm>
#include <vector>

#include "traversability/cost_grid.h"
#include "traversability/held_sheets.h"
#include "traversability/walked.h"

namespace hgg {

/// A grid that is kept while the map goes on and its window moves: as buildCostGrid makes it of the map and the window,
/// but only columns in which a leaf changed are put together again, and only those judged anew whose verdict looked
/// that far. What was in sight from where depends on all that lies between: it is found out again for columns that
/// changed, and for the others in turn. With `turns` above 1 an update takes up only a part of what changed, and of the
/// columns that come into the window: the squares of the grid whose turn it is, those around the robot more often than
/// others. So the grid is the same, byte for byte, once the map has rested for restsAfter() updates.
class LiveGrid {
 public:
  static constexpr int kTurns = 16;   // of what was in sight, at least
  static constexpr double kNear = 5;  // m, around the robot

  explicit LiveGrid(const TraversabilityConfig& limits, int turns = 1) : limits_(limits), turns_(turns) {}

  /// `p_robot`: m, map frame. The first update does all that there is to do.
  const CostGrid& update(const MapLeaves& map, const GridShape& window, const Eigen::Vector2d& p_robot = {0, 0});
  int restsAfter() const { return turns_ > 1 ? 2 * std::max(kTurns, turns_) : kTurns; }

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

  Turn turnFor(const GridShape& window, const Eigen::Vector2d& p_robot) const;
  ChangedColumns columnsThatCame(const GridShape& window, const Turn& turn);

  TraversabilityConfig limits_;
  int turns_ = 1;
  HeldSheets sheets_;
  CostGrid seen_;    // as the leaves have it
  CostGrid joined_;  // with what stairs add, before gaps were filled
  WalkedWay walked_;
  CostGrid grid_;                      // as judged, whatever is in sight
  std::vector<std::uint8_t> sight_;    // of each of its surfaces (traversability/sight.h)
  int turn_ = 0;                       // of all turns so far
  std::vector<std::uint8_t> waiting_;  // of each cell: it came into the window and has not had its turn
  CostGrid result_;
  std::vector<std::uint8_t> fill_reach_, judge_reach_;  // cells; of each cell
  Work work_;
};

}  // namespace hgg
