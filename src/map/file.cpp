#include "map/file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <span>

#include "core/text.h"
#include "core/units.h"

namespace hgg {
namespace {

static_assert(std::endian::native == std::endian::little, "the file is written as it lies in memory");

constexpr std::string_view kMagic = "HGGMAP\r\n";
constexpr std::string_view kEnd = "END.";
constexpr std::uint32_t kVersion = 3, kVersionWithoutTies = 2, kVersionWithoutClasses = 1;
constexpr std::size_t kFrameBytes = 4U << 20;
constexpr std::size_t kMaxPayload = std::size_t{8} << 30;  // a small file must not unpack into all memory
constexpr int kCompressionLevel = 3;

/// What a tie may leave open: beyond these limits its information is no number that a solver can use.
struct Limits {
  double least = 0, most = 0;
};
constexpr Limits kSigma{1e-6, 1e3}, kSigmaTurn{1e-7, 1e3};  // m, rad
/// What alignment loses from one keyframe to the next: 0.3 degrees and 0.35 m in 100 m, as on real drives.
constexpr double kAlignedSigma = 0.02, kAlignedTurn = 0.04 * kDegree;  // m, rad
/// Of a tie that nothing is known of.
constexpr double kUnknownSigma = 0.3, kUnknownTurn = 3 * kDegree;  // m, rad

class Writer {
 public:
  template <typename T>
  void put(T value) {
    static_assert(std::is_arithmetic_v<T>);
    if constexpr (std::is_floating_point_v<T>) {
      finite_ = finite_ && std::isfinite(value);
    }
    const auto* bytes = reinterpret_cast<const char*>(&value);
    out_.append(bytes, sizeof(T));
  }
  void put(std::string_view text) { out_.append(text); }
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
    for (const auto& [r, c] : kCovarianceOrder) {
      put(b.cov(r, c));
    }
    put(b.kappa);
  }
  const std::string& bytes() const { return out_; }
  /// False when a number was not finite: the reader would refuse the file.
  bool finite() const { return finite_; }

  static constexpr std::pair<Eigen::Index, Eigen::Index> kCovarianceOrder[] = {{0, 0}, {1, 1}, {2, 2},
                                                                               {0, 1}, {0, 2}, {1, 2}};

 private:
  std::string out_;
  bool finite_ = true;
};

/// Bounds-checked reader: after the first short or invalid item everything reads as zero and good() is false.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : rest_(bytes) {}
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
    for (const auto& [r, c] : Writer::kCovarianceOrder) {
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

void putNode(Writer& w, const MapNode& node) {
  w.put(node.id);
  w.put(node.label);
  w.put(static_cast<std::uint8_t>(node.stuff));
  w.put(node.tile.x), w.put(node.tile.y), w.put(node.tile.z);
  w.put(node.belief);
  w.put(node.T_map_object);
  w.put(node.views);
  w.put(node.first_us), w.put(node.last_us);
  w.put(node.anchor);
  w.put(static_cast<std::uint32_t>(node.leaves.size()));
  for (const Leaf& leaf : node.leaves) {
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
}

ClassBelief getClasses(Reader& r) {
  ClassBelief classes;
  classes.views.resize(r.count(r.get<std::uint16_t>(), 6));
  int last = -1;
  for (auto& [label, views] : classes.views) {
    label = r.get<ClassId>(), views = r.get<float>();
    r.require(label > last && views >= 0 && views <= 1e4F);
    last = label;
  }
  return classes;
}

MapNode getNode(Reader& r, std::uint32_t version) {
  MapNode node;
  node.id = r.get<NodeId>();
  node.label = r.get<ClassId>();
  node.stuff = r.get<std::uint8_t>() != 0;
  node.tile.x = r.get<std::int32_t>(), node.tile.y = r.get<std::int32_t>(), node.tile.z = r.get<std::int32_t>();
  node.belief = r.belief();
  node.T_map_object = r.pose();
  node.views = r.get<std::int32_t>();
  node.first_us = r.get<Micros>(), node.last_us = r.get<Micros>();
  node.anchor = version > kVersionWithoutTies ? r.get<KeyframeId>() : -1;
  node.leaves.resize(r.count(r.get<std::uint32_t>(), sizeof(Leaf)));
  for (Leaf& leaf : node.leaves) {
    for (float& v : leaf.mean) {
      v = r.get<float>();
    }
    for (float& v : leaf.cov) {
      v = r.get<float>();
    }
    leaf.kappa = r.get<float>();
  }
  if (version != kVersionWithoutClasses) {
    node.classes = getClasses(r);
  } else if (!node.stuff) {
    addViews(node.classes, {{node.label, static_cast<float>(std::max(node.views, 0))}});
  }
  return node;
}

Writer encodePayload(const Map& map, const std::vector<Edge>& edges) {
  Writer w;
  w.put(static_cast<std::uint32_t>(map.classNames().size()));
  for (const auto& [id, name] : map.classNames()) {
    w.put(id);
    w.put(static_cast<std::uint16_t>(name.size()));
    w.put(std::string_view(name));
  }
  w.put(map.tileSize());
  w.put(map.revision());
  w.put(map.nextId());
  w.put(static_cast<std::uint64_t>(map.keyframes().poses().size()));
  for (const TimedPose& k : map.keyframes().poses()) {
    w.put(k.utime_us);
    w.put(k.T_map_body);
  }
  w.put(static_cast<std::uint64_t>(map.keyframes().edges().size()));
  for (const BetweenConstraint& e : map.keyframes().edges()) {
    w.put(e.a), w.put(e.b);
    w.put(e.T_a_b);
    w.put(std::clamp(e.sigma, kSigma.least, kSigma.most));
    w.put(std::clamp(e.sigma_turn, kSigmaTurn.least, kSigmaTurn.most));
    w.put(static_cast<std::uint8_t>(e.is_loop));
  }
  w.put(static_cast<std::uint64_t>(map.nodes().size()));
  for (const auto& [id, node] : map.nodes()) {
    putNode(w, node);
  }
  w.put(static_cast<std::uint64_t>(edges.size()));
  for (const Edge& e : edges) {
    w.put(e.a), w.put(e.b), w.put(e.weight);
  }
  w.put(kEnd);
  return w;
}

bool isWithin(double sigma, const Limits& limits) { return sigma >= limits.least && sigma <= limits.most; }

/// Ties each keyframe that nothing connects to the first to the one before it, as they lie.
void tieLoose(KeyframeGraph& keyframes, double sigma, double sigma_turn) {
  std::vector<bool> is_tied(keyframes.poses().size());
  const auto spread = [&](KeyframeId from) {
    for (std::vector<KeyframeId> open{from}; !open.empty();) {
      const KeyframeId k = open.back();
      open.pop_back();
      if (is_tied[static_cast<std::size_t>(k)]) {
        continue;
      }
      is_tied[static_cast<std::size_t>(k)] = true;
      for (const BetweenConstraint& e : keyframes.edgesOf(k)) {
        open.push_back(e.a == k ? e.b : e.a);
      }
    }
  };
  for (KeyframeId k = 0; k <= keyframes.last(); ++k) {
    const auto b = static_cast<std::size_t>(k);
    if (k > 0 && !is_tied[b]) {
      const Pose T_a_b = keyframes.poses()[b - 1].T_map_body.inverse() * keyframes.poses()[b].T_map_body;
      keyframes.connect({k - 1, k, T_a_b, sigma, sigma_turn, false});
    }
    spread(k);
  }
}

KeyframeGraph getKeyframes(Reader& r, std::uint32_t version) {
  KeyframeGraph keyframes;
  for (std::size_t n = r.count(r.get<std::uint64_t>(), 8 + 96); n > 0; --n) {
    const auto utime_us = r.get<Micros>();
    keyframes.add({utime_us, r.pose()});
  }
  if (version <= kVersionWithoutTies) {
    tieLoose(keyframes, kAlignedSigma, kAlignedTurn);
    return keyframes;
  }
  for (std::size_t n = r.count(r.get<std::uint64_t>(), 4 + 4 + 96 + 16 + 1); n > 0; --n) {
    BetweenConstraint e;
    e.a = r.get<KeyframeId>(), e.b = r.get<KeyframeId>();
    e.T_a_b = r.pose();
    e.sigma = r.get<double>(), e.sigma_turn = r.get<double>();
    e.is_loop = r.get<std::uint8_t>() != 0;
    r.require(e.a >= 0 && e.b >= 0 && e.a != e.b && e.a <= keyframes.last() && e.b <= keyframes.last() &&
              isWithin(e.sigma, kSigma) && isWithin(e.sigma_turn, kSigmaTurn));
    if (r.good()) {
      keyframes.connect(e);
    }
  }
  tieLoose(keyframes, kUnknownSigma, kUnknownTurn);
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
  Reader r(payload);
  std::map<ClassId, std::string> names;
  for (std::size_t n = r.count(r.get<std::uint32_t>(), 4); n > 0; --n) {
    const auto id = r.get<ClassId>();
    names[id] = std::string(r.take(r.get<std::uint16_t>()));
  }
  const auto tile_size = r.get<double>();
  const auto revision = r.get<std::int64_t>();
  const auto next_id = r.get<NodeId>();
  KeyframeGraph keyframes = getKeyframes(r, version);
  const auto keyframe_count = static_cast<KeyframeId>(keyframes.poses().size());
  std::vector<MapNode> nodes(r.count(r.get<std::uint64_t>(), 8 + 3 + 12 + 80 + 96 + 24));
  NodeId last_id = 0;
  const AnchorByTime anchorOf(keyframes);
  for (MapNode& node : nodes) {
    node = getNode(r, version);
    node.anchor = version <= kVersionWithoutTies ? anchorOf(node.first_us) : node.anchor;
    r.require(node.id > last_id && node.belief.kappa >= 0 && node.anchor >= -1 && node.anchor < keyframe_count);
    last_id = node.id;
  }
  std::vector<Edge> edges(r.count(r.get<std::uint64_t>(), 20));
  for (Edge& e : edges) {
    e.a = r.get<NodeId>(), e.b = r.get<NodeId>(), e.weight = r.get<float>();
  }
  r.require(next_id > last_id && r.take(kEnd.size()) == kEnd && r.atEnd());
  if (!r.good()) {
    return std::nullopt;
  }
  StoredMap stored{Map::restore(std::move(nodes), std::move(keyframes), std::move(names), revision, next_id),
                   std::move(edges)};
  stored.map.setTileSize(tile_size);
  for (const Edge& e : stored.edges) {
    if (e.a >= e.b || stored.map.find(e.a) == nullptr || stored.map.find(e.b) == nullptr) {
      return std::nullopt;
    }
  }
  return stored;
}

std::string compress(std::string_view payload) {
  std::string out;
  ZSTD_CCtx* context = ZSTD_createCCtx();
  ZSTD_CCtx_setParameter(context, ZSTD_c_compressionLevel, kCompressionLevel);
  ZSTD_CCtx_setParameter(context, ZSTD_c_checksumFlag, 1);
  for (std::size_t at = 0; at < payload.size(); at += kFrameBytes) {
    const std::string_view part = payload.substr(at, kFrameBytes);
    std::string frame(ZSTD_compressBound(part.size()), '\0');
    frame.resize(ZSTD_compress2(context, frame.data(), frame.size(), part.data(), part.size()));
    out += frame;
  }
  ZSTD_freeCCtx(context);
  return out;
}

Result<std::string> decompress(std::string_view frames) {
  std::string payload;
  while (!frames.empty()) {
    const std::size_t packed = ZSTD_findFrameCompressedSize(frames.data(), frames.size());
    if (ZSTD_isError(packed) != 0) {
      return Result<std::string>::fail("truncated or corrupted (a block is incomplete)");
    }
    const unsigned long long size = ZSTD_getFrameContentSize(frames.data(), packed);
    if (size == 0 || size > kFrameBytes || payload.size() > kMaxPayload) {
      return Result<std::string>::fail("corrupted (a block has an impossible size)");
    }
    const std::size_t at = payload.size();
    payload.resize(at + static_cast<std::size_t>(size));
    if (ZSTD_decompress(payload.data() + at, static_cast<std::size_t>(size), frames.data(), packed) != size) {
      return Result<std::string>::fail("corrupted (a block fails its checksum)");
    }
    frames.remove_prefix(packed);
  }
  return Result<std::string>::ok(std::move(payload));
}

std::string pack(std::string_view payload) {
  Writer header;
  header.put(kMagic);
  header.put(kVersion);
  return header.bytes() + compress(payload);
}

/// Writes and syncs `bytes`; empty when done, else the reason.
std::string writeDurably(const std::string& path, std::string_view bytes) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (fd < 0) {
    return std::strerror(errno);
  }
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd, bytes.data(), bytes.size());
    if (n < 0 && errno != EINTR) {
      std::string why = std::strerror(errno);
      ::close(fd);
      return why;
    }
    bytes.remove_prefix(n > 0 ? static_cast<std::size_t>(n) : 0);
  }
  const bool synced = ::fsync(fd) == 0;
  return ::close(fd) == 0 && synced ? "" : std::strerror(errno);
}

std::vector<Edge> settledEdges(const Map& map) {
  if (map.graph().isSettled()) {
    return map.graph().edges();
  }
  ObjectGraph settled = map.graph();
  settled.settle();
  return settled.edges();
}

}  // namespace

std::string encodeMap(const Map& map) { return pack(encodePayload(map, settledEdges(map)).bytes()); }

std::string encodeMap(const StoredMap& stored) { return pack(encodePayload(stored.map, stored.edges).bytes()); }

Result<StoredMap> decodeMap(std::string_view bytes) {
  const std::size_t header_bytes = kMagic.size() + sizeof(kVersion);
  if (bytes.size() < header_bytes || bytes.substr(0, kMagic.size()) != kMagic) {
    return Result<StoredMap>::fail("not an hggmap map");
  }
  std::uint32_t version = 0;
  std::memcpy(&version, bytes.data() + kMagic.size(), sizeof(version));
  if (version < kVersionWithoutClasses || version > kVersion) {
    return Result<StoredMap>::fail(fmt::format("map format version {}, this hggmap reads versions {} to {}", version,
                                               kVersionWithoutClasses, kVersion));
  }
  const Result<std::string> payload = decompress(bytes.substr(header_bytes));
  if (!payload) {
    return Result<StoredMap>::fail(payload.error);
  }
  std::optional<StoredMap> stored = decodePayload(*payload, version);
  return stored ? Result<StoredMap>::ok(std::move(*stored))
                : Result<StoredMap>::fail("truncated or corrupted (its contents do not follow the format)");
}

std::string saveMap(const Map& map, const std::string& path) {
  const Writer payload = encodePayload(map, settledEdges(map));
  if (!payload.finite()) {
    return fmt::format("{}: the map holds numbers that are not finite; it is not written", path);
  }
  const std::string temporary = fmt::format("{}.{}.tmp", path, ::getpid());
  std::string why = writeDurably(temporary, pack(payload.bytes()));
  if (why.empty() && std::rename(temporary.c_str(), path.c_str()) != 0) {
    why = std::strerror(errno);
  }
  if (!why.empty()) {
    ::unlink(temporary.c_str());
    return fmt::format("{}: cannot write the map: {}", path, why);
  }
  return {};
}

Result<StoredMap> loadMap(const std::string& path) {
  const auto fail = [&](const std::string& why) { return Result<StoredMap>::fail(fmt::format("{}: {}", path, why)); };
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    return fail("no such map file");
  }
  const std::optional<std::string> bytes = readFile(path);
  if (!bytes) {
    return fail("cannot read the file");
  }
  Result<StoredMap> stored = decodeMap(*bytes);
  return stored ? std::move(stored) : fail(stored.error);
}

}  // namespace hgg
