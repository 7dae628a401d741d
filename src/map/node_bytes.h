#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

#include "core/belief.h"
#include "core/types.h"
#include "map/between_constraint.h"
#include "map/file_layout.h"
#include "map/node.h"

namespace hgg {

/// Numbers, poses and beliefs to the bytes of a map file (map/file.h), and back.

/// Puts one after the other.
class ByteWriter {
 public:
  template <typename T>
  void put(T value) {
    static_assert(std::is_arithmetic_v<T>);
    if constexpr (std::is_floating_point_v<T>) {
      finite_ = finite_ && std::isfinite(value);
    }
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  void put(std::string_view text) { bytes_.append(text); }
  void put(const Pose& T) {
    for (Eigen::Index i = 0; i < 3; ++i) {
      put(T.translation()[i]);
    }
    for (Eigen::Index i = 0; i < 9; ++i) {
      put(T.linear()(i / 3, i % 3));
    }
  }
  void put(const Belief& b) {
    for (Eigen::Index i = 0; i < 3; ++i) {
      put(b.mean[i]);
    }
    for (const auto& [r, c] : kMapCovarianceOrder) {
      put(b.cov(r, c));
    }
    put(b.kappa);
  }

  const std::string& bytes() const { return bytes_; }
  /// Leaves out the first `size` of what there is.
  void drop(std::size_t size) { bytes_.erase(0, size); }
  /// False when a number was not finite: the reader would refuse it.
  bool finite() const { return finite_; }

 private:
  std::string bytes_;
  bool finite_ = true;
};

/// Bounds-checked reader: after the first short or invalid item everything reads as zero and good() is false.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : rest_(bytes) {}
  template <typename T>
  T get() {
    T value{};
    if (const std::string_view bytes = take(sizeof(T)); !bytes.empty()) {
      std::memcpy(&value, bytes.data(), sizeof(T));
    }
    if constexpr (std::is_floating_point_v<T>) {
      good_ = good_ && std::isfinite(value);
    }
    return value;
  }
  std::string_view take(std::size_t n) {
    good_ = good_ && n <= rest_.size();
    const std::string_view bytes = good_ ? rest_.substr(0, n) : std::string_view{};
    rest_.remove_prefix(bytes.size());
    return bytes;
  }
  /// A count of items of at least `item_bytes` each; one that cannot fit in what is left is an error, not an
  /// allocation.
  std::size_t count(std::uint64_t n, std::size_t item_bytes) {
    good_ = good_ && n <= rest_.size() / item_bytes;
    return good_ ? static_cast<std::size_t>(n) : 0;
  }
  Pose pose() {
    Pose T = Pose::Identity();
    for (Eigen::Index i = 0; i < 3; ++i) {
      T.translation()[i] = get<double>();
    }
    for (Eigen::Index i = 0; i < 9; ++i) {
      T.linear()(i / 3, i % 3) = get<double>();
    }
    return T;
  }
  Belief belief() {
    Belief b;
    for (Eigen::Index i = 0; i < 3; ++i) {
      b.mean[i] = get<double>();
    }
    for (const auto& [r, c] : kMapCovarianceOrder) {
      b.cov(r, c) = b.cov(c, r) = get<double>();
    }
    b.kappa = get<double>();
    return b;
  }
  void require(bool condition) { good_ = good_ && condition; }
  bool good() const { return good_; }
  bool atEnd() const { return rest_.empty(); }

 private:
  std::string_view rest_;
  bool good_ = true;
};

/// No node is smaller.
inline constexpr std::size_t kLeastNodeBytes = 8 + 3 + 12 + 80 + 96 + 24;
/// A node as version `version` of the file has it. A reader that is not good() afterwards has given nothing of use.
void putNode(ByteWriter& w, const MapNode& node, std::uint32_t version);
MapNode getNode(ByteReader& r, std::uint32_t version);

/// A between constraint, its deviations within the limits of the file; those of what is read are required to be, and a
/// and b to be two and not negative.
void putConstraint(ByteWriter& w, const BetweenConstraint& e);
BetweenConstraint getConstraint(ByteReader& r, std::uint32_t version);

/// What a node needs of the versions of the file: colour or front, and what was seen through it.
bool hasLooks(const MapNode& node);
bool hasFreeSpace(const MapNode& node);

}  // namespace hgg
