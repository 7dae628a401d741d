#include <fmt/format.h>
#include <zstd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "core/text.h"
#include "core/units.h"
#include "map/file.h"
#include "map/file_layout.h"
#include "map/map_store.h"
#include "map/node_bytes.h"

namespace hgg {
namespace {

/// A small file must not unpack into all memory. Maps shrink to a half or a third; a payload may be this many times its
/// file, and so many bytes in any case. No map is larger than the last of them.
constexpr std::size_t kMostUnpacking = 64, kFreePayload = std::size_t{64} << 20, kMaxPayload = std::size_t{8} << 30;

constexpr std::uint32_t kVersionWithoutDelay = 4;
/// What alignment loses from one keyframe to the next, as correction/between has it for leaves of 0.4 m: 0.3 degrees
/// and 0.14 m in 100 m.
constexpr double kAlignedSigma = 0.02, kAlignedTurn = 0.04 * kDegree;  // m, rad
/// Of a between constraint that nothing is known of.
constexpr double kUnknownSigma = 0.3, kUnknownTurn = 3 * kDegree;  // m, rad

/// Joins each keyframe that nothing connects to the first to the one before it, as they lie now.
void joinLoose(KeyframeGraph& keyframes, double sigma, double sigma_turn) {
  std::vector<bool> is_joined(keyframes.poses().size());
  const auto spread = [&](KeyframeId from) {
    for (std::vector<KeyframeId> open{from}; !open.empty();) {
      const KeyframeId k = open.back();
      open.pop_back();
      if (is_joined[static_cast<std::size_t>(k)]) {
        continue;
      }
      is_joined[static_cast<std::size_t>(k)] = true;
      for (const BetweenConstraint& e : keyframes.edgesOf(k)) {
        open.push_back(e.a == k ? e.b : e.a);
      }
    }
  };
  for (KeyframeId k = 0; k <= keyframes.last(); ++k) {
    const auto b = static_cast<std::size_t>(k);
    if (k > 0 && !is_joined[b]) {
      const Pose T_a_b = keyframes.poses()[b - 1].T_map_body.inverse() * keyframes.poses()[b].T_map_body;
      keyframes.connect({k - 1, k, T_a_b, sigma, sigma_turn, false});
    }
    spread(k);
  }
}

KeyframeGraph getKeyframes(ByteReader& r, std::uint32_t version) {
  KeyframeGraph keyframes;
  for (std::size_t n = r.count(r.get<std::uint64_t>(), 8 + 96); n > 0; --n) {
    const auto utime_us = r.get<Micros>();
    keyframes.add({utime_us, r.pose()});
  }
  if (version <= kVersionWithoutConstraints) {
    joinLoose(keyframes, kAlignedSigma, kAlignedTurn);
    return keyframes;
  }
  for (std::size_t n = r.count(r.get<std::uint64_t>(), 4 + 4 + 96 + 16 + 1); n > 0; --n) {
    const BetweenConstraint e = getConstraint(r, version);
    r.require(e.a <= keyframes.last() && e.b <= keyframes.last());
    if (r.good()) {
      keyframes.connect(e);
    }
  }
  joinLoose(keyframes, kUnknownSigma, kUnknownTurn);
  return keyframes;
}

/// Nodes from before they had anchors hang on the keyframe that was the last when they were first seen.
class AnchorByTime {
 public:
  explicit AnchorByTime(const KeyframeGraph& keyframes) {
    for (const TimedPose& k : keyframes.poses()) {
      first_from_.push_back(k.utime_us);
    }
    for (std::size_t k = first_from_.size(); k > 1; --k) {
      first_from_[k - 2] = std::min(first_from_[k - 2], first_from_[k - 1]);
    }
  }
  /// The last keyframe that is not younger, the first where all are; -1 when there is none.
  KeyframeId operator()(Micros utime_us) const {
    const auto younger = std::ranges::upper_bound(first_from_, utime_us);
    const auto older = static_cast<KeyframeId>(younger - first_from_.begin());
    return first_from_.empty() ? -1 : std::max(older, 1) - 1;
  }

 private:
  std::vector<Micros> first_from_;  // the earliest time from each keyframe on: ascending, as clocks need not be
};

/// nullopt when the payload does not follow the grammar.
std::optional<StoredMap> decodePayload(std::string_view payload, std::uint32_t version) {
  ByteReader r(payload);
  std::map<ClassId, std::string> names;
  for (std::size_t n = r.count(r.get<std::uint32_t>(), 4); n > 0; --n) {
    const auto id = r.get<ClassId>();
    names[id] = std::string(r.take(r.get<std::uint16_t>()));
  }
  const auto tile_size = r.get<double>();
  const Micros odometry_delay_us = version <= kVersionWithoutDelay ? 0 : r.get<Micros>();
  const auto revision = r.get<std::int64_t>();
  const auto next_id = r.get<NodeId>();
  KeyframeGraph keyframes = getKeyframes(r, version);
  const auto keyframe_count = static_cast<KeyframeId>(keyframes.poses().size());
  std::vector<MapNode> nodes(r.count(r.get<std::uint64_t>(), kLeastNodeBytes));
  NodeId last_id = -1;
  const AnchorByTime anchorOf(keyframes);
  for (MapNode& node : nodes) {
    node = getNode(r, version);
    node.anchor = version <= kVersionWithoutConstraints ? anchorOf(node.first_us) : node.anchor;
    r.require(node.id > last_id && node.belief.kappa >= 0 && node.anchor >= -1 && node.anchor < keyframe_count);
    last_id = node.id;
  }
  std::vector<Edge> edges(r.count(r.get<std::uint64_t>(), 20));
  for (Edge& e : edges) {
    e.a = r.get<NodeId>(), e.b = r.get<NodeId>(), e.weight = r.get<float>();
  }
  r.require(std::abs(odometry_delay_us) <= kLongestDelay_us);
  r.require(next_id > last_id && r.take(kMapEnd.size()) == kMapEnd && r.atEnd());
  if (!r.good()) {
    return std::nullopt;
  }
  StoredMap stored{Map::restore(std::move(nodes), std::move(keyframes), std::move(names), revision, next_id),
                   std::move(edges)};
  stored.map.setTileSize(tile_size);
  stored.map.setOdometryDelay(odometry_delay_us);
  for (const Edge& e : stored.edges) {
    if (e.a >= e.b || stored.map.find(e.a) == nullptr || stored.map.find(e.b) == nullptr) {
      return std::nullopt;
    }
  }
  return stored;
}

/// The size of the payload as the frames claim it, so that it is known before anything is allocated.
Result<std::size_t> claimedSize(std::string_view frames) {
  using Size = Result<std::size_t>;
  const std::size_t most = std::min(kMaxPayload, kFreePayload + kMostUnpacking * frames.size());
  std::size_t claimed = 0;
  while (!frames.empty()) {
    const std::size_t packed = ZSTD_findFrameCompressedSize(frames.data(), frames.size());
    if (ZSTD_isError(packed) != 0) {
      return Size::fail("truncated or corrupted (a block is incomplete)");
    }
    const unsigned long long size = ZSTD_getFrameContentSize(frames.data(), packed);
    if (size == 0 || size > kMapFrameBytes) {
      return Size::fail("corrupted (a block has an impossible size)");
    }
    claimed += static_cast<std::size_t>(size);
    if (claimed > most) {
      return Size::fail("corrupted (it claims to hold more than a map of its size can)");
    }
    frames.remove_prefix(packed);
  }
  return Size::ok(claimed);
}

Result<std::string> decompress(std::string_view frames) {
  const Result<std::size_t> claimed = claimedSize(frames);
  if (!claimed) {
    return Result<std::string>::fail(claimed.error);
  }
  std::string payload(*claimed, '\0');
  for (std::size_t at = 0; !frames.empty();) {
    const std::size_t packed = ZSTD_findFrameCompressedSize(frames.data(), frames.size());
    const auto size = static_cast<std::size_t>(ZSTD_getFrameContentSize(frames.data(), packed));
    if (ZSTD_decompress(payload.data() + at, size, frames.data(), packed) != size) {
      return Result<std::string>::fail("corrupted (a block fails its checksum)");
    }
    at += size;
    frames.remove_prefix(packed);
  }
  return Result<std::string>::ok(std::move(payload));
}

}  // namespace

Result<StoredMap> decodeMap(std::string_view bytes) {
  const std::size_t header_bytes = kMapMagic.size() + sizeof(kMapVersion);
  if (bytes.size() < header_bytes || bytes.substr(0, kMapMagic.size()) != kMapMagic) {
    return Result<StoredMap>::fail("not an hggmap map");
  }
  std::uint32_t version = 0;
  std::memcpy(&version, bytes.data() + kMapMagic.size(), sizeof(version));
  if (version < kVersionWithoutClasses || version > kMapVersion) {
    return Result<StoredMap>::fail(fmt::format("map format version {}, this hggmap reads versions {} to {}", version,
                                               kVersionWithoutClasses, kMapVersion));
  }
  const Result<std::string> payload = decompress(bytes.substr(header_bytes));
  if (!payload) {
    return Result<StoredMap>::fail(payload.error);
  }
  std::optional<StoredMap> stored = decodePayload(*payload, version);
  return stored ? Result<StoredMap>::ok(std::move(*stored))
                : Result<StoredMap>::fail("truncated or corrupted (its contents do not follow the format)");
}

Result<StoredMap> loadMap(const std::string& path) {
  const auto fail = [&](const std::string& why) { return Result<StoredMap>::fail(fmt::format("{}: {}", path, why)); };
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    return fail("no such map file");
  }
  if (isMapStore(path)) {
    Result<Map> map = loadMapStore(path);
    if (!map) {
      return Result<StoredMap>::fail(map.error);
    }
    std::vector<Edge> edges = map->graph().edges();
    return Result<StoredMap>::ok({std::move(*map), std::move(edges)});
  }
  const std::optional<std::string> bytes = readFile(path);
  if (!bytes) {
    return fail("cannot read the file");
  }
  Result<StoredMap> stored = decodeMap(*bytes);
  return stored ? std::move(stored) : fail(stored.error);
}

}  // namespace hgg
