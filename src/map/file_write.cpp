#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>
#include <zstd.h>

#include <cerrno>
#include <cstring>
#include <functional>
#include <memory>
#include <string>

#include "map/file.h"
#include "map/file_layout.h"
#include "map/node_bytes.h"
#include "map/whole_map.h"

namespace hgg {
namespace {

constexpr int kCompressionLevel = 3;

/// Takes the next bytes of the file; false when they cannot be stored.
using Output = std::function<bool(std::string_view)>;

/// Writes the payload in compressed frames as it comes, so that saving a map needs a frame's memory beside the map.
class Writer {
 public:
  Writer(Output output, std::uint32_t version)
      : output_(std::move(output)), version_(version), context_(ZSTD_createCCtx(), ZSTD_freeCCtx) {
    ZSTD_CCtx_setParameter(context_.get(), ZSTD_c_compressionLevel, kCompressionLevel);
    ZSTD_CCtx_setParameter(context_.get(), ZSTD_c_checksumFlag, 1);
    stored_ = output_(kMapMagic) && output_(std::string_view(reinterpret_cast<const char*>(&version), sizeof(version)));
  }

  template <typename T>
  void put(const T& value) {
    bytes_.put(value);
    spill();
  }
  void put(const MapNode& node) {
    putNode(bytes_, node, version_);
    spill();
  }
  void put(const BetweenConstraint& constraint) {
    putConstraint(bytes_, constraint);
    spill();
  }
  void finish() {
    if (!bytes_.bytes().empty()) {
      flush(bytes_.bytes().size());
    }
  }

  /// False when a number was not finite: the reader would refuse the file.
  bool finite() const { return bytes_.finite(); }
  /// False when some of it could not be compressed (no memory).
  bool packed() const { return packed_; }

 private:
  void spill() {
    while (bytes_.bytes().size() >= kMapFrameBytes) {
      flush(kMapFrameBytes);
    }
  }
  void flush(std::size_t size) {
    frame_.resize(ZSTD_compressBound(size));
    const std::size_t packed =
        ZSTD_compress2(context_.get(), frame_.data(), frame_.size(), bytes_.bytes().data(), size);
    packed_ = packed_ && ZSTD_isError(packed) == 0;
    stored_ = stored_ && packed_ && output_(std::string_view(frame_).substr(0, packed));
    bytes_.drop(size);
  }

  Output output_;
  std::uint32_t version_;
  std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context_;
  ByteWriter bytes_;  // of the payload, not written yet
  std::string frame_;
  bool packed_ = true, stored_ = true;
};

/// The oldest version that holds it all.
std::uint32_t versionFor(bool has_looks, bool has_free_space) {
  return has_free_space ? kMapVersion : has_looks ? kMapVersionWithoutFreeSpace : kMapVersionWithoutLooks;
}

void putKeyframes(Writer& w, const KeyframeGraph& keyframes) {
  w.put(static_cast<std::uint64_t>(keyframes.poses().size()));
  for (const TimedPose& k : keyframes.poses()) {
    w.put(k.utime_us);
    w.put(k.T_map_body);
  }
  w.put(static_cast<std::uint64_t>(keyframes.edges().size()));
  for (const BetweenConstraint& e : keyframes.edges()) {
    w.put(e);
  }
}

void putMap(Writer& w, const Map& map, WholeMap& whole, const std::vector<Edge>& edges) {
  w.put(static_cast<std::uint32_t>(map.classNames().size()));
  for (const auto& [id, name] : map.classNames()) {
    w.put(id);
    w.put(static_cast<std::uint16_t>(name.size()));
    w.put(std::string_view(name));
  }
  w.put(map.tileSize());
  w.put(map.odometryDelay_us());
  w.put(map.revision());
  w.put(map.nextId());
  putKeyframes(w, map.keyframes());
  w.put(static_cast<std::uint64_t>(whole.size()));
  whole.forEach([&](const MapNode& node) { w.put(node); });
  w.put(static_cast<std::uint64_t>(edges.size()));
  for (const Edge& e : edges) {
    w.put(e.a), w.put(e.b), w.put(e.weight);
  }
  w.put(kMapEnd);
  w.finish();
}

/// Writes all of `bytes` to a file; false when that fails, the reason being in errno.
bool writeAll(int fd, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd, bytes.data(), bytes.size());
    if (n < 0 && errno != EINTR) {
      return false;
    }
    bytes.remove_prefix(n > 0 ? static_cast<std::size_t>(n) : 0);
  }
  return true;
}

/// Writes and syncs the map; empty when done, else the reason.
std::string writeDurably(const Map& map, WholeMap& whole, const std::string& path) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (fd < 0) {
    return std::strerror(errno);
  }
  std::string why;
  Writer writer(
      [&](std::string_view bytes) {
        if (why.empty() && !writeAll(fd, bytes)) {
          why = std::strerror(errno);
        }
        return why.empty();
      },
      versionFor(whole.hasLooks(), whole.hasFreeSpace()));
  putMap(writer, map, whole, whole.edges());
  if (why.empty() && !whole.error().empty()) {
    why = whole.error();
  }
  if (why.empty() && !writer.packed()) {
    why = "it cannot be compressed (is there memory left?)";
  }
  if (why.empty() && !writer.finite()) {
    why = "it holds numbers that are not finite";
  }
  if (why.empty() && ::fsync(fd) != 0) {
    why = std::strerror(errno);
  }
  return ::close(fd) == 0 || !why.empty() ? why : std::strerror(errno);
}

std::string encode(const Map& map, const std::vector<Edge>* edges) {
  std::string bytes;
  const PageReader none;
  WholeMap whole(map, none);
  Writer writer(
      [&](std::string_view more) {
        bytes.append(more);
        return true;
      },
      versionFor(whole.hasLooks(), whole.hasFreeSpace()));
  putMap(writer, map, whole, edges == nullptr ? whole.edges() : *edges);
  return bytes;
}

}  // namespace

std::string encodeMap(const StoredMap& stored) { return encode(stored.map, &stored.edges); }

std::string encodeMap(const Map& map) { return encode(map, nullptr); }

std::string saveMap(const Map& map, const std::string& path, const PageReader& pages) {
  WholeMap whole(map, pages);
  if (!whole.error().empty()) {
    return fmt::format("{}: not written: {}", path, whole.error());
  }
  const std::string temporary = fmt::format("{}.{}.tmp", path, ::getpid());
  std::string why = writeDurably(map, whole, temporary);
  if (why.empty() && std::rename(temporary.c_str(), path.c_str()) != 0) {
    why = std::strerror(errno);
  }
  if (!why.empty()) {
    ::unlink(temporary.c_str());
    return fmt::format("{}: cannot write the map: {}", path, why);
  }
  return {};
}

}  // namespace hgg
