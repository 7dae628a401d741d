#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <vector>

#include "bus/codec.h"
#include "core/types.h"

namespace hgg {

// What the codecs of all messages share. Only bus/codec_*.cpp include this.

/// On the wire, of ids and amounts that may be 0: there is none, or it is not known.
inline constexpr int kNone = -1;

/// Walks a message. The first failure sticks: what is read after it is zero, and `error` says what was wrong.
/// LCM's generated decode is not used on bytes from outside: it trusts lengths, throws on negative ones and allocates
/// absurd ones.
class WireReader {
 public:
  explicit WireReader(Bytes message) : rest_(message) {}

  template <typename T>
  T integer() {
    std::uint64_t value = 0;
    for (const std::uint8_t byte : block(sizeof(T))) {
      value = value << 8 | byte;
    }
    return static_cast<T>(value);
  }
  double real() { return std::bit_cast<double>(integer<std::uint64_t>()); }
  bool boolean() { return integer<std::uint8_t>() != 0; }
  /// At most `most` bytes, its terminating zero included; lies in the message.
  std::string_view string(const char* what_is_wrong, std::int32_t most = kMaxStringBytes);
  /// The next `size` bytes, which lie in the message.
  Bytes block(std::size_t size);
  /// A length (i32), then as many bytes.
  Bytes blob();

  void fingerprint(std::int64_t expected) { check(integer<std::int64_t>() == expected, "foreign fingerprint"); }
  /// 0 .. kMaxUtime_us.
  Micros utime();
  void end() { check(rest_.empty(), "surplus bytes"); }

  void check(bool fine, const char* what_is_wrong) {
    if (!fine && !error_) {
      error_ = what_is_wrong;
    }
  }
  bool failed() const { return error_ != nullptr; }
  const char* error() const { return error_; }

 private:
  Bytes rest_;
  const char* error_ = nullptr;
};

/// Fails where an image of this size, in pixels, is not credible.
void checkImageSize(WireReader& in, std::int32_t width, std::int32_t height);

/// Little-endian values as they lie in a message; a part of a value at the end is left out.
template <typename T>
std::vector<T> valuesOf(Bytes bytes) {
  std::vector<T> values(bytes.size() / sizeof(T));
  if (!values.empty()) {
    std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  }
  return values;
}

/// The reverse of valuesOf.
template <typename T>
std::vector<std::uint8_t> bytesOf(const std::vector<T>& values) {
  std::vector<std::uint8_t> bytes(values.size() * sizeof(T));
  if (!bytes.empty()) {
    std::memcpy(bytes.data(), values.data(), bytes.size());
  }
  return bytes;
}

/// A message of LCM's generated types as it goes over the wire.
template <typename Message>
std::vector<std::uint8_t> encode(const Message& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

/// Writes a vector into a message's array of three.
void store(const Vec3& v, double* out);

}  // namespace hgg
