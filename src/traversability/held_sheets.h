#pragma once

#include <map>
#include <span>
#include <vector>

#include "traversability/columns.h"
#include "traversability/turn.h"

namespace hgg {

/// What one leaf says of one column of the map.
struct HeldPatch {
  std::int32_t column = 0, row = 0;  // among all cells of the map
  float bottom = 0, top = 0, height = 0;
  Verdict verdict = Verdict::kHolds;  // valid while its column is in the window
};

/// A leaf's sheet with its patches, kept while the leaf stays what it is.
struct HeldSheet {
  Leaf leaf;  // in the object frame
  PlacedSheet placed;
  SheetPatch common;               // what all its patches have in common
  std::vector<HeldPatch> patches;  // row by row; empty until it is first believed
  std::int32_t first_column = 0, first_row = 0, last_column = -1, last_row = -1;  // that its patches lie in
  bool is_sampled = false, is_believed = false;
  bool is_obsolete = false;  // in all of its columns
  std::int32_t view = 0;     // of its node, that it was placed with
};

/// The columns of a window that something has changed in.
class ChangedColumns {
 public:
  explicit ChangedColumns(const GridShape& window);
  void add(const HeldSheet& sheet);
  void add(std::int32_t column, std::int32_t row) {
    const auto cell = static_cast<std::size_t>(window_.cell(column, row));
    if (!waits(cell)) {
      marks_[cell] = 1;
      blocks_[blockOf(column, row)] = 1;
    }
  }
  /// Cells (a value each) that nothing is known of until it is their turn: they get no mark.
  void hold(std::vector<std::uint8_t> waiting) { waiting_ = std::move(waiting); }
  bool waits(std::size_t cell) const { return !waiting_.empty() && waiting_[cell] != 0; }
  bool has(std::size_t cell) const { return marks_[cell] != 0; }
  /// False when no column of the sheet has a mark: most sheets are told apart by blocks of columns.
  bool mayHave(const HeldSheet& sheet) const;
  const GridShape& window() const { return window_; }
  /// The cell of a patch in the window; -1 outside.
  std::int64_t cellOf(const HeldPatch& p) const {
    const std::int32_t column = p.column - window_.first_column, row = p.row - window_.first_row;
    return window_.contains(column, row) ? window_.cell(column, row) : -1;
  }

 private:
  static constexpr std::int32_t kBlock = 8;  // columns, its edge
  std::size_t blockOf(std::int32_t column, std::int32_t row) const {
    return static_cast<std::size_t>(row / kBlock) * static_cast<std::size_t>(blocks_wide_) +
           static_cast<std::size_t>(column / kBlock);
  }

  GridShape window_;
  std::int32_t blocks_wide_ = 0;
  std::vector<std::uint8_t> marks_;    // a value a cell
  std::vector<std::uint8_t> waiting_;  // a value a cell, or empty: none
  std::vector<std::uint8_t> blocks_;   // a value a block: some cell of it has a mark
};

/// The sheets of a map's leaves around a window, kept from one state of the map to the next: only leaves that changed
/// are placed and sampled again.
class HeldSheets {
 public:
  /// Follows the map where it is the turn, and adds to `changed` the columns in which patches came, went or changed. A
  /// leaf that changed where it is not stays as it was. What has left the map is left out at once.
  void update(const MapLeaves& map, const Turn& turn, ChangedColumns& changed);

  /// The sheets that enough points speak for and that may touch the window, in the order of the map.
  const std::vector<HeldSheet*>& believed() const { return believed_; }

 private:
  struct HeldNode {
    MapNode node;  // as it was
    NodeView view;
    Eigen::AlignedBox2d box;        // m, map frame: around all its sheets
    std::vector<HeldSheet> sheets;  // of nodes that may touch the window
    std::int32_t views = 0;         // how often the view has changed
    bool is_current = false;        // in the map that is being followed
    bool is_behind = false;         // some leaf waits for its turn
  };
  void follow(const MapLeaves& map, const MapNode& node, const Turn& turn, ChangedColumns& changed);
  static void place(std::span<const Leaf> leaves, const Turn& turn, HeldNode& held, ChangedColumns& changed);
  void believe(ChangedColumns& changed);

  std::map<NodeId, HeldNode> nodes_;
  std::vector<HeldSheet*> believed_;
};

}  // namespace hgg
