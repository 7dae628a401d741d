#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "core/types.h"

namespace hgg {

/// A room of a world: boxes that join each other, from the middle of one wall to the middle of the next.
struct TruthRoom {
  std::string name;
  std::vector<Eigen::AlignedBox3d> parts = {};  // world frame, m
};

/// Which rooms a world has; no room where it has none.
struct TruthRooms {
  Pose T_world_map = Pose::Identity();
  std::vector<TruthRoom> rooms = {};
};

/// The room that a place is in, as an index. What hangs in a wall is in the room on one side of it; nullopt where that
/// has a room on both, as for a closed door, and outside.
std::optional<std::size_t> roomAt(const TruthRooms& rooms, const Vec3& p_map);

/// rooms.json: {"T_world_map":[12, rows],"rooms":[{"name","parts":[[x0,y0,z0,x1,y1,z1],...]}]}. Returns an error line,
/// empty when done.
std::string writeRooms(const TruthRooms& rooms, const std::filesystem::path& path);
Result<TruthRooms> readRooms(const std::filesystem::path& path);

}  // namespace hgg
