#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "map/file.h"
#include "mapper.h"
#include "small_world.h"
#include "test_scene.h"

namespace hgg::mapper_loop_test {
namespace {

constexpr double kRadius = 12;  // m, of the round
constexpr int kRound = 76;      // frames, one a metre
constexpr double kSight = 14;   // m

Pose turned(double yaw, const Vec3& t) {
  Pose T = Pose::Identity();
  T.linear() = Eigen::AngleAxisd(yaw, Vec3::UnitZ()).toRotationMatrix();
  T.translation() = t;
  return T;
}

/// On a circle around the origin.
Pose truthAt(int k) {
  const double angle = 2 * M_PI * k / kRound;
  return turned(angle + M_PI / 2, kRadius * Vec3(std::cos(angle), std::sin(angle), 0));
}

struct Thing {
  ClassId label = 0;
  Vec3 centre, half;
};

/// Cars and poles inside and outside of the circle, none near another.
std::vector<Thing> yard(unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Thing> things;
  while (things.size() < 36) {
    const double angle = uniform(random, -M_PI, M_PI),
                 r = things.size() % 3 == 0 ? uniform(random, 0, 8) : uniform(random, 16, 22);
    const Vec3 centre = r * Vec3(std::cos(angle), std::sin(angle), 0);
    const auto isNear = [&](const Thing& t) { return (t.centre - centre).head<2>().norm() < 4; };
    if (std::ranges::none_of(things, isNear)) {
      const bool is_car = things.size() % 2 == 0;
      things.push_back({is_car ? kCar : kPole, centre, is_car ? Vec3(1.6, 0.8, 0.7) : Vec3(0.1, 0.1, 1.4)});
    }
  }
  return things;
}

/// Rounds with an odometry that turns away a little at every step, and poses that are odometry's.
struct Rounds {
  std::vector<Thing> things = yard(1);
  std::mt19937 random{2};
  Mapper mapper;
  std::vector<StepReport> reports;
  Pose T_odom_body = truthAt(0);

  static Config config() {
    Config config;
    config.ablation.odometry_pose = true;
    config.correction.window = false;  // all of the drift is left to loops
    config.map.active_radius = 50;
    return config;
  }

  int first = 0;  // frame

  explicit Rounds(const Config& config = Rounds::config(), Map map = {})
      : mapper(config, testClasses(), std::move(map)) {}

  Frame frameAt(int k) {
    Frame frame;
    const Pose T_body_world = truthAt(k).inverse();
    const auto add = [&](int n, ClassId label, const Vec3& centre, const Vec3& half) {
      for (int i = 0; i < n; ++i) {
        frame.points.push_back(pointAt(T_body_world * (centre + half.cwiseProduct(randomVector(random, 1))), label));
      }
    };
    for (const Thing& t : things) {
      if ((t.centre - truthAt(k).translation()).norm() < kSight) {
        add(t.label == kCar ? 200 : 80, t.label, t.centre, t.half);
      }
    }
    add(800, kRoad, truthAt(k).translation() - Vec3(0, 0, 1), Vec3(8, 8, 0.02));
    frame.utime_us = 100'000 * (k + 1);
    frame.T_odom_body = T_odom_body;
    return frame;
  }

  const StepReport& step() {
    const int k = first + static_cast<int>(reports.size());
    if (k > 0) {
      T_odom_body = T_odom_body * truthAt(k - 1).inverse() * truthAt(k) * turned(0.05 * M_PI / 180, Vec3(0.004, 0, 0));
    }
    reports.push_back(mapper.step(frameAt(k)));
    return reports.back();
  }
};

struct Look {
  Vec3 mean;
  Mat3 cov;
  double kappa = 0;
  Eigen::Matrix4d T_map_object;
  std::int32_t views = 0;
  ClassWeights classes;
  std::string leaves;
  /// Whether `o` is the same thing, elsewhere maybe.
  bool isMoved(const Look& o) const {
    return kappa == o.kappa && views == o.views && classes == o.classes && leaves == o.leaves;
  }
  bool operator==(const Look& o) const {
    return mean == o.mean && cov == o.cov && T_map_object == o.T_map_object && isMoved(o);
  }
};

std::map<NodeId, Look> looksOf(const Map& map) {
  std::map<NodeId, Look> looks;
  for (const auto& [id, n] : map.nodes()) {
    const std::string leaves(reinterpret_cast<const char*>(leavesOf(n).data()), leavesOf(n).size() * sizeof(Leaf));
    looks[id] = {n.belief.mean, n.belief.cov,    n.belief.kappa, n.T_map_object.matrix(),
                 n.views,       n.classes.views, leaves};
  }
  return looks;
}

/// The delta of a step names what it has done: each node once, and nothing that is gone as changed or moved.
void expectNames(const MapDelta& delta, const std::map<NodeId, Look>& before, const std::map<NodeId, Look>& after) {
  EXPECT_TRUE(std::ranges::is_sorted(delta.changed));
  EXPECT_TRUE(std::ranges::is_sorted(delta.moved));
  EXPECT_TRUE(std::ranges::is_sorted(delta.removed));
  for (const auto& [id, look] : after) {
    const auto was = before.find(id);
    const bool has_moved = std::ranges::binary_search(delta.moved, id);
    if (was == before.end() || !(was->second == look)) {
      EXPECT_TRUE(has_moved || std::ranges::binary_search(delta.changed, id)) << id;
    }
    if (has_moved) {
      EXPECT_FALSE(std::ranges::binary_search(delta.changed, id)) << id;
      ASSERT_TRUE(was != before.end()) << id;
      EXPECT_TRUE(was->second.isMoved(look)) << id;
    }
  }
  for (const auto& [id, look] : before) {
    EXPECT_EQ(std::ranges::binary_search(delta.removed, id), !after.contains(id)) << id;
  }
  for (const auto& ids : {delta.changed, delta.moved}) {
    for (const NodeId id : ids) {
      EXPECT_TRUE(after.contains(id)) << id;
    }
  }
}

double worstError(const std::vector<StepReport>& reports, const KeyframeGraph* keyframes) {
  double worst = 0;
  for (std::size_t k = 0; k < reports.size(); ++k) {
    const StepReport& r = reports[k];
    const Pose T = keyframes == nullptr
                       ? r.T_map_body
                       : Pose(keyframes->poses()[static_cast<std::size_t>(r.keyframe)].T_map_body * r.T_keyframe_body);
    worst = std::max(worst, (T.translation() - truthAt(static_cast<int>(k)).translation()).norm());
  }
  return worst;
}

TEST(MapperLoop, ClosesARoundAndMovesPosesMapAndTrajectoryTogether) {
  Rounds rounds;
  std::int64_t revision = 0;
  bool corrected = false;
  while (rounds.reports.size() < kRound + 30 && !corrected) {
    const auto before = looksOf(rounds.mapper.map());
    const Pose T_last = rounds.reports.empty() ? truthAt(0) : rounds.reports.back().T_map_body;
    const StepReport& report = rounds.step();
    const Map& map = rounds.mapper.map();
    corrected = rounds.mapper.loops().accepted() > 0;
    expectNames(report.delta, before, looksOf(map));
    EXPECT_EQ(report.delta.revision, revision + 1) << "corrections are no revisions of their own";
    EXPECT_EQ(report.delta.revision, map.revision());
    revision = report.delta.revision;
    const Pose& T_map_keyframe = map.keyframes().poses()[static_cast<std::size_t>(report.keyframe)].T_map_body;
    EXPECT_TRUE((T_map_keyframe * report.T_keyframe_body).isApprox(report.T_map_body, 1e-9));
    EXPECT_TRUE((report.T_map_odom * rounds.T_odom_body).isApprox(report.T_map_body, 1e-9));
    if (!corrected) {
      EXPECT_LT((report.T_map_body.translation() - T_last.translation()).norm(), 1.2);
    }
  }
  ASSERT_TRUE(corrected) << (rounds.mapper.loops().records().empty() ? "never verified"
                                                                     : rounds.mapper.loops().records().back().reason);
  const double before = worstError(rounds.reports, nullptr);
  const double after = worstError(rounds.reports, &rounds.mapper.map().keyframes());
  EXPECT_GT(before, 0.6);
  EXPECT_LT(after, 0.5 * before);
  // The next pose goes on from the corrected one.
  const Pose T_last = rounds.reports.back().T_map_body;
  EXPECT_LT((rounds.step().T_map_body.translation() - T_last.translation()).norm(), 1.2);
}

/// Pairs of active things of one class that are nearer to each other than any two of the yard.
int doublesIn(const Map& map) {
  int doubles = 0;
  for (const auto& [id, node] : map.nodes()) {
    for (const NodeId other : map.near(node.belief.mean, 0.5)) {
      doubles += !node.stuff && map.isActive(node) && other > id && map.find(other)->label == node.label ? 1 : 0;
    }
  }
  return doubles;
}

TEST(MapperLoop, WhatALoopBringsTogetherIsOneThing) {
  Config config = Rounds::config();
  config.correction.drift_reach = 0.8;  // so that the loop wakes what lies around it
  Rounds rounds(config);
  const Map& map = rounds.mapper.map();
  std::vector<NodeId> asleep;
  while (rounds.reports.size() < kRound + 30 && rounds.mapper.loops().accepted() == 0) {
    EXPECT_EQ(doublesIn(map), 0);
    asleep.clear();
    for (const auto& [id, node] : map.nodes()) {
      if (!node.stuff && !map.isActive(node)) {
        asleep.push_back(id);
      }
    }
    rounds.step();
  }
  ASSERT_EQ(rounds.mapper.loops().accepted(), 1);
  const auto isAwake = [&](NodeId id) { return map.find(id) == nullptr || map.isActive(*map.find(id)); };
  EXPECT_GE(std::ranges::count_if(asleep, isAwake), 10);
  EXPECT_EQ(doublesIn(map), 0);
}

/// Rounds with the map's poses, that can be carried elsewhere while they are switched off.
struct Carried : Rounds {
  static Config config() {
    Config config = Rounds::config();
    config.ablation.odometry_pose = false;
    return config;
  }
  Carried() : Rounds(config()) {}

  /// Wakes up `frames` frames later and farther on, with odometry at zero.
  const StepReport& wakeUp(int frames) {
    first += frames;
    T_odom_body = Pose::Identity();
    Frame frame = frameAt(first + static_cast<int>(reports.size()));
    frame.odometry_restarted = true;
    reports.push_back(mapper.step(frame));
    return reports.back();
  }
  Vec3 error() const {
    return reports.back().T_map_body.translation() -
           truthAt(first + static_cast<int>(reports.size()) - 1).translation();
  }
};

TEST(MapperLoop, ARobotThatWakesUpElsewhereIsFoundAgainAndNothingIsThereTwice) {
  Carried robot;
  for (int k = 0; k < kRound + 15; ++k) {  // all around, and away from where odometry is zero
    robot.step();
    ASSERT_EQ(robot.reports.back().fragment, 0) << k;
  }
  const Pose T_map_odom = robot.reports.back().T_map_odom;
  const KeyframeId fragment = robot.wakeUp(25).fragment;
  EXPECT_GT(fragment, 0) << "a new fragment of map begins";
  int frames = 0;
  for (; frames < 2 * kRound && robot.reports.back().fragment != 0; ++frames) {
    robot.step();
  }
  ASSERT_EQ(robot.reports.back().fragment, 0)
      << (robot.mapper.loops().records().empty() ? "never verified" : robot.mapper.loops().records().back().reason);
  EXPECT_LT(robot.error().norm(), 0.5);
  EXPECT_FALSE(robot.reports.back().T_map_odom.isApprox(T_map_odom, 0.1)) << "odometry has its zero elsewhere now";
  EXPECT_EQ(doublesIn(robot.mapper.map()), 0);
  for (int k = 0; k < 5; ++k) {  // and goes on there
    robot.step();
    EXPECT_LT(robot.error().norm(), 0.5);
  }
  EXPECT_EQ(robot.mapper.map().keyframes().fragments().back(), 0);
}

TEST(MapperLoop, TwoRunsGiveTheSameBytes) {
  Rounds a, b;
  for (int k = 0; k < kRound + 20; ++k) {
    a.step();
    b.step();
  }
  EXPECT_GT(a.mapper.loops().accepted(), 0);
  EXPECT_EQ(a.mapper.loops().records().size(), b.mapper.loops().records().size());
  EXPECT_EQ(encodeMap(a.mapper.map()), encodeMap(b.mapper.map()));
}

TEST(MapperLoop, SwitchedOffNothingIsEverInactive) {
  Config off = Rounds::config(), far = off;
  off.correction.loop_closure = false;
  off.correction.drift_reach = 0.01;
  far.correction.drift_reach = 1000;
  Rounds without(off), unlimited(far);
  for (int k = 0; k < kRound + 20; ++k) {
    without.step();
    unlimited.step();
    for (const auto& [id, node] : without.mapper.map().nodes()) {
      ASSERT_TRUE(without.mapper.map().isActive(node));
    }
  }
  EXPECT_TRUE(without.mapper.loops().records().empty());
  EXPECT_EQ(without.mapper.loops().accepted() + without.mapper.loops().rejected(), 0);
  EXPECT_EQ(encodeMap(without.mapper.map()), encodeMap(unlimited.mapper.map()));
}

TEST(MapperLoop, EdgesOfWhatACorrectionMovedAreThoseOfTheWholeMap) {
  Rounds rounds;
  for (int k = 0; k < 60; ++k) {
    rounds.step();
  }
  std::vector<NodeId> ids;
  std::size_t inactive = 0;
  for (const auto& [id, node] : rounds.mapper.map().nodes()) {
    ids.push_back(id);
    inactive += rounds.mapper.map().isActive(node) ? 0 : 1;
  }
  EXPECT_GT(inactive, 5U);
  const ObjectGraph& graph = rounds.mapper.map().graph();
  EXPECT_EQ(graph.edgesOf(ids).size(), graph.edges().size());
  EXPECT_GE(graph.edges().size() + 1, graph.size()) << "it is connected";
}

/// With ground that is as dense as a LiDAR sees it: leaves of a few points do not hold a pose.
Frame smallWorldFrame(int i) {
  const OdometrySample odometry = SmallWorld::odometry(i);
  Frame frame{odometry.utime_us, odometry.T_odom_body, SmallWorld::points(i)};
  std::mt19937 random(static_cast<unsigned>(i));
  std::uniform_real_distribution<float> unit(-1, 1);
  for (int n = 0; n < 20'000; ++n) {
    frame.points.push_back({30 * unit(random), 6 * unit(random), -1.5F + 0.02F * unit(random), 0, 40});
  }
  return frame;
}

TEST(MapperResume, AStoredMapIsUsableAtOnceWhereverTheRobotStartsInIt) {
  Mapper first({}, ClassTable::builtin());
  for (int i = 0; i < 70; ++i) {
    first.step(smallWorldFrame(i));
  }
  const std::size_t nodes = first.map().nodes().size();
  for (const int start : {0, 30, 69}) {
    auto stored = decodeMap(encodeMap(first.map()));
    ASSERT_TRUE(stored) << stored.error;
    Mapper second({}, ClassTable::builtin(), std::move(stored->map));
    second.startAt(smallWorldFrame(start).T_odom_body);
    for (int i = start; i >= 0 && i > start - 5; --i) {
      second.step(smallWorldFrame(i));
      for (const auto& [id, node] : second.map().nodes()) {
        const bool is_near = (node.belief.mean - Vec3(i, 0, 0)).norm() < 20;
        EXPECT_TRUE(!is_near || second.map().isActive(node)) << "node " << id << " at " << node.belief.mean.transpose();
      }
    }
    EXPECT_EQ(second.map().nodes().size(), nodes) << "from " << start;
  }
}

double worstKeyframe(const KeyframeGraph& keyframes) {
  double worst = 0;
  for (const TimedPose& k : keyframes.poses()) {
    const Pose T_true = truthAt(static_cast<int>(k.utime_us / 100'000) - 1);
    worst = std::max(worst, (k.T_map_body.translation() - T_true.translation()).norm());
  }
  return worst;
}

/// Rounds that end while a candidate is being verified that will turn out to be a loop.
Rounds endedWhileVerifying() {
  Rounds whole;
  while (whole.mapper.loops().accepted() == 0 && whole.reports.size() < kRound + 30) {
    whole.step();
  }
  const auto candidate = std::ranges::find_if(
      whole.reports, [&](const StepReport& r) { return r.utime_us == whole.mapper.loops().records().back().now_us; });
  Rounds rounds;
  while (rounds.reports.size() < static_cast<std::size_t>(candidate - whole.reports.begin()) + 2) {
    rounds.step();
  }
  return rounds;
}

TEST(MapperLoop, WhatIsStillBeingVerifiedAtTheEndOfADriveIsNotLost) {
  Rounds rounds = endedWhileVerifying();
  EXPECT_EQ(rounds.mapper.loops().accepted(), 0);
  const double before = worstKeyframe(rounds.mapper.map().keyframes());
  rounds.mapper.finish();
  EXPECT_EQ(rounds.mapper.loops().accepted(), 1);
  EXPECT_GT(before, 0.6);
  EXPECT_LT(worstKeyframe(rounds.mapper.map().keyframes()), 0.5 * before);
  const std::string bytes = encodeMap(rounds.mapper.map());
  rounds.mapper.finish();
  EXPECT_EQ(encodeMap(rounds.mapper.map()), bytes) << "twice is once";
}

TEST(MapperResume, AMapWithALoopOpenIsNotConstrainedToBothOfItsEnds) {
  const Rounds before = endedWhileVerifying();
  auto stored = decodeMap(encodeMap(before.mapper.map()));
  ASSERT_TRUE(stored) << stored.error;
  Config config = Rounds::config();
  config.ablation.odometry_pose = false;
  Rounds resumed(config, std::move(stored->map));
  resumed.first = static_cast<int>(before.reports.size());
  resumed.T_odom_body = before.T_odom_body;
  resumed.mapper.startAt(before.T_odom_body);
  const double worst = worstKeyframe(resumed.mapper.map().keyframes());
  EXPECT_GT(worst, 0.6);
  for (int k = 0; k < 60; ++k) {
    resumed.step();
  }
  EXPECT_GE(resumed.mapper.loops().accepted(), 1);
  EXPECT_LT(worstKeyframe(resumed.mapper.map().keyframes()), 0.5 * worst);
}

}  // namespace
}  // namespace hgg::mapper_loop_test
