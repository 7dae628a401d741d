#pragma once

#include <map>
#include <span>
#include <vector>

#include "traversability/columns.h"

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
  bool is_sampled = false, is_believed = false;
  bool is_obsolete = false;  // in all of its columns
};

/// The columns of a window that something has changed in.
class ChangedColumns {
 public:
  explicit ChangedColumns(const GridShape& window)
      : window_(window), marks_(static_cast<std::size_t>(window.cells()), 0) {}
  void add(const HeldSheet& sheet) {
    for (const HeldPatch& p : sheet.patches) {
      const std::int64_t cell = cellOf(p);
      if (cell >= 0) {
        add(static_cast<std::size_t>(cell));
      }
    }
  }
  void add(std::size_t cell) { marks_[cell] = 1; }
  bool has(std::size_t cell) const { return marks_[cell] != 0; }
  const GridShape& window() const { return window_; }
  /// The cell of a patch in the window; -1 outside.
  std::int64_t cellOf(const HeldPatch& p) const {
    const std::int32_t column = p.column - window_.first_column, row = p.row - window_.first_row;
    return window_.contains(column, row) ? window_.cell(column, row) : -1;
  }

 private:
  GridShape window_;
  std::vector<std::uint8_t> marks_;  // a value a cell
};

/// The sheets of a map's leaves around a window, kept from one state of the map to the next: only leaves that changed
/// are placed and sampled again.
class HeldSheets {
 public:
  /// Follows the map, and adds to `changed` the columns in which patches came, went or changed.
  void update(const MapLeaves& map, ChangedColumns& changed);

  /// The sheets that enough points speak for and that may touch the window, in the order of the map.
  const std::vector<HeldSheet*>& believed() const { return believed_; }

 private:
  struct HeldNode {
    MapNode node;  // as it was
    NodeView view;
    Eigen::AlignedBox2d box;        // m, map frame: around all its sheets
    std::vector<HeldSheet> sheets;  // of nodes that may touch the window
    bool is_current = false;        // in the map that is being followed
  };
  void follow(const MapLeaves& map, const MapNode& node, ChangedColumns& changed);
  static void place(std::span<const Leaf> leaves, bool is_same_view, HeldNode& held, ChangedColumns& changed);
  void believe(ChangedColumns& changed);

  std::map<NodeId, HeldNode> nodes_;
  std::vector<HeldSheet*> believed_;
};

}  // namespace hgg
