#include "bus/wire.h"

#include <algorithm>

namespace hgg {

static_assert(std::endian::native == std::endian::little, "arrays are read and written as they lie in the message");

std::string_view WireReader::string(const char* what_is_wrong, std::int32_t most) {
  const auto size = integer<std::int32_t>();
  check(size >= 1 && size <= most, what_is_wrong);
  const auto bytes = failed() ? Bytes{} : block(static_cast<std::size_t>(size));
  check(!bytes.empty() && bytes.back() == 0, what_is_wrong);
  return failed() ? std::string_view{}
                  : std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size() - 1);
}

Bytes WireReader::block(std::size_t size) {
  check(size <= rest_.size(), "truncated");
  if (failed()) {
    return {};
  }
  const auto bytes = rest_.first(size);
  rest_ = rest_.subspan(size);
  return bytes;
}

Bytes WireReader::blob() {
  const auto size = integer<std::int32_t>();
  check(size >= 0, "a length is negative");
  return failed() ? Bytes{} : block(static_cast<std::size_t>(size));
}

Micros WireReader::utime() {
  const auto utime_us = integer<Micros>();
  check(utime_us >= 0 && utime_us <= kMaxUtime_us, "time out of bounds");
  return utime_us;
}

void checkImageSize(WireReader& in, std::int32_t width, std::int32_t height) {
  in.check(width >= 0 && width <= kMaxPixels && height >= 0 && height <= kMaxPixels &&
               std::int64_t{width} * height <= kMaxPixels,
           "width * height out of bounds");
}

void store(const Vec3& v, double* out) { std::copy_n(v.data(), 3, out); }

}  // namespace hgg
