#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bag/bag.h"
#include "core/types.h"

namespace hgg {

/// The messages that are read of bags, with the fields that are used. Decoding is bounded by the bytes there are and
/// gives nothing for a message that is cut or of another definition.

struct RosHeader {
  std::int64_t stamp_ns = 0;
  std::string frame;  // without the slash that early ROS has before it
};

struct RosField {
  std::string name;
  std::uint32_t offset = 0, count = 0;
  std::uint8_t datatype = 0;  // sensor_msgs/PointField: 1 int8 .. 8 float64
};

/// sensor_msgs/PointCloud2.
struct RosCloud {
  RosHeader header;
  std::uint32_t height = 0, width = 0, point_step = 0, row_step = 0;
  bool is_bigendian = false;
  std::vector<RosField> fields;
  std::span<const std::uint8_t> data;  // of the message
};

/// A pose as it was written: what is converted stays the same to the last bit.
struct RosPose {
  Vec3 position = Vec3::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();

  Pose pose() const { return Eigen::Translation3d(position) * orientation.normalized(); }
};

/// nav_msgs/Odometry, or a transform of a tf2_msgs/TFMessage.
struct RosTransform {
  RosHeader header;  // the parent frame
  std::string child;
  RosPose T_parent_child;
};

/// sensor_msgs/Image.
struct RosImage {
  RosHeader header;
  std::uint32_t height = 0, width = 0, step = 0;
  std::string encoding;
  bool is_bigendian = false;
  std::span<const std::uint8_t> data;  // of the message
};

/// sensor_msgs/CameraInfo.
struct RosCamera {
  RosHeader header;
  std::uint32_t height = 0, width = 0;
  std::string distortion_model;
  std::vector<double> distortion;
  std::array<double, 9> intrinsics{};  // row by row
};

/// True of the types that transforms come in, of tf2 and of tf before it.
inline bool holdsTransforms(const std::string& type) { return type == "tf2_msgs/TFMessage" || type == "tf/tfMessage"; }

std::optional<RosCloud> readCloud(const BagMessage& message);
std::optional<RosTransform> readOdometry(const BagMessage& message);
std::optional<std::vector<RosTransform>> readTransforms(const BagMessage& message);
std::optional<RosImage> readImage(const BagMessage& message);
std::optional<RosCamera> readCamera(const BagMessage& message);

}  // namespace hgg
