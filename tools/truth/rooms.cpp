#include "truth/rooms.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <nlohmann/json.hpp>

#include "truth/poses.h"

namespace hgg {
namespace {

using nlohmann::json;

/// How far beyond a room's box a thing may lie that is in it, m: what hangs in a wall, and half of a wall's thickness.
constexpr double kInWall = 0.1;

TruthRoom roomOf(const json& entry) {
  TruthRoom room{entry.at("name").get<std::string>()};
  for (const json& part : entry.at("parts")) {
    const auto c = part.get<std::array<double, 6>>();
    room.parts.emplace_back(Vec3(c[0], c[1], c[2]), Vec3(c[3], c[4], c[5]));
  }
  return room;
}

}  // namespace

std::optional<std::size_t> roomAt(const TruthRooms& rooms, const Vec3& p_map) {
  const Vec3 p = rooms.T_world_map * p_map;
  std::optional<std::size_t> found;
  for (std::size_t k = 0; k < rooms.rooms.size(); ++k) {
    const bool is_in = std::ranges::any_of(
        rooms.rooms[k].parts, [&](const Eigen::AlignedBox3d& part) { return part.exteriorDistance(p) <= kInWall; });
    if (is_in && found) {
      return std::nullopt;
    }
    found = is_in ? std::optional(k) : found;
  }
  return found;
}

std::string writeRooms(const TruthRooms& rooms, const std::filesystem::path& path) {
  json out{{"T_world_map", json::array()}, {"rooms", json::array()}};
  for (int i = 0; i < 12; ++i) {
    out["T_world_map"].push_back(rooms.T_world_map.matrix()(i / 4, i % 4));
  }
  for (const TruthRoom& room : rooms.rooms) {
    json parts = json::array();
    for (const Eigen::AlignedBox3d& part : room.parts) {
      const Vec3 &lo = part.min(), &hi = part.max();
      parts.push_back({lo.x(), lo.y(), lo.z(), hi.x(), hi.y(), hi.z()});
    }
    out["rooms"].push_back({{"name", room.name}, {"parts", std::move(parts)}});
  }
  std::ofstream file(path);
  file << out.dump(1) << "\n";
  file.close();
  return file ? "" : "cannot write " + path.string();
}

Result<TruthRooms> readRooms(const std::filesystem::path& path) {
  std::ifstream in(path);
  if (!in) {
    return Result<TruthRooms>::fail("cannot read " + path.string());
  }
  try {
    const json file = json::parse(in);
    const auto pose = poseOfRow(file.at("T_world_map").get<std::array<double, 12>>());
    if (!pose) {
      return Result<TruthRooms>::fail(path.string() + ": T_world_map is no pose");
    }
    TruthRooms rooms{*pose};
    for (const json& entry : file.at("rooms")) {
      rooms.rooms.push_back(roomOf(entry));
    }
    return Result<TruthRooms>::ok(std::move(rooms));
  } catch (const json::exception& e) {
    return Result<TruthRooms>::fail(path.string() + " is not a list of rooms: " + e.what());
  }
}

}  // namespace hgg
