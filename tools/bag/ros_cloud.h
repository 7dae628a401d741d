#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bag/ros_messages.h"

namespace hgg {

/// Points of a cloud with what the fields say of each.
struct RosPoints {
  std::vector<Point> points;
  std::vector<float> times;  // s after the stamp; empty: the cloud has none
};

/// Names of fields; empty: there is none.
struct RosFieldNames {
  std::string label, instance;
};

/// x, y, z and the named fields of all points with finite coordinates, of whatever type they are; nothing where one is
/// missing or does not lie in the data. Times are read of the fields that drivers give them: "time" and "timestamp" in
/// seconds, "t" in nanoseconds, as far as they are times after the stamp.
std::optional<RosPoints> pointsOf(const RosCloud& cloud, const RosFieldNames& names);

}  // namespace hgg
