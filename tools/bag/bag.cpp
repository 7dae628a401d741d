#include "bag/bag.h"

namespace hgg {

namespace fs = std::filesystem;

Result<BagEnd> readBag(const fs::path& path, const BagVisitor& visit, const BagProgress& progress) {
  std::error_code error;
  if (!fs::exists(path, error)) {
    return Result<BagEnd>::fail("there is no " + path.string());
  }
  if (path.extension() == ".mcap") {
    return Result<BagEnd>::fail(path.string() +
                                ": MCAP is not read; `ros2 bag convert` or `mcap convert` make a ROS bag of it "
                                "(docs/rosbags.md)");
  }
  const bool is_ros2 = fs::is_directory(path, error) || path.extension() == ".db3";
  return is_ros2 ? readRos2Bag(path, visit, progress) : readRos1Bag(path, visit, progress);
}

}  // namespace hgg
