#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "core/result.h"

namespace hgg {

/// How the messages of a bag are written: ROS 1 packs values, CDR (ROS 2) aligns them.
enum class BagWire : std::uint8_t { kRos1, kCdr };

/// A message of a bag. Views into the bag's buffers, valid while the visitor runs.
struct BagMessage {
  std::string topic, type;    // "/points", "sensor_msgs/PointCloud2": of ROS 2 types the "/msg" is left out
  std::int64_t stamp_ns = 0;  // when it was recorded
  BagWire wire = BagWire::kRos1;
  std::span<const std::uint8_t> data;
};

/// How a bag was read.
struct BagEnd {
  std::int64_t messages = 0;
  std::string damage;  // what could not be read and why; empty: nothing
};

/// Told of every message, in the order they are stored; false ends the reading.
using BagVisitor = std::function<bool(const BagMessage&)>;
/// Told how far the reading is, 0..1.
using BagProgress = std::function<void(double)>;

/// Reads a ROS 1 bag (*.bag, format 2.0; chunks raw, bz2 or lz4) or a ROS 2 bag in SQLite storage (a *.db3 or the
/// folder with metadata.yaml). A cut or damaged bag is read as far as it is whole, and BagEnd says what is missing.
/// Errors: no such file, no bag, a storage or a compression that is not read.
Result<BagEnd> readBag(const std::filesystem::path& path, const BagVisitor& visit, const BagProgress& progress);

/// The two kinds. readBag() tells them apart.
Result<BagEnd> readRos1Bag(const std::filesystem::path& path, const BagVisitor& visit, const BagProgress& progress);
Result<BagEnd> readRos2Bag(const std::filesystem::path& path, const BagVisitor& visit, const BagProgress& progress);

}  // namespace hgg
