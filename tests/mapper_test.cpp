#include "mapper.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "alignment/places.h"
#include "core/neighborhood.h"
#include "map/file.h"
#include "test_scene.h"

namespace hgg::mapper_test {
namespace {

struct Thing {
  ClassId label = 0;
  Vec3 centre, half;
};

/// Three parked cars and two poles along a road, map frame.
const std::vector<Thing>& things() {
  static const std::vector<Thing> kThings{{kCar, {6, 4, 0.8}, {2.1, 0.9, 0.7}},
                                          {kCar, {13, 4, 0.8}, {2.1, 0.9, 0.7}},
                                          {kCar, {10, -5, 0.8}, {0.9, 2.1, 0.7}},
                                          {kPole, {3, -4, 1.5}, {0.1, 0.1, 1.5}},
                                          {kPole, {16, -4, 1.5}, {0.1, 0.1, 1.5}}};
  return kThings;
}

/// The robot drives along x, turning its head.
Pose poseAt(int k) {
  Pose T = Pose::Identity();
  T.linear() = Eigen::AngleAxisd(0.3 * std::sin(k), Vec3::UnitZ()).toRotationMatrix();
  T.translation() = Vec3(1.5 * k, 0, 1.2);
  return T;
}

Frame frameAt(int k, std::mt19937& random) {
  Frame map_frame;
  for (const Thing& t : things()) {
    addBox(map_frame, random, 1500, t.label, t.centre, t.half);
  }
  addBox(map_frame, random, 4000, kRoad, Vec3(10, 0, 0), Vec3(14, 7, 0.02));
  Frame frame;
  frame.utime_us = 100000 * k;
  frame.T_odom_body = poseAt(k);
  for (const Point& p : map_frame.points) {
    frame.points.push_back(pointAt(frame.T_odom_body.inverse() * Vec3(p.x, p.y, p.z), p.label));
  }
  return frame;
}

std::vector<Frame> drive(unsigned seed, int frames) {
  std::mt19937 random(seed);
  std::vector<Frame> all;
  for (int k = 0; k < frames; ++k) {
    all.push_back(frameAt(k, random));
  }
  return all;
}

Mapper mapped(const std::vector<Frame>& frames) {
  Mapper mapper({}, testClasses());
  for (const Frame& frame : frames) {
    mapper.step(frame);
  }
  return mapper;
}

TEST(Mapper, SeesEachObjectOnceAndWhereItIs) {
  const Mapper mapper = mapped(drive(1, 12));
  std::size_t found = 0;
  for (const auto& [id, node] : mapper.map().nodes()) {
    found += node.stuff ? 0 : 1;
  }
  EXPECT_EQ(found, things().size());
  for (const Thing& thing : things()) {
    const std::vector<NodeId> ids = mapper.map().near(thing.centre, 0.15);
    ASSERT_EQ(ids.size(), 1U) << "at " << thing.centre.transpose();
    const MapNode& node = *mapper.map().find(ids[0]);
    EXPECT_EQ(node.label, thing.label);
    EXPECT_EQ(node.views, 12);
    EXPECT_EQ(node.belief.kappa, 12 * 1500);
    // A uniform box has the variance half^2 / 3 along each axis.
    EXPECT_LE((node.belief.cov.diagonal() - thing.half.cwiseAbs2() / 3).norm(), 0.03);
    EXPECT_GT(leavesOf(node).size(), 1U);
  }
}

TEST(Mapper, RoadIsATileANodeAndItsPointsAreAllThere) {
  const Mapper mapper = mapped(drive(2, 6));
  double points = 0;
  std::set<Tile> tiles;
  for (const auto& [id, node] : mapper.map().nodes()) {
    if (node.stuff) {
      EXPECT_EQ(node.label, kRoad);
      EXPECT_TRUE(tiles.insert(node.tile).second);
      points += node.belief.kappa;
    }
  }
  EXPECT_EQ(tiles.size(), 9U);  // x from -4 to 24 and y from -7 to 7 in tiles of 10 m, one of them around the origin
  EXPECT_LE(points, 6 * 4000);
  EXPECT_GE(points, 6 * 3900);  // a few lie within range_min
}

TEST(Mapper, TwoRunsGiveTheSameBytes) {
  const Mapper a = mapped(drive(3, 10)), b = mapped(drive(3, 10));
  EXPECT_EQ(encodeMap(a.map()), encodeMap(b.map()));
  const Mapper other = mapped(drive(4, 10));
  EXPECT_NE(encodeMap(a.map()), encodeMap(other.map()));
}

TEST(Mapper, AFrameWithoutPointsIsAFrame) {
  Mapper mapper = mapped(drive(5, 3));
  const Map before = mapper.map();
  Frame empty;
  empty.utime_us = 999;
  empty.T_odom_body = poseAt(4);
  const StepReport report = mapper.step(empty);
  EXPECT_EQ(report.utime_us, 999);
  EXPECT_EQ(report.points, 0U);
  EXPECT_TRUE(report.delta.removed.empty());
  ASSERT_EQ(mapper.map().nodes().size(), before.nodes().size());
  for (const auto& [id, node] : mapper.map().nodes()) {  // correction may refine its leaves
    EXPECT_EQ(node.views, before.find(id)->views);
    EXPECT_EQ(node.belief.kappa, before.find(id)->belief.kappa);
  }
  EXPECT_EQ(Mapper({}, testClasses()).step(Frame{}).points, 0U);
}

TEST(Mapper, ReportsWhatAStepDid) {
  std::mt19937 random(6);
  Frame frame = frameAt(3, random);
  const std::size_t good = frame.points.size();
  for (int k = 0; k < 7; ++k) {
    frame.points.push_back({std::numeric_limits<float>::quiet_NaN(), 0, 0, 0, kCar});
  }
  for (int k = 0; k < 5; ++k) {
    frame.points.push_back({5, 0, 0, 0, 4711});
  }
  Mapper mapper({}, testClasses());
  const StepReport report = mapper.step(frame);
  EXPECT_EQ(report.utime_us, frame.utime_us);
  EXPECT_EQ(report.nonfinite_points, 7U);
  EXPECT_EQ(report.unknown_labels, 5U);
  EXPECT_LE(report.points, good);
  EXPECT_GE(report.points, good - 100);
  EXPECT_EQ(report.T_map_body.matrix(), frame.T_odom_body.matrix());
  EXPECT_TRUE(report.T_map_odom.isApprox(Pose::Identity(), 1e-12));
  EXPECT_EQ(report.delta.revision, 1);
  EXPECT_EQ(report.delta.changed.size(), mapper.map().nodes().size());
}

TEST(Mapper, TimesItsStagesInTheOrderOfThePipeline) {
  std::mt19937 random(7);
  const StepReport report = Mapper({}, testClasses()).step(frameAt(0, random));
  std::vector<std::string> names;
  for (const auto& [name, ms] : report.stage_ms) {
    names.push_back(name);
    EXPECT_GE(ms, 0);
  }
  EXPECT_EQ(names, (std::vector<std::string>{"creation", "alignment", "movers", "update", "correction"}));
}

TEST(Mapper, TheMapCarriesTheClassNames) {
  const auto names = Mapper({}, testClasses()).map().classNames();
  EXPECT_EQ(names.at(kCar), "car");
  EXPECT_EQ(names.at(kRoad), "road");
}

TEST(Mapper, GoingOnFromAFileSeesTheSameObjects) {
  const std::vector<Frame> frames = drive(8, 10);
  const Mapper whole = mapped(frames);
  const Mapper first = mapped({frames.begin(), frames.begin() + 5});
  const auto stored = decodeMap(encodeMap(first.map()));
  ASSERT_TRUE(stored) << stored.error;
  Mapper second({}, testClasses(), stored->map);
  second.startAt(frames[5].T_odom_body);
  for (auto it = frames.begin() + 5; it != frames.end(); ++it) {
    second.step(*it);
  }
  EXPECT_EQ(second.map().revision(), whole.map().revision());
  EXPECT_EQ(second.map().keyframes().poses().size(), whole.map().keyframes().poses().size());
  ASSERT_EQ(second.map().nodes().size(), whole.map().nodes().size());
  for (const auto& [id, node] : whole.map().nodes()) {
    const MapNode* resumed = second.map().find(id);
    ASSERT_NE(resumed, nullptr) << id;
    EXPECT_NEAR(resumed->belief.kappa, node.belief.kappa, 0.02 * node.belief.kappa);
    EXPECT_LE((resumed->belief.mean - node.belief.mean).norm(), 0.05);  // where the pose is known from is forgotten
    EXPECT_EQ(resumed->views, node.views);
  }
}

TEST(Mapper, MapsFarFromTheOriginOfItsOdometry) {
  Mapper mapper({}, testClasses());
  Pose T_far = Pose::Identity();
  T_far.translation() = Vec3(3e5, -5e6, 200);  // a UTM-like frame
  for (Frame frame : drive(9, 6)) {
    frame.T_odom_body = T_far * frame.T_odom_body;
    mapper.step(frame);
  }
  for (const Thing& thing : things()) {
    const std::vector<NodeId> ids = mapper.map().near(T_far * thing.centre, 0.1);
    ASSERT_EQ(ids.size(), 1U);
    EXPECT_LE((mapper.map().find(ids[0])->belief.cov.diagonal() - thing.half.cwiseAbs2() / 3).norm(), 0.05);
  }
}

TEST(Mapper, KeepsTheGraphOfItsMapAndThatOfAMapItGoesOnFrom) {
  const Mapper mapper = mapped(drive(10, 4));
  std::vector<NodeId> ids;
  std::vector<Vec3> means;
  for (const auto& [id, node] : mapper.map().nodes()) {
    ids.push_back(id);
    means.push_back(node.belief.mean);
  }
  std::vector<std::pair<NodeId, NodeId>> expected, actual;
  for (const auto& [a, b] : relativeNeighborhood(means)) {
    expected.emplace_back(ids[static_cast<std::size_t>(a)], ids[static_cast<std::size_t>(b)]);
  }
  for (const Edge& e : mapper.map().graph().edges()) {
    actual.emplace_back(e.a, e.b);
    EXPECT_LT(e.a, e.b);
    EXPECT_TRUE(e.weight >= 0 && e.weight <= 1) << e.weight;
  }
  EXPECT_EQ(actual, expected);
  const std::string bytes = encodeMap(mapper.map());
  EXPECT_EQ(encodeMap(Mapper({}, testClasses(), decodeMap(bytes)->map).map()), bytes);
}

/// As with quaternions in another order. Nothing is known yet of how the robot moves, so that only the map can tell.
TEST(Mapper, OdometryThatSaysBackwardsFromTheStartIsOverruledByTheMap) {
  align_test::Place place = align_test::carPark();
  Config config;
  config.creation.beam_spacing_deg = 0.2;
  Mapper mapper(config, testClasses());
  for (int k = 0; k < 12; ++k) {
    const double way = 0.5 * k;
    Frame frame = place.seenFrom(align_test::at(-3 + way, 0), 100'000 * (k + 1));
    frame.T_odom_body = align_test::at(-3 - way, 0);
    const StepReport report = mapper.step(frame);
    EXPECT_NEAR(report.T_map_body.translation().x(), -3 + way, 0.05) << "frame " << k;
  }
}

TEST(ExplainMismatch, AMapOfOtherTilesOrKindsCannotGoOn) {
  const ClassTable classes = ClassTable::builtin();
  Config config;
  MapNode road;
  road.id = 1, road.label = 40, road.stuff = true;
  Map map = Map::restore({road}, {}, {}, 1);
  map.setTileSize(config.creation.tile_size);
  EXPECT_EQ(explainMismatch(map, config, classes), "");
  map.setTileSize(3);
  EXPECT_NE(explainMismatch(map, config, classes).find("tile_size"), std::string::npos);
  road.stuff = false;
  Map other = Map::restore({road}, {}, {}, 1);
  other.setTileSize(config.creation.tile_size);
  EXPECT_NE(explainMismatch(other, config, classes).find("'road'"), std::string::npos);
}

}  // namespace
}  // namespace hgg::mapper_test
