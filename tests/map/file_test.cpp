#include "map/file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <zstd.h>

#include <algorithm>
#include <csignal>
#include <cstring>

#include "map/test_map.h"
#include "tools/scratch.h"

namespace hgg::file_test {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kHeaderBytes = 12;  // magic and version
constexpr std::size_t kTieBytes = 4 + 4 + 96 + 16 + 1 + 16;

Pose at(double x) {
  Pose T = Pose::Identity();
  T.translation().x() = x;
  return T;
}

/// The constraint of what is to be the next keyframe of a map to the one before it.
std::vector<BetweenConstraint> constraintsOfNext(const Map& map) {
  const KeyframeId last = map.keyframes().last();
  return last < 0 ? std::vector<BetweenConstraint>()
                  : std::vector<BetweenConstraint>{{last, -1, at(2), 0.02, 0.001, false}};
}

/// A map with things, stuff, removed nodes, keyframes and class names.
Map sampleMap(unsigned seed, int nodes) {
  std::mt19937 random(seed);
  Map map;
  map.setClassNames({{10, "car"}, {40, "road"}, {65535, "\xc3\xa9toile"}});
  for (int k = 0; k < nodes; ++k) {
    MapUpdate update;
    update.keyframe = keyframeIfNeeded(map, {1000 * k, randomPose(random, 20)}, constraintsOfNext(map));
    update.created.push_back(k % 4 == 3 ? tileNode(40, {k, -k, 1}, randomVector(random, 50)) : randomNode(random, 50));
    map.apply(std::move(update));
  }
  MapUpdate update;
  update.keyframe = keyframeIfNeeded(map, {}, constraintsOfNext(map));
  update.removed = {static_cast<NodeId>(nodes)};
  map.apply(std::move(update));
  return map;
}

/// The same with a graph.
Map sampleGraph(unsigned seed, int nodes) {
  Map map = sampleMap(seed, nodes);
  map.setEdgeModel({0.02, 0.3});
  return map;
}

std::string payloadOf(const std::string& file) {
  std::string payload(ZSTD_getFrameContentSize(file.data() + kHeaderBytes, file.size() - kHeaderBytes), '\0');
  EXPECT_EQ(ZSTD_decompress(payload.data(), payload.size(), file.data() + kHeaderBytes, file.size() - kHeaderBytes),
            payload.size());
  return payload;
}

/// A file around any payload, with the checksum right.
std::string fileAround(const std::string& header, const std::string& payload) {
  std::string frame(ZSTD_compressBound(payload.size()), '\0');
  frame.resize(ZSTD_compress(frame.data(), frame.size(), payload.data(), payload.size(), 3));
  return header + frame;
}

template <typename T>
T at(const std::string& bytes, std::size_t offset) {
  T value{};
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

template <typename T>
std::string with(std::string bytes, std::size_t offset, T value) {
  std::memcpy(bytes.data() + offset, &value, sizeof(T));
  return bytes;
}

bool mentions(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

std::vector<std::string> filesIn(const fs::path& directory) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(directory)) {
    names.push_back(entry.path().filename().string());
  }
  return names;
}

void expectSame(const MapNode& a, const MapNode& b) {
  EXPECT_EQ(a.id, b.id);
  EXPECT_EQ(a.label, b.label);
  EXPECT_EQ(a.stuff, b.stuff);
  EXPECT_EQ(a.tile, b.tile);
  EXPECT_EQ(a.belief.mean, b.belief.mean);
  EXPECT_EQ(Mat3(a.belief.cov.selfadjointView<Eigen::Upper>()), b.belief.cov);
  EXPECT_EQ(a.belief.kappa, b.belief.kappa);
  EXPECT_EQ(a.T_map_object.matrix(), b.T_map_object.matrix());
  EXPECT_EQ(a.views, b.views);
  EXPECT_EQ(a.first_us, b.first_us);
  EXPECT_EQ(a.last_us, b.last_us);
  EXPECT_EQ(a.classes.views, b.classes.views);
  ASSERT_EQ(leavesOf(a).size(), leavesOf(b).size());
  for (std::size_t k = 0; k < leavesOf(a).size(); ++k) {
    EXPECT_EQ(leavesOf(a)[k].mean, leavesOf(b)[k].mean);
    EXPECT_EQ(leavesOf(a)[k].cov, leavesOf(b)[k].cov);
    EXPECT_EQ(leavesOf(a)[k].kappa, leavesOf(b)[k].kappa);
  }
}

TEST(MapFile, RoundTripIsExact) {
  const Map map = sampleGraph(1, 50);
  const std::vector<Edge> edges = map.graph().edges();
  EXPECT_GT(edges.size(), 10U);
  const auto stored = decodeMap(encodeMap(map));
  ASSERT_TRUE(stored) << stored.error;
  EXPECT_EQ(stored->map.revision(), map.revision());
  EXPECT_EQ(stored->map.nextId(), map.nextId());
  EXPECT_EQ(stored->map.classNames(), map.classNames());
  ASSERT_EQ(stored->map.nodes().size(), map.nodes().size());
  for (const auto& [id, node] : map.nodes()) {
    expectSame(node, *stored->map.find(id));
  }
  ASSERT_EQ(stored->map.keyframes().poses().size(), map.keyframes().poses().size());
  for (std::size_t k = 0; k < map.keyframes().poses().size(); ++k) {
    EXPECT_EQ(stored->map.keyframes().poses()[k].utime_us, map.keyframes().poses()[k].utime_us);
    EXPECT_EQ(stored->map.keyframes().poses()[k].T_map_body.matrix(), map.keyframes().poses()[k].T_map_body.matrix());
  }
  ASSERT_EQ(stored->edges.size(), edges.size());
  for (std::size_t k = 0; k < edges.size(); ++k) {
    EXPECT_TRUE(stored->edges[k].a == edges[k].a && stored->edges[k].b == edges[k].b &&
                stored->edges[k].weight == edges[k].weight);
  }
}

TEST(MapFile, SavingWhatWasLoadedGivesTheSameBytes) {
  for (const int nodes : {1, 7, 300}) {
    const std::string first = encodeMap(sampleGraph(2, nodes));
    auto stored = decodeMap(first);
    ASSERT_TRUE(stored) << stored.error;
    EXPECT_EQ(encodeMap(*stored), first);
    stored->map.setEdgeModel({0.02, 0.3});
    EXPECT_EQ(encodeMap(stored->map), first) << "with the graph of what was loaded";
  }
}

TEST(MapFile, HoldsMapsOfNothingAndOfManyBlocks) {
  const auto empty = decodeMap(encodeMap(Map{}));
  ASSERT_TRUE(empty) << empty.error;
  EXPECT_TRUE(empty->map.nodes().empty());

  std::mt19937 random(3);
  MapNode large = nodeAt(10, Vec3(0, 0, 0));
  Leaves leaves(250000);  // 10 MB of leaves, blocks hold 4 MiB
  std::ranges::generate(leaves, [&] { return randomLeaf(random); });
  large.geometry = shareLeaves(std::move(leaves));
  const auto stored = decodeMap(encodeMap(mapOf({large})));
  ASSERT_TRUE(stored) << stored.error;
  expectSame(stored->map.nodes().begin()->second, mapOf({large}).nodes().begin()->second);
}

TEST(MapFile, AnIdOnceGivenIsNotGivenAgainAfterReloading) {
  Map map = sampleMap(4, 9);  // its newest node, 9, was removed
  auto stored = decodeMap(encodeMap(map));
  ASSERT_TRUE(stored) << stored.error;
  MapUpdate update;
  update.created = {nodeAt(10, Vec3(0, 0, 0))};
  EXPECT_EQ(stored->map.apply(update).changed, (std::vector<NodeId>{10}));
}

TEST(MapFile, FollowsItsDocumentedGrammar) {
  MapNode node = nodeAt(10, Vec3(1, 2, 3));
  addLeaf(node, packLeaf({Vec3(0.5, 0, 0), Mat3::Identity(), 9}));
  Map map = mapOf({node, nodeAt(11, Vec3(4, 5, 6))});
  map.setClassNames({{10, "car"}});
  map.setTileSize(2.5);
  map.setOdometryDelay(-93'000);
  const std::string file = encodeMap({map, {{1, 2, 0.25F}}});
  EXPECT_EQ(file.substr(0, 8), "HGGMAP\r\n");
  EXPECT_EQ(at<std::uint32_t>(file, 8), 5U);
  const std::string payload = payloadOf(file);
  EXPECT_EQ(at<std::uint32_t>(payload, 0), 1U);  // classes
  EXPECT_EQ(at<std::uint16_t>(payload, 4), 10);
  EXPECT_EQ(at<std::uint16_t>(payload, 6), 3);
  EXPECT_EQ(payload.substr(8, 3), "car");
  EXPECT_EQ(at<double>(payload, 11), 2.5);            // tile_size
  EXPECT_EQ(at<std::int64_t>(payload, 19), -93'000);  // delay
  EXPECT_EQ(at<std::int64_t>(payload, 27), 1);        // revision
  EXPECT_EQ(at<std::int64_t>(payload, 35), 3);        // next_id
  EXPECT_EQ(at<std::uint64_t>(payload, 43), 1U);      // keyframes
  const std::size_t ties = 51 + 8 + 96, nodes = ties + 8;
  EXPECT_EQ(at<std::uint64_t>(payload, ties), 0U);
  EXPECT_EQ(at<std::uint64_t>(payload, nodes), 2U);
  const std::size_t first = nodes + 8;
  EXPECT_EQ(at<std::int64_t>(payload, first), 1);
  EXPECT_EQ(at<std::uint16_t>(payload, first + 8), 10);
  EXPECT_EQ(at<std::uint8_t>(payload, first + 10), 0);
  EXPECT_EQ(at<double>(payload, first + 23), 1);     // mean
  EXPECT_EQ(at<double>(payload, first + 47), 0.25);  // covariance
  EXPECT_EQ(at<double>(payload, first + 95), 100);   // kappa
  const std::size_t leaves = first + 11 + 12 + 80 + 96 + 4 + 16 + 4;
  EXPECT_EQ(at<std::int32_t>(payload, leaves - 4), 0);  // anchor
  EXPECT_EQ(at<std::uint32_t>(payload, leaves), 1U);
  EXPECT_EQ(at<float>(payload, leaves + 4), 0.5F);
  EXPECT_EQ(at<float>(payload, leaves + 40), 9.0F);
  const std::size_t classes = leaves + 44;
  EXPECT_EQ(at<std::uint16_t>(payload, classes), 1U);
  EXPECT_EQ(at<std::uint16_t>(payload, classes + 2), 10U);
  EXPECT_EQ(at<float>(payload, classes + 4), 1000.0F);
  const std::size_t edges = classes + 8 + 227 + 8;
  EXPECT_EQ(at<std::uint64_t>(payload, edges), 1U);
  EXPECT_EQ(at<float>(payload, edges + 24), 0.25F);
  EXPECT_EQ(payload.substr(edges + 28), "END.");
}

TEST(MapFile, EveryTruncationIsAnError) {
  const std::string bytes = encodeMap(sampleGraph(5, 4));
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    const auto stored = decodeMap(bytes.substr(0, length));
    ASSERT_FALSE(stored) << length << " of " << bytes.size();
    EXPECT_FALSE(stored.error.empty());
  }
}

TEST(MapFile, EveryTruncationOfThePayloadAndAnythingBehindItIsAnError) {
  const Map map = sampleGraph(6, 4);
  const std::string bytes = encodeMap(map), header = bytes.substr(0, kHeaderBytes), payload = payloadOf(bytes);
  for (std::size_t length = 1; length < payload.size(); ++length) {
    ASSERT_FALSE(decodeMap(fileAround(header, payload.substr(0, length)))) << length;
  }
  EXPECT_FALSE(decodeMap(fileAround(header, payload + "x")));
  EXPECT_FALSE(decodeMap(bytes + "x"));
  EXPECT_TRUE(decodeMap(fileAround(header, payload)));
}

TEST(MapFile, EverySingleByteFlipIsAnErrorOrHarmless) {
  const std::string bytes = encodeMap(sampleMap(7, 2));
  std::size_t harmless = 0;
  std::string flipped = bytes;
  for (std::size_t k = 0; k < bytes.size(); ++k) {
    for (int mask = 1; mask < 256; ++mask) {
      flipped[k] = static_cast<char>(bytes[k] ^ mask);
      if (const auto stored = decodeMap(flipped)) {
        ++harmless;  // a bit that zstd leaves unused
        ASSERT_EQ(encodeMap(*stored), bytes) << "byte " << k << " ^ " << mask << " gave another map";
      }
    }
    flipped[k] = bytes[k];
  }
  EXPECT_LE(harmless, bytes.size());  // of 255 as many
}

TEST(MapFile, ASmallFileThatClaimsGigabytesIsRefusedBeforeItIsUnpacked) {
  const std::string header = encodeMap(sampleMap(9, 1)).substr(0, kHeaderBytes);
  const std::string zeros(4U << 20, '\0');
  const std::string block = fileAround("", zeros);
  std::string bomb = header;
  for (int k = 0; k < 600; ++k) {  // 2.4 GB
    bomb += block;
  }
  ASSERT_LT(bomb.size(), 1U << 20);
  EXPECT_TRUE(mentions(decodeMap(bomb).error, "more than a map of its size"));
}

TEST(MapFile, NoPayloadCrashesTheReader) {
  const Map map = sampleGraph(8, 4);
  const std::string bytes = encodeMap(map), header = bytes.substr(0, kHeaderBytes), payload = payloadOf(bytes);
  std::mt19937 random(9);
  for (int k = 0; k < 3000; ++k) {
    std::string mutated = payload;
    for (std::uint32_t n = 1 + below(random, 3); n > 0; --n) {
      mutated[below(random, static_cast<std::uint32_t>(mutated.size()))] =
          static_cast<char>(below(random, 3) == 0 ? 0xFF : below(random, 256));
    }
    if (const auto stored = decodeMap(fileAround(header, mutated))) {
      EXPECT_EQ(stored->map.nodes().size(), map.nodes().size());  // changed values, not a changed structure
    }
  }
}

TEST(MapFile, ContentsThatMakeNoSenseAreAnError) {
  Map map = mapOf({tileNode(40, {0, 0, 0}, Vec3(0, 0, 0)), tileNode(40, {1, 0, 0}, Vec3(10, 0, 0))});
  const std::string bytes = encodeMap({map, {{1, 2, 0.5F}}}), header = bytes.substr(0, kHeaderBytes),
                    payload = payloadOf(bytes);
  const auto loads = [&](const std::string& changed) {
    return static_cast<bool>(decodeMap(fileAround(header, changed)));
  };
  const std::size_t keyframes = 4 + 8 + 8 + 8 + 8, nodes = keyframes + 8 + 104 + 8, first = nodes + 8,
                    second = first + 229, edges = second + 229;
  ASSERT_EQ(at<std::uint64_t>(payload, edges), 1U);
  ASSERT_TRUE(loads(payload));
  EXPECT_FALSE(loads(with(payload, 0, std::uint32_t{0xFFFFFFFF})));       // classes without end
  EXPECT_FALSE(loads(with(payload, keyframes, std::uint64_t{1} << 60)));  // a count beyond any file
  EXPECT_FALSE(loads(with(payload, nodes, ~std::uint64_t{0})));
  EXPECT_FALSE(loads(with(payload, edges, std::uint64_t{2})));
  EXPECT_FALSE(loads(with(payload, second, std::int64_t{1})));  // an id twice
  EXPECT_FALSE(loads(with(payload, first, std::int64_t{0})));
  EXPECT_FALSE(loads(with(payload, 28, std::int64_t{2})));           // next_id is taken
  EXPECT_TRUE(loads(with(payload, second + 11, std::int32_t{0})));   // a tile twice: one copy awaits its loop
  EXPECT_FALSE(loads(with(payload, first + 219, std::int32_t{1})));  // an anchor beyond the keyframes
  EXPECT_FALSE(loads(with(payload, first + 219, std::int32_t{-2})));
  EXPECT_FALSE(loads(with(payload, first + 23, std::nan(""))));     // a mean nowhere
  EXPECT_FALSE(loads(with(payload, first + 95, -1.0)));             // negative evidence
  EXPECT_FALSE(loads(with(payload, edges + 8, std::int64_t{2})));   // an edge to itself
  EXPECT_FALSE(loads(with(payload, edges + 16, std::int64_t{3})));  // an edge to nowhere
  EXPECT_FALSE(loads(with(payload, edges + 24, std::numeric_limits<float>::infinity())));
}

/// A map of three keyframes with a loop, and nodes that hang on the second, the last and none of them.
Map looseMap() {
  std::mt19937 random(20);
  KeyframeGraph keyframes;
  for (int k = 0; k < 3; ++k) {
    keyframes.add({100 * k, randomPose(random, 30)});
  }
  keyframes.connect({0, 1, randomPose(random, 3), 0.02, 0.001, false, 0.002, 0.0003});
  keyframes.connect({1, 2, randomPose(random, 3), 0.03, 0.002, false});
  keyframes.connect({0, 2, randomPose(random, 3), 0.08, 0.005, true});
  std::vector<MapNode> nodes;
  for (const KeyframeId anchor : {1, 2, -1}) {
    nodes.push_back(randomNode(random, 30));
    nodes.back().id = static_cast<NodeId>(nodes.size());
    nodes.back().anchor = anchor;
  }
  return Map::restore(nodes, keyframes, {}, 9);
}

/// The payload as versions 1 and 2 had it: no ties, no anchors; in version 1 no classes of nodes.
std::string payloadAs(std::uint32_t version, const Map& map) {
  const auto anchorAt = [](std::size_t node) { return node + 11 + 12 + 80 + 96 + 4 + 16; };
  std::string payload = payloadOf(encodeMap(map));
  std::size_t offset = 4 + 8;
  for (const auto& [id, name] : map.classNames()) {
    offset += 4 + name.size();
  }
  payload.erase(offset, 8);  // the delay
  offset += 8 + 8;
  offset += 8 + 104 * map.keyframes().poses().size();
  payload.erase(offset, 8 + kTieBytes * map.keyframes().edges().size());
  offset += 8;
  for (const auto& [id, node] : map.nodes()) {
    EXPECT_EQ(at<NodeId>(payload, offset), id);
    EXPECT_EQ(at<KeyframeId>(payload, anchorAt(offset)), node.anchor);
    payload.erase(anchorAt(offset), 4);
    offset = anchorAt(offset) + 4 + 40 * leavesOf(node).size();
    const std::size_t classes = 2 + 6 * node.classes.views.size();
    payload.erase(offset, version == 1 ? classes : 0);
    offset += version == 1 ? 0 : classes;
  }
  return payload;
}

std::string headerOf(std::uint32_t version) { return with(encodeMap(Map{}).substr(0, kHeaderBytes), 8, version); }

TEST(MapFile, TiesLoopsAndAnchorsComeBackAsTheyWere) {
  const Map map = looseMap();
  const std::string bytes = encodeMap(map);
  const auto stored = decodeMap(bytes);
  ASSERT_TRUE(stored) << stored.error;
  ASSERT_EQ(stored->map.keyframes().edges().size(), 3U);
  for (std::size_t k = 0; k < 3; ++k) {
    const BetweenConstraint &expected = map.keyframes().edges()[k], &e = stored->map.keyframes().edges()[k];
    EXPECT_EQ(e.a, expected.a);
    EXPECT_EQ(e.b, expected.b);
    EXPECT_EQ(e.T_a_b.matrix(), expected.T_a_b.matrix());
    EXPECT_EQ(e.sigma, expected.sigma);
    EXPECT_EQ(e.sigma_turn, expected.sigma_turn);
    EXPECT_EQ(e.expected, expected.expected);
    EXPECT_EQ(e.expected_turn, expected.expected_turn);
    EXPECT_EQ(e.is_loop, k == 2);
  }
  EXPECT_EQ(stored->map.find(1)->anchor, 1);
  EXPECT_EQ(stored->map.find(2)->anchor, 2);
  EXPECT_EQ(stored->map.find(3)->anchor, -1);
  EXPECT_EQ(encodeMap(stored->map), bytes);
}

TEST(MapFile, AMapFromBeforeTiesIsAChain) {
  for (const Map& map : {looseMap(), sampleMap(21, 12)}) {
    const auto stored = decodeMap(fileAround(headerOf(2), payloadAs(2, map)));
    ASSERT_TRUE(stored) << stored.error;
    const std::vector<TimedPose>& poses = stored->map.keyframes().poses();
    ASSERT_EQ(poses.size(), map.keyframes().poses().size());
    ASSERT_EQ(stored->map.keyframes().edges().size(), poses.size() - 1);
    for (std::size_t k = 1; k < poses.size(); ++k) {
      const BetweenConstraint& e = stored->map.keyframes().edges()[k - 1];
      EXPECT_EQ(e.a, static_cast<KeyframeId>(k) - 1);
      EXPECT_EQ(e.b, static_cast<KeyframeId>(k));
      EXPECT_FALSE(e.is_loop);
      EXPECT_TRUE((poses[k - 1].T_map_body * e.T_a_b).isApprox(poses[k].T_map_body, 1e-12));
    }
    ASSERT_EQ(stored->map.nodes().size(), map.nodes().size());
    for (const auto& [id, node] : map.nodes()) {
      expectSame(node, *stored->map.find(id));
    }
  }
}

TEST(MapFile, AMapFromBeforeTiesLosesAThirdOfAMetreInAHundred) {
  KeyframeGraph keyframes;
  for (int k = 0; k <= 50; ++k) {
    keyframes.add({k, at(2.0 * k)});
  }
  const auto stored = decodeMap(fileAround(headerOf(2), payloadAs(2, Map::restore({}, keyframes, {}, 1))));
  ASSERT_TRUE(stored) << stored.error;
  const Drift drift = stored->map.keyframes().driftFrom(50, 1e9)[0];
  EXPECT_NEAR(drift.position, 0.35, 0.15);
  EXPECT_NEAR(drift.turn * 180 / M_PI, 0.3, 0.05);
}

/// Nodes first seen at these times, that hang on nothing, and keyframes of these.
Map mapOfTimes(const std::vector<Micros>& keyframe_times, const std::vector<Micros>& first_seen) {
  KeyframeGraph keyframes;
  for (const Micros utime_us : keyframe_times) {
    keyframes.add({utime_us, at(5.0 * (keyframes.last() + 1))});
  }
  std::vector<MapNode> nodes;
  for (const Micros utime_us : first_seen) {
    nodes.push_back(nodeAt(10, Vec3(1, 2, 3)));
    nodes.back().id = static_cast<NodeId>(nodes.size());
    nodes.back().first_us = utime_us;
  }
  return Map::restore(nodes, keyframes, {}, 9);
}

TEST(MapFile, NodesFromBeforeAnchorsHangOnTheLastKeyframeThatIsNotYounger) {
  struct Case {
    std::vector<Micros> keyframes, first_seen;
    std::vector<KeyframeId> anchors;
  };
  const Case cases[] = {
      {{100, 200, 300}, {-5, 99, 100, 199, 200, 250, 300, 9000}, {0, 0, 0, 0, 1, 1, 2, 2}},
      {{100, 100, 300}, {100, 200}, {1, 1}},
      {{10, 600, 700, 50, 800}, {0, 10, 49, 100, 650, 9000}, {0, 0, 0, 3, 3, 4}},  // gone on from with an older log
      {{}, {0, 50}, {-1, -1}},
  };
  for (const std::uint32_t version : {1U, 2U}) {
    for (const Case& c : cases) {
      const Map map = mapOfTimes(c.keyframes, c.first_seen);
      const auto stored = decodeMap(fileAround(headerOf(version), payloadAs(version, map)));
      ASSERT_TRUE(stored) << stored.error;
      std::vector<KeyframeId> anchors;
      for (const auto& [id, node] : stored->map.nodes()) {
        anchors.push_back(node.anchor);
      }
      EXPECT_EQ(anchors, c.anchors) << "version " << version;
    }
  }
}

TEST(MapFile, ACorrectionMovesNodesFromBeforeAnchorsWithTheirKeyframes) {
  auto stored = decodeMap(fileAround(headerOf(2), payloadAs(2, mapOfTimes({100, 200}, {150, 250}))));
  ASSERT_TRUE(stored) << stored.error;
  EXPECT_EQ(stored->map.apply(MapCorrection{{{1, at(6)}}, {}}).moved, (std::vector<NodeId>{2}));
  EXPECT_EQ(stored->map.find(1)->belief.mean, Vec3(1, 2, 3));
  EXPECT_TRUE(stored->map.find(2)->belief.mean.isApprox(Vec3(2, 2, 3), 1e-12));
}

/// Keyframes of which two hang together beside the first two, and two hang on nothing.
Map mapOfLooseKeyframes() {
  KeyframeGraph keyframes;
  for (int k = 0; k < 6; ++k) {
    keyframes.add({100 * k, at(3.0 * k)});
  }
  keyframes.connect({0, 1, at(3), 0.02, 0.001, false});
  keyframes.connect({4, 2, at(-6), 0.08, 0.005, true});
  return Map::restore({}, keyframes, {}, 9);
}

TEST(MapFile, KeyframesThatNothingConnectsToTheFirstAreTiedToTheOneBefore) {
  const auto stored = decodeMap(encodeMap(mapOfLooseKeyframes()));
  ASSERT_TRUE(stored) << stored.error;
  const KeyframeGraph& keyframes = stored->map.keyframes();
  ASSERT_EQ(keyframes.edges().size(), 5U);
  EXPECT_EQ(keyframes.edges()[0].sigma, 0.02);
  EXPECT_TRUE(keyframes.edges()[1].is_loop);
  const KeyframeId later[] = {2, 3, 5};  // 4 hangs on 2
  for (std::size_t k = 0; k < 3; ++k) {
    const BetweenConstraint& e = keyframes.edges()[2 + k];
    EXPECT_EQ(e.a, later[k] - 1);
    EXPECT_EQ(e.b, later[k]);
    EXPECT_TRUE(e.T_a_b.isApprox(at(3), 1e-12));
    EXPECT_EQ(e.sigma, 0.3);
    EXPECT_NEAR(e.sigma_turn * 180 / M_PI, 3, 1e-12);
    EXPECT_FALSE(e.is_loop);
  }
  for (const Drift& drift : keyframes.driftFrom(5, std::numeric_limits<double>::infinity())) {
    EXPECT_GE(drift.position, 0);
  }
  const std::string bytes = encodeMap(stored->map);
  const auto again = decodeMap(bytes);
  ASSERT_TRUE(again) << again.error;
  EXPECT_EQ(encodeMap(again->map), bytes) << "what is connected stays as it is";
}

TEST(MapFile, TiesAreReadWithinLimitsAndNeverWrittenBeyondThem) {
  const auto read = [](double sigma, double sigma_turn) {
    KeyframeGraph keyframes;
    keyframes.add({0, at(0)});
    keyframes.add({1, at(3)});
    keyframes.connect({0, 1, at(3), sigma, sigma_turn, false});
    const auto stored = decodeMap(encodeMap(Map::restore({}, keyframes, {}, 9)));
    EXPECT_TRUE(stored) << stored.error;
    const BetweenConstraint e = stored ? stored->map.keyframes().edges().at(0) : BetweenConstraint{};
    return std::pair(e.sigma, e.sigma_turn);
  };
  for (const auto& [sigma, sigma_turn] : {std::pair(1e-4, 1e-5), {1e-6, 1e-7}, {1e3, 1e3}, {15.0, 0.5}}) {
    EXPECT_EQ(read(sigma, sigma_turn), std::pair(sigma, sigma_turn));
  }
  EXPECT_EQ(read(0, 1e-20), std::pair(1e-6, 1e-7));
  EXPECT_EQ(read(1e200, 1e4), std::pair(1e3, 1e3));
}

TEST(MapFile, TiesThatMakeNoSenseAreAnError) {
  const std::string payload = payloadOf(encodeMap(looseMap()));
  const std::size_t ties = 4 + 8 + 8 + 8 + 8 + 8 + 3 * 104, first = ties + 8;
  ASSERT_EQ(at<std::uint64_t>(payload, ties), 3U);
  const auto loads = [&](const std::string& changed) {
    return static_cast<bool>(decodeMap(fileAround(encodeMap(looseMap()).substr(0, kHeaderBytes), changed)));
  };
  ASSERT_TRUE(loads(payload));
  for (const KeyframeId wrong : {-1, 3, 1 << 30}) {
    EXPECT_FALSE(loads(with(payload, first, wrong)));
    EXPECT_FALSE(loads(with(payload, first + 4, wrong)));
  }
  EXPECT_FALSE(loads(with(payload, first, KeyframeId{1})));  // to itself
  const double infinite = std::numeric_limits<double>::infinity();
  for (const double wrong : {0.0, -1.0, std::nan(""), infinite, -infinite, 1e-200, 1e-8, 1.1e3, 1e200}) {
    EXPECT_FALSE(loads(with(payload, first + 8 + 96, wrong))) << wrong;
    EXPECT_FALSE(loads(with(payload, first + 8 + 96 + 8, wrong))) << wrong;
    EXPECT_FALSE(loads(with(payload, first + 8 + 96 + 17, wrong))) << wrong;
    EXPECT_FALSE(loads(with(payload, first + 8 + 96 + 25, wrong))) << wrong;
  }
  EXPECT_FALSE(loads(with(payload, first + 8 + 96, 1e-7)));  // less than a micrometre
  EXPECT_FALSE(loads(with(payload, ties, std::uint64_t{4})));
  EXPECT_FALSE(loads(with(payload, ties, ~std::uint64_t{0})));
}

TEST(MapFile, OfTiesOfVersion3NoMoreIsExpectedThanTheirSigmas) {
  const Map map = looseMap();
  std::string payload = payloadOf(encodeMap(map));
  payload.erase(4 + 8, 8);  // the delay
  const std::size_t first = 4 + 8 + 8 + 8 + 8 + 3 * 104 + 8;
  for (std::size_t k = 3; k > 0; --k) {
    payload.erase(first + k * kTieBytes - 16, 16);
  }
  const auto stored = decodeMap(fileAround(headerOf(3), payload));
  ASSERT_TRUE(stored) << stored.error;
  for (const BetweenConstraint& e : stored->map.keyframes().edges()) {
    EXPECT_EQ(e.expected, e.sigma);
    EXPECT_EQ(e.expected_turn, e.sigma_turn);
  }
}

TEST(MapFile, HowFarKeyframesMayHaveDriftedComesBack) {
  const Map map = looseMap();
  const auto stored = decodeMap(encodeMap(map));
  ASSERT_TRUE(stored) << stored.error;
  for (KeyframeId k = 0; k < 3; ++k) {
    EXPECT_EQ(stored->map.poseCovariance(k), map.poseCovariance(k)) << k;
  }
  EXPECT_GT(map.poseCovariance(2).trace(), 0);
}

TEST(MapFile, AMapFromBeforeClassBeliefsIsReadAsIfEveryViewHadSaidTheSame) {
  MapNode car = nodeAt(10, Vec3(1, 2, 3));
  car.views = 7;
  car.classes = {};
  const std::string bytes = encodeMap(mapOf({car}));
  std::string payload = payloadOf(bytes);
  payload.erase(payload.size() - 4 - 8 - 2, 2);            // before the edges and the end: how many classes it has
  payload.erase(payload.size() - 4 - 8 - 4 - 4, 4);        // its anchor, before the number of its leaves
  payload.erase(payload.size() - 4 - 8 - 223 - 8 - 8, 8);  // ties, before the number of nodes
  payload.erase(4 + 8, 8);                                 // the delay, behind no class names and the size of tiles
  const auto stored = decodeMap(fileAround(with(bytes.substr(0, kHeaderBytes), 8, std::uint32_t{1}), payload));
  ASSERT_TRUE(stored) << stored.error;
  EXPECT_EQ(stored->map.find(1)->classes.views, (ClassWeights{{10, 7.0F}}));
}

TEST(MapFile, TheDelayOfOdometryComesBackAndOlderFilesHaveNone) {
  Map map = looseMap();
  map.setOdometryDelay(104'000);
  const std::string bytes = encodeMap(map);
  const auto stored = decodeMap(bytes);
  ASSERT_TRUE(stored) << stored.error;
  EXPECT_EQ(stored->map.odometryDelay_us(), 104'000);

  std::string payload = payloadOf(bytes);
  payload.erase(4 + 8, 8);  // behind no class names and the size of tiles
  const auto older = decodeMap(fileAround(headerOf(4), payload));
  ASSERT_TRUE(older) << older.error;
  EXPECT_EQ(older->map.odometryDelay_us(), 0);
  EXPECT_EQ(older->map.nodes().size(), map.nodes().size());

  map.setOdometryDelay(11'000'000);
  EXPECT_FALSE(decodeMap(encodeMap(map))) << "no delay is that long";
}

TEST(MapFile, WhatWasSeenThroughComesBackAndMapsWithoutAreWrittenAsBefore) {
  MapNode node = nodeAt(10, Vec3(1, 2, 3));
  const std::string before = encodeMap(mapOf({node}));
  node.classes.seen_through = 2.5F, node.classes.passed = 7;
  const std::string bytes = encodeMap(mapOf({node}));
  const auto stored = decodeMap(bytes);
  ASSERT_TRUE(stored);
  EXPECT_EQ(stored->map.find(1)->classes.seen_through, 2.5F);
  EXPECT_EQ(stored->map.find(1)->classes.passed, 7);
  EXPECT_EQ(encodeMap(stored->map), bytes);
  EXPECT_EQ(static_cast<int>(bytes[8]), 7);
  EXPECT_EQ(static_cast<int>(before[8]), 5);
}

TEST(MapFile, ANewerVersionSaysSo) {
  std::string bytes = encodeMap(sampleMap(10, 3));
  for (const std::uint32_t version : {0U, 8U, 77U}) {
    const auto stored = decodeMap(with(bytes, 8, version));
    EXPECT_FALSE(stored);
    EXPECT_TRUE(mentions(stored.error, "version " + std::to_string(version) + ",")) << stored.error;
  }
}

TEST(MapFile, WhatIsNoMapIsSaidToBeNone) {
  for (const std::string& bytes :
       {std::string(), std::string("hello\n"), std::string(100000, '\0'), std::string("HGGMAP\n\1")}) {
    EXPECT_TRUE(mentions(decodeMap(bytes).error, "not an hggmap map"));
  }
  // A text-mode transfer turned \r\n into \n.
  std::string bytes = encodeMap(sampleMap(11, 3));
  EXPECT_TRUE(mentions(decodeMap(bytes.erase(6, 1)).error, "not an hggmap map"));
}

TEST(MapFile, ErrorsNameTheFile) {
  const Scratch scratch;
  writeText(scratch / "m.hgg", "hello\n");
  EXPECT_EQ(loadMap((scratch / "m.hgg").string()).error, (scratch / "m.hgg").string() + ": not an hggmap map");
}

TEST(MapFile, AMissingFileOrADirectoryIsAnErrorThatNamesIt) {
  const Scratch scratch;
  for (const std::string& path :
       {(scratch / "none.hgg").string(), (scratch / "").string(), std::string(), std::string("/dev/null")}) {
    const auto stored = loadMap(path);
    EXPECT_FALSE(stored);
    EXPECT_TRUE(mentions(stored.error, path + ": no such map file")) << stored.error;
  }
}

TEST(SaveMap, ReplacesAnOlderMapAndLeavesNothingElse) {
  const Scratch scratch;
  const std::string path = (scratch / "s.hgg").string();
  EXPECT_EQ(saveMap(sampleMap(12, 20), path), "");
  EXPECT_EQ(saveMap(sampleMap(13, 5), path), "");
  EXPECT_EQ(readText(path), encodeMap(sampleMap(13, 5)));
  EXPECT_EQ(filesIn(scratch / ""), (std::vector<std::string>{"s.hgg"}));
  const auto stored = loadMap(path);
  ASSERT_TRUE(stored) << stored.error;
  EXPECT_EQ(stored->map.nodes().size(), 4U);
}

TEST(SaveMap, IntoAMissingFolderIsAnErrorThatNamesTheFile) {
  const Scratch scratch;
  const std::string path = (scratch / "no/such/folder/m.hgg").string();
  const std::string error = saveMap(sampleMap(14, 3), path);
  EXPECT_TRUE(mentions(error, path)) << error;
  EXPECT_TRUE(filesIn(scratch / "").empty());
}

TEST(SaveMap, OntoAFolderFailsAndLeavesNoTemporaryFile) {
  const Scratch scratch;
  fs::create_directories(scratch / "m.hgg/inside");
  const std::string error = saveMap(sampleMap(15, 3), (scratch / "m.hgg").string());
  EXPECT_TRUE(mentions(error, "cannot write the map")) << error;
  EXPECT_EQ(filesIn(scratch / ""), (std::vector<std::string>{"m.hgg"}));
}

TEST(SaveMap, RefusesAMapWithNumbersThatAreNotFinite) {
  const Scratch scratch;
  MapNode node = nodeAt(10, Vec3(1, 2, 3));
  node.belief.cov(0, 0) = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(mentions(saveMap(mapOf({node}), (scratch / "n.hgg").string()), "not finite"));
  EXPECT_TRUE(filesIn(scratch / "").empty());
}

TEST(SaveMap, OnAFullDiskKeepsTheOlderMapAndLeavesNoTemporaryFile) {
  const Scratch scratch;
  const std::string path = (scratch / "s.hgg").string();
  ASSERT_EQ(saveMap(sampleMap(16, 3), path), "");
  const Map larger = sampleMap(17, 200);
  rlimit limit{};
  getrlimit(RLIMIT_FSIZE, &limit);
  const rlim_t soft = limit.rlim_cur;
  const auto previous = std::signal(SIGXFSZ, SIG_IGN);
  limit.rlim_cur = 1000;
  setrlimit(RLIMIT_FSIZE, &limit);  // stands for a full disk: write() fails after a while
  const std::string error = saveMap(larger, path);
  limit.rlim_cur = soft;
  setrlimit(RLIMIT_FSIZE, &limit);
  std::signal(SIGXFSZ, previous);
  EXPECT_TRUE(mentions(error, "cannot write the map")) << error;
  EXPECT_EQ(filesIn(scratch / ""), (std::vector<std::string>{"s.hgg"}));
  EXPECT_EQ(readText(path), encodeMap(sampleMap(16, 3)));
}

}  // namespace
}  // namespace hgg::file_test
