#include <algorithm>
#include <bot_core/image_t.hpp>
#include <cmath>
#include <iterator>

#include "bus/codec.h"
#include "bus/wire.h"

namespace hgg {
namespace {

constexpr std::int32_t kLittleEndianGray16 = 909199180;  // PIXEL_FORMAT_LE_GRAY16 of bot_core: "LG16"
constexpr std::int32_t kFloatGray32 = 842221382;         // PIXEL_FORMAT_FLOAT_GRAY32: "FG32", m
constexpr float kMostMillimetres = 65535;
constexpr std::int32_t kMaxMetadata = 64;

void skipMetadata(WireReader& in) {
  const auto count = in.integer<std::int32_t>();
  in.check(count >= 0 && count <= kMaxMetadata, "nmetadata out of bounds");
  for (std::int32_t i = 0; i < count && !in.failed(); ++i) {
    in.string("bad metadata key");
    in.blob();
  }
}

/// Metres to whole mm; what is not finite, not positive or too far is not measured.
std::uint16_t millimetres(float metres) {
  const float mm = std::round(1000 * metres);
  return mm >= 1 && mm <= kMostMillimetres ? static_cast<std::uint16_t>(mm) : std::uint16_t{0};
}

DepthImage readDepthImage(WireReader& in) {
  DepthImage image;
  in.fingerprint(bot_core::image_t::getHash());
  image.utime_us = in.utime();
  image.width = in.integer<std::int32_t>();
  image.height = in.integer<std::int32_t>();
  checkImageSize(in, image.width, image.height);
  const auto row_stride = in.integer<std::int32_t>();
  const auto format = in.integer<std::int32_t>();
  in.check(format == kLittleEndianGray16 || format == kFloatGray32,
           "pixelformat is neither little-endian 16-bit grey nor 32-bit float");
  const Bytes data = in.blob();
  skipMetadata(in);
  in.end();
  const std::int64_t row_bytes = std::int64_t{image.width} * (format == kFloatGray32 ? 4 : 2);
  in.check(row_stride >= row_bytes && std::int64_t{row_stride} * image.height == std::ssize(data),
           "size is not height * row_stride, or rows are too short");
  if (in.failed()) {
    return image;
  }
  for (std::int32_t y = 0; y < image.height && row_bytes > 0; ++y) {
    const auto row = data.subspan(static_cast<std::size_t>(std::int64_t{y} * row_stride));
    const Bytes pixels = row.first(static_cast<std::size_t>(row_bytes));
    if (format == kFloatGray32) {
      std::ranges::transform(valuesOf<float>(pixels), std::back_inserter(image.depth_mm), millimetres);
    } else {
      const auto values = valuesOf<std::uint16_t>(pixels);
      image.depth_mm.insert(image.depth_mm.end(), values.begin(), values.end());
    }
  }
  return image;
}

}  // namespace

Result<DepthImage> decodeDepthImage(Bytes message) {
  WireReader in(message);
  DepthImage image = readDepthImage(in);
  return in.failed() ? Result<DepthImage>::fail(in.error()) : Result<DepthImage>::ok(std::move(image));
}

std::vector<std::uint8_t> encodeDepthImage(const DepthImage& image) {
  bot_core::image_t message{};
  message.utime = image.utime_us;
  message.width = image.width;
  message.height = image.height;
  message.row_stride = 2 * image.width;
  message.pixelformat = kLittleEndianGray16;
  message.data = bytesOf(image.depth_mm);
  message.size = static_cast<std::int32_t>(message.data.size());
  return encode(message);
}

}  // namespace hgg
