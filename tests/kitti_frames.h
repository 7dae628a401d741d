#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "creation/cluster.h"

namespace hgg {

/// Folder with the first `frames` frames of the real sequence beside the repository, unpacked on first use; nullopt
/// where the data is absent.
inline std::optional<std::string> findKittiFrames(int frames) {
  namespace fs = std::filesystem;
  const char* given = std::getenv("HGG_DATA");
  const fs::path data = given != nullptr ? fs::path(given) : fs::path(HGG_SOURCE_DIR) / ".." / "shared" / "data";
  if (!fs::exists(data / "unpack.py")) {
    return std::nullopt;
  }
  const fs::path out = fs::path(HGG_BINARY_DIR) / ("kitti_0001_" + std::to_string(frames));
  if (!fs::exists(out / "done")) {
    const std::string command = "python3 '" + (data / "unpack.py").string() + "' '" + (data / "kitti_0001").string() +
                                "' '" + out.string() + "' --frames " + std::to_string(frames) +
                                " > /dev/null && touch '" + (out / "done").string() + "'";
    if (std::system(command.c_str()) != 0) {
      return std::nullopt;
    }
  }
  return out.string();
}

/// The points of frame `index`, body frame.
inline std::vector<PackedPoint> readKittiPoints(const std::string& folder, int index) {
  char name[32];
  std::snprintf(name, sizeof(name), "/velodyne/%06d.bin", index);
  std::ifstream file(folder + name, std::ios::binary);
  std::vector<PackedPoint> points;
  float xyzi[4];
  while (file.read(reinterpret_cast<char*>(xyzi), sizeof(xyzi))) {
    points.emplace_back(xyzi[0], xyzi[1], xyzi[2], 0.0F);
  }
  return points;
}

}  // namespace hgg
