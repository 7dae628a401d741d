#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <functional>
#include <memory>
#include <string>

#include "map/file.h"
#include "map/file_layout.h"

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
  void put(T value) {
    static_assert(std::is_arithmetic_v<T>);
    if constexpr (std::is_floating_point_v<T>) {
      finite_ = finite_ && std::isfinite(value);
    }
    append(std::string_view(reinterpret_cast<const char*>(&value), sizeof(T)));
  }
  void put(std::string_view text) { append(text); }
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
  void finish() {
    if (!payload_.empty()) {
      flush(payload_.size());
    }
  }

  std::uint32_t version() const { return version_; }
  /// False when a number was not finite: the reader would refuse the file.
  bool finite() const { return finite_; }
  /// False when some of it could not be compressed (no memory).
  bool packed() const { return packed_; }

 private:
  void append(std::string_view bytes) {
    payload_.append(bytes);
    while (payload_.size() >= kMapFrameBytes) {
      flush(kMapFrameBytes);
    }
  }
  void flush(std::size_t size) {
    frame_.resize(ZSTD_compressBound(size));
    const std::size_t packed = ZSTD_compress2(context_.get(), frame_.data(), frame_.size(), payload_.data(), size);
    packed_ = packed_ && ZSTD_isError(packed) == 0;
    stored_ = stored_ && packed_ && output_(std::string_view(frame_).substr(0, packed));
    payload_.erase(0, size);
  }

  Output output_;
  std::uint32_t version_;
  std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context_;
  std::string payload_, frame_;
  bool finite_ = true, packed_ = true, stored_ = true;
};

bool hasLooks(const MapNode& node) { return node.looks.rgb || node.looks.front_object; }

bool hasFreeSpace(const MapNode& node) { return node.classes.seen_through > 0 || node.classes.passed > 0; }

std::uint32_t versionOf(const Map& map) {
  const auto any = [&](auto has) {
    return std::ranges::any_of(map.nodes(), [&](const auto& entry) { return has(entry.second); });
  };
  return any(hasFreeSpace) ? kMapVersion : any(hasLooks) ? kMapVersionWithoutFreeSpace : kMapVersionWithoutLooks;
}

void putLooks(Writer& w, const MapNode& node) {
  const Looks& looks = node.looks;
  w.put(static_cast<std::uint8_t>((looks.rgb ? kHasColour : 0) | (looks.front_object ? kHasFront : 0) |
                                  (hasFreeSpace(node) ? kHasFreeSpace : 0)));
  if (looks.rgb) {
    for (const std::uint8_t v : *looks.rgb) {
      w.put(v);
    }
  }
  if (looks.front_object) {
    for (Eigen::Index i = 0; i < 3; ++i) {
      w.put(static_cast<float>((*looks.front_object)[i]));
    }
  }
  if (hasFreeSpace(node)) {
    w.put(node.classes.seen_through), w.put(node.classes.passed);
  }
}

void putNode(Writer& w, const MapNode& node, std::uint32_t version) {
  w.put(node.id);
  w.put(node.label);
  w.put(static_cast<std::uint8_t>(node.stuff));
  w.put(node.tile.x), w.put(node.tile.y), w.put(node.tile.z);
  w.put(node.belief);
  w.put(node.T_map_object);
  w.put(node.views);
  w.put(node.first_us), w.put(node.last_us);
  w.put(node.anchor);
  w.put(static_cast<std::uint32_t>(leavesOf(node).size()));
  for (const Leaf& leaf : leavesOf(node)) {
    for (const float v : leaf.mean) {
      w.put(v);
    }
    for (const float v : leaf.cov) {
      w.put(v);
    }
    w.put(leaf.kappa);
  }
  w.put(static_cast<std::uint16_t>(node.classes.views.size()));
  for (const auto& [label, views] : node.classes.views) {
    w.put(label), w.put(views);
  }
  if (version > kMapVersionWithoutLooks) {
    putLooks(w, node);
  }
}

void putKeyframes(Writer& w, const KeyframeGraph& keyframes) {
  w.put(static_cast<std::uint64_t>(keyframes.poses().size()));
  for (const TimedPose& k : keyframes.poses()) {
    w.put(k.utime_us);
    w.put(k.T_map_body);
  }
  w.put(static_cast<std::uint64_t>(keyframes.edges().size()));
  for (const BetweenConstraint& e : keyframes.edges()) {
    w.put(e.a), w.put(e.b);
    w.put(e.T_a_b);
    w.put(std::clamp(e.sigma, kSigmaLimits.least, kSigmaLimits.most));
    w.put(std::clamp(e.sigma_turn, kSigmaTurnLimits.least, kSigmaTurnLimits.most));
    w.put(static_cast<std::uint8_t>(e.is_loop));
    w.put(std::clamp(e.expected, kSigmaLimits.least, kSigmaLimits.most));
    w.put(std::clamp(e.expected_turn, kSigmaTurnLimits.least, kSigmaTurnLimits.most));
  }
}

void putMap(Writer& w, const Map& map, const std::vector<Edge>& edges) {
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
  w.put(static_cast<std::uint64_t>(map.nodes().size()));
  for (const auto& [id, node] : map.nodes()) {
    putNode(w, node, w.version());
  }
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
std::string writeDurably(const Map& map, const std::vector<Edge>& edges, const std::string& path) {
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
      versionOf(map));
  putMap(writer, map, edges);
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

std::string encode(const Map& map, const std::vector<Edge>& edges) {
  std::string bytes;
  Writer writer(
      [&](std::string_view more) {
        bytes.append(more);
        return true;
      },
      versionOf(map));
  putMap(writer, map, edges);
  return bytes;
}

/// The edges of the map's graph as they are once it is settled.
std::vector<Edge> settledEdges(const Map& map) {
  if (map.graph().isSettled()) {
    return map.graph().edges();
  }
  ObjectGraph settled = map.graph();
  settled.settle();
  return settled.edges();
}

}  // namespace

std::string encodeMap(const StoredMap& stored) { return encode(stored.map, stored.edges); }

std::string encodeMap(const Map& map) { return encode(map, settledEdges(map)); }

std::string saveMap(const Map& map, const std::string& path) {
  if (!map.isWhole()) {
    return fmt::format("{}: not written: parts of the map are not in memory", path);
  }
  const std::string temporary = fmt::format("{}.{}.tmp", path, ::getpid());
  std::string why = writeDurably(map, settledEdges(map), temporary);
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
