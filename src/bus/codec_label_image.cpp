#include <zstd.h>

#include <hgg/label_image_t.hpp>
#include <limits>

#include "bus/codec.h"
#include "bus/wire.h"

namespace hgg {
namespace {

constexpr int kZstdLevel = 1;

template <typename T>
std::vector<T> unpack(WireReader& in, Bytes packed, std::size_t count) {
  std::vector<T> values;
  const std::size_t bytes = count * sizeof(T);
  const auto declared = ZSTD_getFrameContentSize(packed.data(), packed.size());
  in.check(declared == bytes, "a plane does not have a value for every pixel");
  if (in.failed()) {
    return values;
  }
  values.resize(count);
  const auto written = ZSTD_decompress(values.data(), bytes, packed.data(), packed.size());
  in.check(!ZSTD_isError(written) && written == bytes, "a plane is not a zstd frame");
  return values;
}

/// A value for each of `count` pixels; none where the plane is empty.
template <typename T>
std::vector<T> readPlane(WireReader& in, std::int8_t compression, std::size_t count) {
  const Bytes bytes = in.blob();
  if (in.failed() || bytes.empty()) {
    return {};
  }
  if (compression == hgg::label_image_t::ZSTD) {
    return unpack<T>(in, bytes, count);
  }
  in.check(bytes.size() == count * sizeof(T), "a plane does not have a value for every pixel");
  return in.failed() ? std::vector<T>{} : valuesOf<T>(bytes);
}

std::vector<InstanceEmbedding> readEmbeddings(WireReader& in) {
  const auto count = in.integer<std::int32_t>(), size = in.integer<std::int32_t>();
  in.check(count >= 0 && count <= kMaxEmbeddings && size >= 0 && size <= kMaxEmbeddingSize, "embeddings out of bounds");
  std::vector<InstanceEmbedding> embeddings;
  for (std::int32_t i = 0; i < count && !in.failed(); ++i) {
    const auto instance = in.integer<std::int64_t>();
    in.check(instance >= 0 && instance <= std::numeric_limits<std::uint32_t>::max(), "instance out of bounds");
    embeddings.push_back({static_cast<std::uint32_t>(instance), {}});
  }
  const Bytes values = in.blob();
  const auto each = static_cast<std::size_t>(size) * sizeof(float);
  in.check(values.size() == embeddings.size() * each, "embeddings_nbytes is not num_embeddings * embedding_size * 4");
  if (in.failed()) {
    return {};
  }
  for (std::size_t i = 0; i < embeddings.size(); ++i) {
    embeddings[i].values = valuesOf<float>(values.subspan(i * each, each));
  }
  return embeddings;
}

LabelImage readLabelImage(WireReader& in) {
  LabelImage image;
  in.fingerprint(hgg::label_image_t::getHash());
  image.utime_us = in.utime();
  image.width = in.integer<std::int32_t>();
  image.height = in.integer<std::int32_t>();
  checkImageSize(in, image.width, image.height);
  const auto compression = in.integer<std::int8_t>();
  in.check(compression == hgg::label_image_t::RAW || compression == hgg::label_image_t::ZSTD, "unknown compression");
  const std::size_t pixels =
      in.failed() ? 0 : static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  image.labels = readPlane<ClassId>(in, compression, pixels);
  in.check(image.labels.size() == pixels, "labels are missing");
  image.instances = readPlane<std::uint32_t>(in, compression, pixels);
  image.confidence = readPlane<std::uint8_t>(in, compression, pixels);
  image.embeddings = readEmbeddings(in);
  in.end();
  return image;
}

template <typename T>
std::vector<std::uint8_t> packPlane(const std::vector<T>& values, Packing packing) {
  if (values.empty() || packing == Packing::kRaw) {
    return bytesOf(values);
  }
  const std::size_t size = values.size() * sizeof(T);
  std::vector<std::uint8_t> bytes(ZSTD_compressBound(size));
  bytes.resize(ZSTD_compress(bytes.data(), bytes.size(), values.data(), size, kZstdLevel));
  return bytes;
}

}  // namespace

Result<LabelImage> decodeLabelImage(Bytes message) {
  WireReader in(message);
  LabelImage image = readLabelImage(in);
  return in.failed() ? Result<LabelImage>::fail(in.error()) : Result<LabelImage>::ok(std::move(image));
}

std::vector<std::uint8_t> encodeLabelImage(const LabelImage& image, Packing packing) {
  hgg::label_image_t message{};
  message.utime = image.utime_us;
  message.width = image.width;
  message.height = image.height;
  message.compression = packing == Packing::kZstd ? hgg::label_image_t::ZSTD : hgg::label_image_t::RAW;
  message.labels = packPlane(image.labels, packing);
  message.labels_nbytes = static_cast<std::int32_t>(message.labels.size());
  message.instances = packPlane(image.instances, packing);
  message.instances_nbytes = static_cast<std::int32_t>(message.instances.size());
  message.confidence = packPlane(image.confidence, packing);
  message.confidence_nbytes = static_cast<std::int32_t>(message.confidence.size());
  message.num_embeddings = static_cast<std::int32_t>(image.embeddings.size());
  message.embedding_size =
      image.embeddings.empty() ? 0 : static_cast<std::int32_t>(image.embeddings.front().values.size());
  for (const InstanceEmbedding& embedding : image.embeddings) {
    message.embedding_instances.push_back(embedding.instance);
    const auto bytes = bytesOf(embedding.values);
    message.embeddings.insert(message.embeddings.end(), bytes.begin(), bytes.end());
  }
  message.embeddings_nbytes = static_cast<std::int32_t>(message.embeddings.size());
  return encode(message);
}

}  // namespace hgg
