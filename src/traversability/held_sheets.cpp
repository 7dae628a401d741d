#include "traversability/held_sheets.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/units.h"
#include "traversability/point_density.h"

namespace hgg {
namespace {

/// Leaves of a node keep their order but for those that come and go: how far on a leaf is looked for.
constexpr std::size_t kLookAhead = 32;

bool isSame(const Leaf& a, const Leaf& b) { return a.mean == b.mean && a.cov == b.cov && a.kappa == b.kappa; }

bool isSame(const PlacedSheet& a, const PlacedSheet& b) {
  const LeafSheet &s = a.sheet, &t = b.sheet;
  return a.views == b.views && a.carries == b.carries && s.centre == t.centre && s.along == t.along &&
         s.across == t.across && s.normal == t.normal && s.half_along == t.half_along &&
         s.half_across == t.half_across && s.thickness == t.thickness && s.kappa == t.kappa;
}

/// The sheet of before that the leaf still has, from `next` on; before.size(): none is near.
std::size_t findSame(const std::vector<HeldSheet>& before, std::size_t next, const Leaf& leaf) {
  for (std::size_t k = next; k < std::min(before.size(), next + kLookAhead); ++k) {
    if (isSame(before[k].leaf, leaf)) {
      return k;
    }
  }
  return before.size();
}

/// True where no leaf came or went, as far as can be seen: they need not be looked for.
bool areMostlySame(const std::vector<HeldSheet>& before, std::span<const Leaf> leaves) {
  std::size_t same = 0;
  for (std::size_t k = 0; before.size() == leaves.size() && k < leaves.size(); ++k) {
    same += isSame(before[k].leaf, leaves[k]) ? 1 : 0;
  }
  return 2 * same > leaves.size();
}

void dropAll(const std::vector<HeldSheet>& sheets, ChangedColumns& changed) {
  for (const HeldSheet& sheet : sheets) {
    if (sheet.is_believed) {
      changed.add(sheet);
    }
  }
}

/// A box that the sheets of all leaves lie in, without placing them.
Eigen::AlignedBox2d boxOf(const Leaves& leaves, const Pose& T_map_object) {
  constexpr double kSquareOfReach = 9;  // sheets reach 2 sqrt(2) times the root of the trace at most
  Eigen::AlignedBox2d box;
  for (const Leaf& leaf : leaves) {
    const Vec3 p = T_map_object * Eigen::Vector3f(leaf.mean.data()).cast<double>();
    const double reach = std::sqrt(kSquareOfReach * (leaf.cov[0] + leaf.cov[1] + leaf.cov[2]));
    box.extend(Eigen::Vector2d(p.head<2>().array() - reach));
    box.extend(Eigen::Vector2d(p.head<2>().array() + reach));
  }
  return box;
}

Eigen::AlignedBox2d boxOf(const GridShape& window) {
  return {Eigen::Vector2d(window.x, window.y),
          Eigen::Vector2d(window.x + window.width * window.resolution, window.y + window.height * window.resolution)};
}

/// The cells under one sheet.
GridShape shapeUnder(const LeafSheet& sheet, double resolution) {
  const Vec3 half = halfDrawn(sheet), low = sheet.centre - half, high = sheet.centre + half;
  GridShape shape;
  shape.resolution = resolution;
  const std::int32_t column = shape.columnOf(low.x()), row = shape.rowOf(low.y());
  shape.width = shape.columnOf(high.x()) - column + 1, shape.height = shape.rowOf(high.y()) - row + 1;
  shape.first_column = column, shape.first_row = row;
  shape.x = column * resolution, shape.y = row * resolution;
  return shape;
}

void sample(HeldSheet& sheet, double resolution, std::vector<SheetPatch>& scratch) {
  const GridShape shape = shapeUnder(sheet.placed.sheet, resolution);
  scratch.clear();
  appendPatches(sheet.placed, 0, shape, scratch);
  sheet.is_sampled = true;
  sheet.patches.clear();
  sheet.patches.reserve(scratch.size());
  for (const SheetPatch& p : scratch) {
    sheet.patches.push_back(
        {shape.first_column + p.cell % shape.width, shape.first_row + p.cell / shape.width, p.bottom, p.top, p.height});
  }
  sheet.first_column = shape.first_column, sheet.last_column = shape.first_column + shape.width - 1;
  sheet.first_row = shape.first_row, sheet.last_row = shape.first_row + shape.height - 1;
  sheet.common = scratch.empty() ? SheetPatch{} : scratch.front();
}

}  // namespace

ChangedColumns::ChangedColumns(const GridShape& window)
    : window_(window),
      blocks_wide_(window.width / kBlock + 1),
      marks_(static_cast<std::size_t>(window.cells()), 0),
      blocks_(static_cast<std::size_t>(blocks_wide_) * static_cast<std::size_t>(window.height / kBlock + 1), 0) {}

void ChangedColumns::add(const HeldSheet& sheet) {
  for (const HeldPatch& p : sheet.patches) {
    if (cellOf(p) >= 0) {
      add(p.column - window_.first_column, p.row - window_.first_row);
    }
  }
}

bool ChangedColumns::mayHave(const HeldSheet& sheet) const {
  const std::int32_t left = std::max(0, sheet.first_column - window_.first_column) / kBlock;
  const std::int32_t right = std::min(window_.width - 1, sheet.last_column - window_.first_column) / kBlock;
  const std::int32_t low = std::max(0, sheet.first_row - window_.first_row) / kBlock;
  const std::int32_t high = std::min(window_.height - 1, sheet.last_row - window_.first_row) / kBlock;
  for (std::int32_t row = low; row <= high; ++row) {
    for (std::int32_t column = left; column <= right; ++column) {
      if (blocks_[blockOf(column * kBlock, row * kBlock)] != 0) {
        return true;
      }
    }
  }
  return false;
}

void HeldSheets::update(const MapLeaves& map, const Turn& turn, ChangedColumns& changed) {
  for (auto& [id, held] : nodes_) {
    held.is_current = false;
  }
  for (const auto& [id, node] : map.nodes) {
    if (isSolid(node)) {
      follow(map, node, turn, changed);
    }
  }
  std::erase_if(nodes_, [&](const auto& entry) {
    const HeldNode& held = entry.second;
    if (!held.is_current) {
      dropAll(held.sheets, changed);
    }
    return !held.is_current;
  });
  believe(changed);
}

void HeldSheets::follow(const MapLeaves& map, const MapNode& node, const Turn& turn, ChangedColumns& changed) {
  const auto [it, is_new] = nodes_.try_emplace(node.id);
  HeldNode& held = it->second;
  const NodeView view = viewOf(map, node);
  const bool is_same_view = !is_new && view == held.view;
  const bool has_same_leaves = !is_new && &leavesOf(node) == &leavesOf(held.node);
  held.is_current = true;
  held.views += is_same_view ? 0 : 1;
  if (!is_same_view || !has_same_leaves) {
    held.box = boxOf(leavesOf(node), view.T_map_object);
  }
  const bool is_near = held.box.intersects(boxOf(changed.window()));
  const bool is_held = !held.sheets.empty();
  held.node = node;  // which keeps its leaves where they are
  held.view = view;
  if (!is_near) {
    dropAll(held.sheets, changed);
    held.sheets.clear();
    held.is_behind = false;
  } else if (!is_held || !is_same_view || !has_same_leaves || held.is_behind) {
    place(leavesOf(node), turn, held, changed);
  }
}

/// The sheets of the leaves: those of before where a leaf is as it was, or where it is not the turn.
void HeldSheets::place(std::span<const Leaf> leaves, const Turn& turn, HeldNode& held, ChangedColumns& changed) {
  std::vector<HeldSheet> before = std::exchange(held.sheets, {});
  held.sheets.reserve(leaves.size());
  held.is_behind = false;
  const double resolution = changed.window().resolution;
  const auto isDue = [&](const Vec3& p_map) {
    return turn.isDue(static_cast<std::int32_t>(std::floor(p_map.x() / resolution)),
                      static_cast<std::int32_t>(std::floor(p_map.y() / resolution)));
  };
  // A sheet of before, a leaf of now, or one that became the other.
  const auto take = [&](HeldSheet* old, const Leaf* leaf) {
    const bool is_due =
        (old != nullptr && isDue(old->placed.sheet.centre)) ||
        (leaf != nullptr && isDue(held.view.T_map_object * Eigen::Vector3f(leaf->mean.data()).cast<double>()));
    if (!is_due) {
      held.is_behind = true;
      if (old != nullptr) {
        held.sheets.push_back(std::move(*old));
      }
      return;
    }
    const PlacedSheet placed = leaf != nullptr ? placeLeaf(*leaf, held.view) : PlacedSheet{};
    if (old != nullptr && leaf != nullptr && isSame(old->placed, placed)) {
      held.sheets.push_back(std::move(*old));  // another view of it that shows the same
      held.sheets.back().leaf = *leaf, held.sheets.back().view = held.views;
      return;
    }
    if (old != nullptr && old->is_believed) {
      changed.add(*old);
    }
    if (leaf != nullptr) {
      held.sheets.push_back({*leaf, placed, {}, {}});
      held.sheets.back().view = held.views;
    }
  };
  const bool keeps_order = areMostlySame(before, leaves);
  std::size_t next = 0, fresh = 0;  // of before and of the leaves: what is not dealt with yet
  const auto takeUpTo = [&](std::size_t end_before, std::size_t end_leaves) {
    while (next < end_before || fresh < end_leaves) {
      HeldSheet* old = next < end_before ? &before[next++] : nullptr;
      take(old, fresh < end_leaves ? &leaves[fresh++] : nullptr);
    }
  };
  for (std::size_t k = 0; k < leaves.size(); ++k) {
    const std::size_t found = keeps_order ? k : findSame(before, next, leaves[k]);
    if (found < before.size() && isSame(before[found].leaf, leaves[k])) {
      takeUpTo(found, k);
      if (before[found].view == held.views) {
        held.sheets.push_back(std::move(before[found]));
      } else {
        take(&before[found], &leaves[k]);
      }
      next = found + 1, fresh = k + 1;
    }
  }
  takeUpTo(before.size(), leaves.size());
}

/// What is believed depends on what else lies around a sheet, and on the window where its density is taken.
void HeldSheets::believe(ChangedColumns& changed) {
  const GridShape& window = changed.window();
  std::vector<HeldSheet*> touching;
  PointDensity density;
  for (auto& [id, held] : nodes_) {
    for (HeldSheet& sheet : held.sheets) {
      if (mayTouch(sheet.placed.sheet, window)) {
        density.add(sheet.placed.sheet);
        touching.push_back(&sheet);
      } else if (sheet.is_believed) {
        changed.add(sheet);
        sheet.is_believed = false;
      }
    }
  }
  believed_.clear();
  std::vector<SheetPatch> scratch;
  for (HeldSheet* sheet : touching) {
    const bool is_believed = density.believes(sheet->placed.sheet);
    if (is_believed && !sheet->is_sampled) {
      sample(*sheet, window.resolution, scratch);
    }
    if (is_believed != sheet->is_believed) {
      changed.add(*sheet);
      sheet->is_believed = is_believed;
    }
    if (is_believed) {
      believed_.push_back(sheet);
    }
  }
}

}  // namespace hgg
