#include "bag/ros_messages.h"

#include <cstring>

namespace hgg {
namespace {

/// Reads the values of a message one after the other, as ROS 1 packs them or as CDR aligns them. After the first one
/// that is not there all are 0, and failed() is true.
class RosReader {
 public:
  explicit RosReader(const BagMessage& message) : bytes_(message.data), is_cdr_(message.wire == BagWire::kCdr) {
    if (is_cdr_) {
      // Its head says how it is written: plain CDR, little-endian.
      failed_ = bytes_.size() < kCdrHead || bytes_[0] != 0 || bytes_[1] != 1;
      bytes_ = failed_ ? bytes_ : bytes_.subspan(kCdrHead);
    }
  }

  bool isCdr() const { return is_cdr_; }
  bool failed() const { return failed_; }

  template <typename T>
  T value() {
    align(sizeof(T));
    T v{};
    if (const auto raw = take(sizeof(T)); !failed_) {
      std::memcpy(&v, raw.data(), sizeof v);
    }
    return v;
  }
  std::uint8_t u8() { return value<std::uint8_t>(); }
  std::uint32_t u32() { return value<std::uint32_t>(); }
  double f64() { return value<double>(); }

  std::string text() {
    const auto raw = take(u32());
    std::string s(reinterpret_cast<const char*>(raw.data()), raw.size());
    // CDR counts the zero at the end.
    if (!s.empty() && s.back() == '\0') {
      s.pop_back();
    }
    return s;
  }
  std::span<const std::uint8_t> blob() { return take(u32()); }

  /// How many elements of at least `bytes` each follow; 0 where there cannot be as many.
  std::uint32_t count(std::size_t bytes) {
    const std::uint32_t n = u32();
    failed_ = failed_ || n > (bytes_.size() - at_) / bytes;
    return failed_ ? 0 : n;
  }

 private:
  static constexpr std::size_t kCdrHead = 4;

  void align(std::size_t size) {
    if (is_cdr_) {
      take((size - at_ % size) % size);
    }
  }
  std::span<const std::uint8_t> take(std::size_t size) {
    if (failed_ || size > bytes_.size() - at_) {
      failed_ = true;
      return {};
    }
    at_ += size;
    return bytes_.subspan(at_ - size, size);
  }

  std::span<const std::uint8_t> bytes_;
  bool is_cdr_;
  std::size_t at_ = 0;
  bool failed_ = false;
};

std::string frameName(std::string name) {
  if (name.starts_with('/')) {
    name.erase(0, 1);
  }
  return name;
}

RosHeader header(RosReader& in) {
  if (!in.isCdr()) {
    in.u32();  // seq
  }
  RosHeader h;
  const std::int64_t seconds = in.isCdr() ? std::int64_t{in.value<std::int32_t>()} : std::int64_t{in.u32()};
  h.stamp_ns = seconds * 1'000'000'000 + in.u32();
  h.frame = frameName(in.text());
  return h;
}

Vec3 vector(RosReader& in) {
  const double x = in.f64(), y = in.f64(), z = in.f64();
  return {x, y, z};
}

RosPose pose(RosReader& in) {
  RosPose p;
  p.position = vector(in);
  const double x = in.f64(), y = in.f64(), z = in.f64(), w = in.f64();
  p.orientation = Eigen::Quaterniond(w, x, y, z);
  return p;
}

template <typename T>
std::optional<T> unlessFailed(const RosReader& in, T&& value) {
  return in.failed() ? std::nullopt : std::optional<T>(std::forward<T>(value));
}

}  // namespace

std::optional<RosCloud> readCloud(const BagMessage& message) {
  RosReader in(message);
  RosCloud cloud;
  cloud.header = header(in);
  cloud.height = in.u32(), cloud.width = in.u32();
  constexpr std::size_t kLeastFieldBytes = 13;  // an empty name
  for (std::uint32_t k = in.count(kLeastFieldBytes); k > 0 && !in.failed(); --k) {
    RosField field;
    field.name = in.text(), field.offset = in.u32(), field.datatype = in.u8(), field.count = in.u32();
    cloud.fields.push_back(std::move(field));
  }
  cloud.is_bigendian = in.u8() != 0;
  cloud.point_step = in.u32(), cloud.row_step = in.u32();
  cloud.data = in.blob();
  return unlessFailed(in, std::move(cloud));
}

std::optional<RosTransform> readOdometry(const BagMessage& message) {
  RosReader in(message);
  RosTransform t;
  t.header = header(in);
  t.child = frameName(in.text());
  t.T_parent_child = pose(in);
  return unlessFailed(in, std::move(t));
}

std::optional<std::vector<RosTransform>> readTransforms(const BagMessage& message) {
  RosReader in(message);
  std::vector<RosTransform> transforms;
  constexpr std::size_t kLeastTransformBytes = 72;
  for (std::uint32_t k = in.count(kLeastTransformBytes); k > 0 && !in.failed(); --k) {
    RosTransform t;
    t.header = header(in);
    t.child = frameName(in.text());
    t.T_parent_child = pose(in);
    transforms.push_back(std::move(t));
  }
  return unlessFailed(in, std::move(transforms));
}

std::optional<RosImage> readImage(const BagMessage& message) {
  RosReader in(message);
  RosImage image;
  image.header = header(in);
  image.height = in.u32(), image.width = in.u32();
  image.encoding = in.text();
  image.is_bigendian = in.u8() != 0;
  image.step = in.u32();
  image.data = in.blob();
  return unlessFailed(in, std::move(image));
}

std::optional<RosCamera> readCamera(const BagMessage& message) {
  RosReader in(message);
  RosCamera camera;
  camera.header = header(in);
  camera.height = in.u32(), camera.width = in.u32();
  camera.distortion_model = in.text();
  for (std::uint32_t k = in.count(sizeof(double)); k > 0 && !in.failed(); --k) {
    camera.distortion.push_back(in.f64());
  }
  for (double& v : camera.intrinsics) {
    v = in.f64();
  }
  return unlessFailed(in, std::move(camera));
}

}  // namespace hgg
