#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "core/result.h"
#include "core/types.h"

namespace hgg {

/// What the robot can do.
struct WalkLimits {
  double step = 0.20;         // m, up or down
  double slope_deg = 30.0;    // of the surface
  double body_height = 0.70;  // m, that have to be free above the surface
};

/// How near to a limit a place may be before nobody can say on which side a map has to have it: the range noise of the
/// LiDARs (2 cm), and what it makes of a slope over 0.5 m.
struct LimitMargins {
  double step = 0.02;         // m
  double slope_deg = 2.0;     // deg
  double body_height = 0.02;  // m
};

enum class Standing : std::uint8_t {
  kFree = 0,
  kBlocked = 1,  // too steep, too deep a step down beside it, no ground there, or something in the cell
  kClose = 2     // nearer to a limit than the margins: it counts neither way
};

/// A surface in one cell that something could stand on.
struct WalkSurface {
  float height = 0;  // m, at the cell's middle
  Standing standing = Standing::kFree;
  /// Not part of the ground: no way of steps leads there from where the robot went, whatever stands on that way. Table
  /// tops and car roofs are islands; the floor below a car is not, it is blocked ground.
  bool island = false;
  std::uint32_t returns = 0;  // beams that came back from it, or from what blocks it
  ClassId cause = 0;          // of what is blocked: the class of what takes the room, or one of those below; else 0
};
inline constexpr ClassId kCauseEdge = 65535;   // it drops, or there is no ground beside it
inline constexpr ClassId kCauseSlope = 65534;  // it is too steep

/// Where one can walk in a world, seen from above: square cells, each with the surfaces one above the other. Only cells
/// near the way have any. Nothing is grown by the robot's size.
struct WalkGrid {
  Pose T_grid_map = Pose::Identity();  // from the truth's frame to this one, whose z points straight up
  double origin_x = 0, origin_y = 0;   // m: the corner of cell (0, 0) with the least x and y
  double resolution = 0.1;             // m
  int width = 0, height = 0;           // cells along x and y
  double reach = 0;                    // m from the way up to which cells are filled
  WalkLimits limits;
  std::vector<std::uint8_t> known;   // by cell: near the way; a known cell without surfaces is a void
  std::vector<std::uint32_t> first;  // by cell, and the end: its surfaces, lowest first
  std::vector<WalkSurface> surfaces;

  std::size_t cells() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
  std::span<const WalkSurface> column(std::size_t cell) const {
    return {surfaces.data() + first[cell], surfaces.data() + first[cell + 1]};
  }
  /// The cell that holds (x, y), in the grid's frame; nullopt outside.
  std::optional<std::size_t> cellOf(double x, double y) const;
  Vec3 middle(std::size_t cell, double z) const;
};

/// The surface of the cell nearest in height, up to `reach` m away; nullopt when there is none.
std::optional<std::size_t> surfaceNear(const WalkGrid& grid, std::size_t cell, double z, double reach);

/// walk_grid.json and walk_grid.{known,cell,height,standing,island,returns,cause}.npy (docs/simulator.md). Returns an
/// error line, empty when done.
std::string writeWalkGrid(const WalkGrid& grid, const std::filesystem::path& dir);
Result<WalkGrid> readWalkGrid(const std::filesystem::path& dir);
/// The files' names.
std::vector<std::string> walkGridFiles();

}  // namespace hgg
