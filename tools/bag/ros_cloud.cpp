#include "bag/ros_cloud.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace hgg {
namespace {

constexpr std::array<std::size_t, 9> kDatatypeBytes = {0, 1, 1, 2, 2, 4, 4, 4, 8};  // sensor_msgs/PointField
constexpr double kNano = 1e-9;

/// Reads one value of a point as its field says.
class Column {
 public:
  Column(const RosField* field, std::size_t point_step) : field_(field) {
    const bool is_known = field != nullptr && field->datatype < kDatatypeBytes.size() && field->datatype > 0;
    fits_ = is_known && field->offset + kDatatypeBytes[field->datatype] <= point_step;
  }

  bool fits() const { return fits_; }
  bool isNamed(const char* name) const { return fits_ && field_->name == name; }

  double at(const std::uint8_t* point) const {
    const std::uint8_t* raw = point + field_->offset;
    switch (field_->datatype) {
      case 1:
        return as<std::int8_t>(raw);
      case 2:
        return as<std::uint8_t>(raw);
      case 3:
        return as<std::int16_t>(raw);
      case 4:
        return as<std::uint16_t>(raw);
      case 5:
        return as<std::int32_t>(raw);
      case 6:
        return as<std::uint32_t>(raw);
      case 7:
        return as<float>(raw);
      default:
        return as<double>(raw);
    }
  }

  template <typename T>
  T within(const std::uint8_t* point) const {
    const double value = at(point);
    return std::isfinite(value) ? static_cast<T>(std::clamp<double>(value, 0, std::numeric_limits<T>::max())) : T{0};
  }

 private:
  template <typename T>
  static double as(const std::uint8_t* raw) {
    T value{};
    std::memcpy(&value, raw, sizeof value);
    return static_cast<double>(value);
  }

  const RosField* field_;
  bool fits_ = false;
};

const RosField* find(const RosCloud& cloud, const std::string& name) {
  const auto field = std::ranges::find(cloud.fields, name, &RosField::name);
  return field != cloud.fields.end() ? &*field : nullptr;
}

/// A driver's time of a point as seconds after the cloud's stamp.
float secondsAfter(double value, bool is_nanoseconds, std::int64_t stamp_ns) {
  const double seconds = is_nanoseconds ? value * kNano : value;
  constexpr double kAbsolute = 1e6;  // s: no sweep lasts that long, so this is a time of day
  const double stamp = static_cast<double>(stamp_ns) * kNano;
  return static_cast<float>(std::abs(seconds) > kAbsolute ? seconds - stamp : seconds);
}

}  // namespace

std::optional<RosPoints> pointsOf(const RosCloud& cloud, const RosFieldNames& names) {
  const auto column = [&](const std::string& name) { return Column(find(cloud, name), cloud.point_step); };
  const Column x = column("x"), y = column("y"), z = column("z");
  const Column label = column(names.label), instance = column(names.instance);
  const Column time = column("time").fits() ? column("time") : column("t").fits() ? column("t") : column("timestamp");
  const std::size_t row = std::size_t{cloud.width} * cloud.point_step;
  const bool is_whole =
      cloud.height == 0 || (cloud.row_step >= row && cloud.data.size() / cloud.height >= cloud.row_step);
  if (!x.fits() || !y.fits() || !z.fits() || cloud.is_bigendian || !is_whole ||
      (!names.label.empty() && !label.fits()) || (!names.instance.empty() && !instance.fits())) {
    return std::nullopt;
  }
  RosPoints out;
  for (std::size_t r = 0; r < cloud.height; ++r) {
    for (std::size_t k = 0; k < cloud.width; ++k) {
      const std::uint8_t* point = cloud.data.data() + r * cloud.row_step + k * cloud.point_step;
      const Point p{static_cast<float>(x.at(point)), static_cast<float>(y.at(point)), static_cast<float>(z.at(point)),
                    instance.fits() ? instance.within<std::uint32_t>(point) : 0,
                    label.fits() ? label.within<ClassId>(point) : ClassId{0}};
      if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
        continue;
      }
      out.points.push_back(p);
      if (time.fits()) {
        out.times.push_back(secondsAfter(time.at(point), time.isNamed("t"), cloud.header.stamp_ns));
      }
    }
  }
  return out;
}

}  // namespace hgg
