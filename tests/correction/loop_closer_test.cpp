#include "correction/loop_closer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <thread>

#include "map/file.h"
#include "map/fuse.h"
#include "random_world.h"
#include "test_scene.h"

namespace hgg::loop_closer_test {
namespace {

/// A step as the corrector makes it, of a map that is all in memory.
std::optional<MapCorrection> stepOf(LoopCloser& closer, const Map& map) {
  auto correction = closer.step(map);
  closer.startVerification(map);
  return correction;
}

constexpr double kTileSize = 3;
constexpr double kSide = 40;  // m, of the square
constexpr double kStep = 2;   // m, between keyframes

/// Things and walls on both sides of the way around a square.
World squareWorld(unsigned seed) {
  std::mt19937 random(seed);
  World world;
  for (int k = 0; k < 160; ++k) {
    const double along = uniform(random, -12, kSide + 12), beside = uniform(random, 3, 9) * (k % 2 == 0 ? 1 : -1);
    const Vec3 side[] = {
        {along, beside, 0}, {kSide + beside, along, 0}, {along, kSide + beside, 0}, {beside, along, 0}};
    const double size = 0.1 * (1 + k % 3);
    world.things.push_back({static_cast<ClassId>(kChair + k % 3), side[k / 2 % 4] + Vec3(0, 0, 0.4 + size),
                            size * size * Mat3::Identity()});
  }
  for (int k = 0; k < 24; ++k) {
    const double along = uniform(random, 0, kSide);
    const Vec3 side[] = {{along, -10, 0}, {kSide + 10, along, 0}, {along, kSide + 10, 0}, {-10, along, 0}};
    addWall(world, side[k % 4], (k % 2 == 0 ? 4 : 5) * Vec3(std::cos(k), std::sin(k), 0));
  }
  return world;
}

/// Where the robot is: around the square, and on along its first sides.
Pose truthAt(int k) {
  const double way = kStep * k;
  const int side = static_cast<int>(way / kSide);
  const double s = way - kSide * side;
  const Vec3 at[] = {{s, 0, 0}, {kSide, s, 0}, {kSide - s, kSide, 0}, {0, kSide - s, 0}};
  return frame(90 * side, at[side % 4]);
}

/// A drive whose poses turn away a little more at every keyframe, and the map it makes: what is not active at its place
/// when it is seen becomes a node.
struct Drive {
  static constexpr double kSigma = 0.05, kSigmaTurn = 0.1 * kDegree, kSight = 14;
  World world;
  Pose drift;  // at every step
  Config config;
  Map map;
  LoopCloser closer;
  std::vector<std::pair<KeyframeId, MapCorrection>> corrections;  // at which keyframe they came

  /// Of a place that is small beside the square.
  static LoopConfig smallPlaces() {
    LoopConfig loops = loopConfigOf(kTileSize, Config{}.map.leaf_size, Config{}.alignment.gate);
    loops.descriptor_radius = 15;
    loops.place_radius = 24;
    loops.pass_distance = 6;
    loops.prior_slack = 1.5;
    return loops;
  }

  Drive(unsigned seed, Pose drift_per_step, LoopTiming timing)
      : world(squareWorld(seed)), drift(std::move(drift_per_step)), closer(smallPlaces(), {}, timing) {
    map.setTileSize(kTileSize);
    map.setDriftReach(config.correction.drift_reach);
  }

  int keyframes() const { return static_cast<int>(map.keyframes().poses().size()); }
  Pose poseOf(int k) const { return map.keyframes().poses()[static_cast<std::size_t>(k)].T_map_body; }

  void step() {
    const int k = keyframes();
    MapUpdate update;
    NewKeyframe keyframe{{100'000 * k, truthAt(k)}, {}};
    if (k > 0) {
      const Pose T_a_b = truthAt(k - 1).inverse() * truthAt(k) * drift;
      keyframe.pose.T_map_body = poseOf(k - 1) * T_a_b;
      keyframe.constraints = {{k - 1, -1, T_a_b, kSigma, kSigmaTurn, false}};
    }
    const Pose T_map_world = keyframe.pose.T_map_body * truthAt(k).inverse();
    update.keyframe = std::move(keyframe);
    map.apply(std::move(update));
    MapUpdate seen;
    seen.created = nodesSeen(T_map_world, truthAt(k).translation());
    map.apply(std::move(seen));
    if (auto correction = stepOf(closer, map)) {
      const MapDelta delta = map.apply(*correction);
      map.apply(mergeDuplicates(map, delta.reactivated, testClasses(), config));
      corrections.emplace_back(k, std::move(*correction));
    }
  }

  std::vector<MapNode> nodesSeen(const Pose& T_map_world, const Vec3& from) const {
    const auto sees = [&](const Vec3& p) { return (p - from).norm() < kSight; };
    std::vector<MapNode> nodes = nodesOfWorld(world, T_map_world.inverse(), static_cast<unsigned>(keyframes()), sees);
    for (MapNode& node : nodes) {
      node.tile = node.stuff ? tileOf(node.belief.mean, kTileSize) : Tile{};
    }
    std::vector<MapNode> fresh;
    for (const MapNode& node : nodes) {
      const auto isThere = [&](NodeId id) { return map.find(id)->label == node.label; };
      const bool known = node.stuff ? map.findTile(node.label, node.tile) != nullptr
                                    : std::ranges::any_of(map.near(node.belief.mean, 0.3), isThere);
      const bool twice = std::ranges::any_of(fresh, [&](const MapNode& other) {
        return node.stuff ? other.stuff && other.label == node.label && other.tile == node.tile
                          : other.label == node.label && (other.belief.mean - node.belief.mean).norm() < 0.3;
      });
      if (!known && !twice) {
        fresh.push_back(node);
      }
    }
    return fresh;
  }

  void driveTo(int keyframe) {
    while (keyframes() <= keyframe) {
      step();
    }
  }

  double worstError() const {
    double worst = 0;
    for (int k = 0; k < keyframes(); ++k) {
      worst = std::max(worst, (poseOf(k).translation() - truthAt(k).translation()).norm());
    }
    return worst;
  }

  /// Active things that stand where another of their class does.
  int duplicates() const {
    int count = 0;
    for (const auto& [id, node] : map.nodes()) {
      for (const NodeId other : map.near(node.belief.mean, 0.4)) {
        count += !node.stuff && map.isActive(node) && other > id && map.find(other)->label == node.label ? 1 : 0;
      }
    }
    return count;
  }
};

constexpr int kRound = static_cast<int>(4 * kSide / kStep);

Pose drifting() { return frame(0.04, Vec3(0.002, 0.001, 0)); }

int pairsTooClose(const World& world) {
  int count = 0;
  for (std::size_t i = 0; i < world.things.size(); ++i) {
    for (std::size_t j = i + 1; j < world.things.size(); ++j) {
      count +=
          world.things[i].label == world.things[j].label && (world.things[i].mean - world.things[j].mean).norm() < 0.5
              ? 1
              : 0;
    }
  }
  return count;
}

TEST(LoopCloser, ARoundOfASquareEndsWhereItBegan) {
  for (unsigned seed = 1; seed <= 2; ++seed) {
    Drive drive(seed, drifting(), LoopTiming::kFixed);
    double before = 0;
    while (drive.closer.accepted() == 0 && drive.keyframes() < kRound + 12) {
      before = drive.worstError();
      drive.step();
    }
    ASSERT_EQ(drive.corrections.size(), 1U);
    EXPECT_GT(before, 0.8);
    EXPECT_LT(drive.worstError(), 0.2);
    EXPECT_LE(drive.duplicates(), pairsTooClose(drive.world));
    drive.driveTo(kRound + 12);
    EXPECT_LT(drive.worstError(), 0.4);  // it goes on drifting
    const LoopRecord& record =
        *std::ranges::find_if(drive.closer.records(), [](const LoopRecord& r) { return r.accepted; });
    EXPECT_GT(record.now_us, record.before_us);
    const Pose expected = truthAt(static_cast<int>(record.before_us / 100'000)).inverse() *
                          truthAt(static_cast<int>(record.now_us / 100'000));
    EXPECT_LT((record.T_before_now.translation() - expected.translation()).norm(), 0.15);
  }
}

TEST(LoopCloser, TwoRunsWithFixedTimingGiveTheSameMap) {
  Drive a(3, drifting(), LoopTiming::kFixed), b(3, drifting(), LoopTiming::kFixed);
  a.driveTo(kRound + 12);
  b.driveTo(kRound + 12);
  EXPECT_GE(a.corrections.size(), 1U);
  EXPECT_EQ(encodeMap(a.map), encodeMap(b.map));
  EXPECT_EQ(a.closer.accepted(), b.closer.accepted());
  EXPECT_EQ(a.closer.rejected(), b.closer.rejected());
}

TEST(LoopCloser, KeyframesYoungerThanTheCandidateMoveWithTheNewestItKnew) {
  Drive drive(1, drifting(), LoopTiming::kFixed);
  std::vector<Pose> before;
  while (drive.corrections.empty() && drive.keyframes() < kRound + 20) {
    before.clear();
    for (int k = 0; k < drive.keyframes(); ++k) {
      before.push_back(drive.poseOf(k));
    }
    drive.step();
  }
  ASSERT_EQ(drive.corrections.size(), 1U);
  const auto& [at, correction] = drive.corrections[0];
  ASSERT_EQ(correction.loops.size(), 1U);
  const KeyframeId candidate = correction.loops[0].b;
  EXPECT_EQ(at, candidate + 2);
  ASSERT_EQ(correction.moved.size(), static_cast<std::size_t>(at)) << "all but the first, which holds the map";
  EXPECT_EQ(correction.moved.front().first, 1);
  const Pose move = drive.poseOf(candidate) * before[static_cast<std::size_t>(candidate)].inverse();
  EXPECT_GT(move.translation().norm(), 0.5);
  const KeyframeId younger = candidate + 1;  // the one after it is younger than `before`
  EXPECT_TRUE(drive.poseOf(younger).isApprox(move * before[static_cast<std::size_t>(younger)], 1e-9));
  EXPECT_TRUE((drive.poseOf(candidate).inverse() * drive.poseOf(at))
                  .isApprox(truthAt(candidate).inverse() * truthAt(candidate + 1) * drifting() *
                                truthAt(candidate + 1).inverse() * truthAt(candidate + 2) * drifting(),
                            1e-9));
}

const LoopConfig kOutdoors = loopConfigOf(10, 0.4, 3);  // m, tiles and leaves

/// A robot that thinks it is `offset` from a room it knows, by keyframes that leave it `sigma` of doubt.
struct Doubt {
  Map map;
  LoopCloser closer;
  World world = randomWorld(1);

  int measured = 1;  // how often each constraint was

  explicit Doubt(LoopTiming timing = LoopTiming::kFixed) : closer(kOutdoors, {}, timing) { map.setDriftReach(0.5); }

  void keyframe(const Pose& T, double sigma, const Pose* T_map_world) {
    MapUpdate update;
    update.keyframe = NewKeyframe{{1000 * (map.keyframes().last() + 1), T}, {}};
    if (map.keyframes().last() >= 0) {
      const Pose T_a_b = map.keyframes().poses().back().T_map_body.inverse() * T;
      update.keyframe->constraints.assign(static_cast<std::size_t>(measured),
                                          {map.keyframes().last(), -1, T_a_b, sigma, 1e-4, false});
    }
    if (T_map_world != nullptr) {
      update.created =
          nodesOfWorld(world, T_map_world->inverse(), static_cast<unsigned>(map.keyframes().poses().size() + 1));
    }
    map.apply(std::move(update));
  }
  /// Comes back, which starts a verification.
  void comeBack(const Pose& offset, double sigma) {
    const Pose start = Pose::Identity();
    keyframe(start, 0, &start);
    stepOf(closer, map);
    for (const double y : {0.0, 10.0}) {
      keyframe(frame(0, Vec3(150, y, 0)), sigma / std::sqrt(3.0), nullptr);
      stepOf(closer, map);
    }
    keyframe(offset, sigma / std::sqrt(3.0), &offset);
    EXPECT_FALSE(stepOf(closer, map));
  }
  /// The n-th keyframe after that, and what it brings.
  std::optional<MapCorrection> goOn(int n, const Pose& offset) {
    keyframe(offset * frame(0, Vec3(0, 0, 2 * (n % 2))), 0.01, nullptr);
    return stepOf(closer, map);
  }
  /// Has the place verified, and two keyframes later once more: what both verifications come to.
  std::optional<MapCorrection> verifyTwice(const Pose& offset, double sigma) {
    comeBack(offset, sigma);
    for (const int n : {1, 2, 3}) {
      EXPECT_FALSE(goOn(n, offset));
    }
    return goOn(4, offset);
  }
  int verified() const { return closer.accepted() + closer.rejected(); }
};

TEST(LoopCloser, ALoopThatDriftExplainsIsApplied) {
  Doubt doubt;
  const auto correction = doubt.verifyTwice(frame(0, Vec3(1, 0, 0)), 1);
  ASSERT_TRUE(correction) << (doubt.closer.records().empty() ? "never verified" : doubt.closer.records().back().reason);
  EXPECT_EQ(doubt.closer.accepted(), 1);
  EXPECT_EQ(doubt.closer.rejected(), 1);
  EXPECT_EQ(doubt.closer.records()[0].reason.find("not seen twice yet"), 0U);
  doubt.map.apply(*correction);
  EXPECT_LT(doubt.map.keyframes().poses()[3].T_map_body.translation().norm(), 0.1);
  EXPECT_TRUE(doubt.map.isActive(KeyframeId{0}));
}

TEST(LoopCloser, ALoopFartherOffThanDriftAllowsIsNot) {
  Doubt doubt;  // the room is where it may be, but turned as the way cannot have turned
  EXPECT_FALSE(doubt.verifyTwice(frame(2.8, Vec3(0.5, 0, 0)), 0.6));
  ASSERT_EQ(doubt.closer.records().size(), 2U);
  const LoopRecord& record = doubt.closer.records()[0];
  EXPECT_FALSE(record.accepted);
  EXPECT_GT(record.deviations, 4.1);
  EXPECT_NE(record.reason.find("farther off than drift allows"), std::string::npos) << record.reason;
  EXPECT_GT(record.score, 0);
}

TEST(LoopCloser, ALoopThatTheOtherKeyframesSpeakAgainstIsNot) {
  Doubt doubt;
  doubt.measured = 30;  // any one way allows for it, all together do not
  EXPECT_FALSE(doubt.verifyTwice(frame(0, Vec3(1.8, 0, 0)), 0.6));
  ASSERT_EQ(doubt.closer.records().size(), 2U);
  const LoopRecord& record = doubt.closer.records()[0];
  EXPECT_FALSE(record.accepted);
  EXPECT_LT(record.deviations, 4.1);
  EXPECT_NE(record.reason.find("the other keyframes speak against it"), std::string::npos) << record.reason;
  EXPECT_GT(record.score, 0);
  EXPECT_EQ(doubt.closer.rejected(), 2);
  EXPECT_EQ(doubt.closer.accepted(), 0);
}

TEST(LoopCloser, PlacesOfAStoredMapAreKnownByTheirLooks) {
  // Two rooms far apart; the robot comes back to one of them with a drift that says nothing.
  for (const int here : {0, 1}) {
    const World rooms[] = {randomWorld(1), randomWorld(2)};
    const Pose at_room[] = {frame(0, Vec3(-25, 0, 0)), frame(0, Vec3(25, 0, 0))};
    Map map;
    for (const int k : {0, 1}) {
      MapUpdate update;
      update.keyframe = NewKeyframe{{k, at_room[k]}, {}};
      update.created = nodesOfWorld(rooms[k], at_room[k].inverse(), static_cast<unsigned>(k));
      if (k == 1) {
        update.keyframe->constraints = {{0, -1, at_room[0].inverse() * at_room[1], 0.01, 1e-4, false}};
      }
      map.apply(std::move(update));
    }
    LoopCloser closer(kOutdoors, {}, LoopTiming::kFixed);
    closer.start(map);
    map.setDriftReach(0.5);
    const Pose T = frame(0, Vec3(here == 0 ? 3 : -3, 0, 0));
    for (int k = 0; k < 3; ++k) {
      MapUpdate update;
      const KeyframeId last = map.keyframes().last();
      update.keyframe = NewKeyframe{{10 + k, T * frame(0, Vec3(0, 0, 2 * k))}, {}};
      update.keyframe->constraints = {{last, -1, frame(0, Vec3(2, 0, 0)), k == 0 ? 15 : 0.01, 1e-4, false}};
      if (k == 0) {
        update.created = nodesOfWorld(rooms[here], T.inverse(), 7);
      }
      map.apply(std::move(update));
      stepOf(closer, map);
    }
    ASSERT_EQ(closer.records().size(), 1U);
    EXPECT_EQ(closer.records()[0].before_us, here);
    EXPECT_EQ(closer.records()[0].reason.find("not seen twice yet"), 0U) << closer.records()[0].reason;
  }
}

/// A robot that knows a room, drives away, and begins a fragment of map there, in truth back in the room: its frame is
/// `offset` from the room's.
struct Kidnapped : Doubt {
  explicit Kidnapped(const Pose& offset) {
    const Pose start = Pose::Identity();
    keyframe(start, 0, &start);
    stepOf(closer, map);
    for (const double y : {0.0, 2.0}) {
      keyframe(frame(0, Vec3(150, y, 0)), 0.05, nullptr);
      stepOf(closer, map);
    }
    MapUpdate update;  // tied by a constraint that says nothing
    const Pose T_a_b = map.keyframes().poses().back().T_map_body.inverse() * offset;
    update.keyframe = NewKeyframe{{3000, offset}, {{2, -1, T_a_b, kAnywhere, kAnyTurn, false}}};
    update.created = nodesOfWorld(world, offset.inverse(), 4);
    map.apply(std::move(update));
    stepOf(closer, map);
  }
};

TEST(LoopCloser, AFragmentTiedLooselyIsLaidOnThePlaceHoweverItIsTurned) {
  const Pose offset = frame(150, Vec3(60, -25, 0));
  Kidnapped robot(offset);
  ASSERT_EQ(robot.map.keyframes().fragments(), (std::vector<KeyframeId>{0, 0, 0, 3}));
  std::optional<MapCorrection> correction;
  for (int n = 1; n <= 8 && !correction; ++n) {
    correction = robot.goOn(n, offset);
  }
  ASSERT_TRUE(correction) << (robot.closer.records().empty() ? "never verified" : robot.closer.records().back().reason);
  const Pose T_before = robot.map.keyframes().poses()[1].T_map_body;
  robot.map.apply(*correction);
  const KeyframeGraph& keyframes = robot.map.keyframes();
  const Pose& T_fragment = keyframes.poses()[3].T_map_body;
  EXPECT_LT(T_fragment.translation().norm(), 0.1);
  EXPECT_LT(turnOf(T_fragment), 1 * kDegree);
  const Vec3 second = keyframes.poses()[4].T_map_body.translation();  // which goes along
  EXPECT_LT((second - Vec3(0, 0, 2)).norm(), 0.1);
  EXPECT_LT((keyframes.poses()[1].T_map_body.translation() - T_before.translation()).norm(), 0.05) << "the map stays";
  EXPECT_EQ(keyframes.fragments(), std::vector<KeyframeId>(keyframes.poses().size(), 0));
}

TEST(LoopCloser, AFragmentInAnUnknownPlaceStaysWhereItIs) {
  const Pose offset = frame(150, Vec3(60, -25, 0));
  Doubt robot;
  const Pose start = Pose::Identity();
  robot.keyframe(start, 0, &start);
  stepOf(robot.closer, robot.map);
  robot.world = randomWorld(2);  // elsewhere
  MapUpdate update;
  update.keyframe = NewKeyframe{{3000, offset}, {{0, -1, offset, kAnywhere, kAnyTurn, false}}};
  update.created = nodesOfWorld(robot.world, offset.inverse(), 4);
  robot.map.apply(std::move(update));
  stepOf(robot.closer, robot.map);
  for (int n = 1; n <= 8; ++n) {
    EXPECT_FALSE(robot.goOn(n, offset));
  }
  EXPECT_GT(robot.verified(), 0) << "it was looked at";
  EXPECT_EQ(robot.map.keyframes().fragments().back(), 1);
}

TEST(LoopCloser, CanBeDestroyedWhileACandidateIsBeingVerified) {
  const Pose offset = frame(0, Vec3(1, 0, 0));
  for (const LoopTiming timing : {LoopTiming::kFixed, LoopTiming::kPrompt}) {
    auto left = std::make_unique<Doubt>(timing);
    left->comeBack(offset, 1);
    const Micros candidate_us = left->map.keyframes().poses().back().utime_us;
    EXPECT_EQ(left->verified(), 0);
    left.reset();  // returns, and the verification does not miss what is gone

    Doubt twin;  // one that goes on has the same candidate verified
    twin.verifyTwice(offset, 1);
    ASSERT_EQ(twin.verified(), 2);
    EXPECT_EQ(twin.closer.records()[0].now_us, candidate_us);
  }
}

TEST(LoopCloser, APromptVerificationIsTakenAsSoonAsItIsThere) {
  const Pose offset = frame(0, Vec3(1, 0, 0));
  Doubt prompt(LoopTiming::kPrompt), fixed;
  const auto expected = fixed.verifyTwice(offset, 1);
  ASSERT_TRUE(expected);
  prompt.comeBack(offset, 1);
  std::optional<MapCorrection> correction;
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(4);  // if nothing ever comes
  for (const int n : {1, 2, 3, 4}) {
    correction = prompt.goOn(n, offset);
    while (!correction && prompt.verified() < n / 2 && std::chrono::steady_clock::now() < end) {
      std::this_thread::yield();
      correction = stepOf(prompt.closer, prompt.map);  // nothing new, but the verification may be ready
    }
  }
  ASSERT_TRUE(correction) << "never verified";
  EXPECT_EQ(prompt.verified(), 2);
  EXPECT_EQ(prompt.closer.accepted(), 1);
  EXPECT_EQ(correction->moved.size() + 1, prompt.map.keyframes().poses().size()) << "all but the first";
  for (std::size_t k = 0; k < expected->moved.size(); ++k) {  // what both have; younger keyframes go along
    EXPECT_EQ(correction->moved[k].first, expected->moved[k].first);
    EXPECT_TRUE(correction->moved[k].second.isApprox(expected->moved[k].second, 1e-9));
  }
  prompt.map.apply(*correction);
  EXPECT_LT(prompt.map.keyframes().poses()[3].T_map_body.translation().norm(), 0.1);
}

TEST(LoopCloser, PromptVerificationsAreRightHoweverLateTheyCome) {
  Drive drive(1, drifting(), LoopTiming::kPrompt);
  drive.driveTo(kRound + 60);  // some come, how many depends on the machine
  if (drive.closer.accepted() > 0) {
    EXPECT_LT(drive.worstError(), 0.5);
  }
  EXPECT_EQ(static_cast<std::size_t>(drive.closer.accepted()), drive.corrections.size());
}

}  // namespace
}  // namespace hgg::loop_closer_test
