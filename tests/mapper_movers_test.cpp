#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "map/file.h"
#include "mapper.h"
#include "traffic_world.h"

namespace hgg::mapper_movers_test {
namespace {

/// What a drive along x said of what moves, and left.
struct Drive {
  Mapper mapper;
  std::vector<StepReport> reports;

  std::vector<Vec3> nodesOf(ClassId label) const {
    std::vector<Vec3> means;
    for (const auto& [id, node] : mapper.map().nodes()) {
      if (node.label == label && !node.stuff && isConfirmed(node)) {
        means.push_back(node.belief.mean);
      }
    }
    return means;
  }
  /// Frames that call something a mover.
  int told() const {
    return static_cast<int>(std::ranges::count_if(reports, [](const StepReport& r) { return !r.moving.empty(); }));
  }
};

Drive drive(const TrafficWorld& world, double speed, int frames, unsigned seed = 1, Config config = {}) {
  std::mt19937 random(seed);
  config.creation.beam_spacing_deg = TrafficWorld::kBeamSpacingDeg;
  Drive run{Mapper(config, trafficClasses()), {}};
  for (int k = 0; k < frames; ++k) {
    Pose T = Pose::Identity();
    T.translation() = Vec3(0.1 * speed * k, 0, 1.8);
    run.reports.push_back(run.mapper.step(world.frameAt(0.1 * k, T, random)));
  }
  run.mapper.finish();
  return run;
}

/// Parked cars along the way, a metre apart, and a long truck on the other side.
std::vector<TrafficBox> parked() {
  std::vector<TrafficBox> boxes;
  for (int k = 0; k < 4; ++k) {
    boxes.push_back({.centre = {8 + 5.2 * k, 4.5, 0.75}});
  }
  boxes.push_back({.half = {5, 1.2, 1.6}, .centre = {20, -5, 1.6}});
  return boxes;
}

TEST(Movers, ACarThatComesTowardsTheRobotIsToldOfWithItsVelocityAndLeavesNoNode) {
  const TrafficBox car{.centre = {45, 3.5, 0.75}, .velocity = {-8, 0, 0}};
  const Drive run = drive({{car}}, 3, 40);
  ASSERT_FALSE(run.reports[12].moving.empty()) << "it is seen from the first frame on";
  std::set<NodeId> ids;
  for (const StepReport& report : run.reports) {
    for (const Mover& mover : report.moving) {
      ids.insert(mover.id);
      EXPECT_EQ(mover.label, kCar);
    }
  }
  EXPECT_EQ(ids.size(), 1U);
  const Mover& mover = run.reports[30].moving.at(0);
  EXPECT_NEAR(mover.motion.velocity().x(), -8, 1.5);
  EXPECT_NEAR(mover.motion.velocity().y(), 0, 0.8);
  EXPECT_LE((mover.motion.position() - car.at(3.0)).head<2>().norm(), 2.1);
  EXPECT_TRUE(run.nodesOf(kCar).empty());
  EXPECT_EQ(run.mapper.map().find(mover.id), nullptr);
}

TEST(Movers, ACarThatDrivesAheadAndAPersonThatCrossesAreMovers) {
  const TrafficBox ahead{.centre = {12, 3, 0.75}, .velocity = {7, 0, 0}};
  const TrafficBox person{
      .label = kWalker, .half = {0.2, 0.25, 0.85}, .centre = {18, 9, 0.85}, .velocity = {0, -1.3, 0}};
  const Drive run = drive({{ahead, person}}, 2, 35);
  std::set<ClassId> labels;
  for (const Mover& mover : run.reports[24].moving) {
    labels.insert(mover.label);
  }
  EXPECT_EQ(labels, (std::set<ClassId>{kCar, kWalker}));
  EXPECT_TRUE(run.nodesOf(kCar).empty());
  EXPECT_TRUE(run.nodesOf(kWalker).empty());
}

/// Whether each box has a node with its middle in it.
void expectNodesIn(const std::vector<TrafficBox>& boxes, const std::vector<Vec3>& nodes) {
  for (const TrafficBox& box : boxes) {
    EXPECT_TRUE(std::ranges::any_of(nodes, [&](const Vec3& p) {
      return ((p - box.centre).cwiseAbs().array() < box.half.array() + 0.1).all();
    })) << box.centre.transpose();
  }
}

TEST(Movers, AParkedCarSeenFromAPassingRobotNeverMoves) {
  for (const double speed : {4.0, 10.0}) {
    const Drive run = drive({parked()}, speed, static_cast<int>(120 / speed));
    EXPECT_EQ(run.told(), 0) << speed << " m/s";
    expectNodesIn(parked(), run.nodesOf(kCar));
  }
}

TEST(Movers, PassParkedCarsWithoutTakingThemAlong) {
  std::vector<TrafficBox> boxes = parked();
  boxes.push_back({.centre = {50, 1.8, 0.75}, .velocity = {-9, 0, 0}});
  const Drive run = drive({boxes}, 2, 60);
  EXPECT_GT(run.told(), 20);
  const std::vector<Vec3> cars = run.nodesOf(kCar);
  expectNodesIn(parked(), cars);
  EXPECT_TRUE(std::ranges::none_of(cars, [](const Vec3& p) { return std::abs(p.y() - 1.8) < 1.2; })) << "on its way";
}

TEST(Movers, ACarThatLeavesItsPlaceLeavesNoNode) {
  const TrafficBox car{.centre = {12, 4.5, 0.75}, .velocity = {5, 0, 0}, .from_s = 2};
  const Drive run = drive({{car}}, 1, 60);
  EXPECT_TRUE(run.reports[15].moving.empty()) << "it still stands";
  EXPECT_FALSE(run.reports[45].moving.empty());
  EXPECT_TRUE(run.nodesOf(kCar).empty());
}

TEST(Movers, ACarThatStopsBecomesANode) {
  const TrafficBox car{.centre = {40, 3.5, 0.75}, .velocity = {-6, 0, 0}, .until_s = 4};
  const Drive run = drive({{car}}, 1, 95);
  EXPECT_FALSE(run.reports[35].moving.empty());
  EXPECT_TRUE(run.reports.back().moving.empty());
  const std::vector<Vec3> cars = run.nodesOf(kCar);
  ASSERT_EQ(cars.size(), 1U);
  EXPECT_LE((cars[0] - car.at(9)).norm(), 2.0);
}

TEST(Movers, EndWhenTheyAreOutOfView) {
  const TrafficBox car{.centre = {30, 3.5, 0.75}, .velocity = {20, 0, 0}};
  const Drive run = drive({{car}}, 1, 50);
  std::set<NodeId> told, stopped;
  for (const StepReport& report : run.reports) {
    for (const Mover& mover : report.moving) {
      told.insert(mover.id);
    }
    stopped.insert(report.stopped.begin(), report.stopped.end());
  }
  EXPECT_TRUE(run.reports.back().moving.empty());
  EXPECT_EQ(told, stopped);
}

TEST(Movers, AreNotKnownToAMapperThatIsBlindToMotion) {
  Config blind;
  blind.ablation.blind_to_motion = true;
  const Drive run = drive({{{.centre = {45, 3.5, 0.75}, .velocity = {-8, 0, 0}}}}, 3, 30, 1, blind);
  EXPECT_EQ(run.told(), 0);
  EXPECT_TRUE(run.mapper.movers().tracks.empty());
}

TEST(Movers, TheSameFramesGiveTheSameBytes) {
  const TrafficWorld world{{{.centre = {45, 3.5, 0.75}, .velocity = {-8, 0, 0}}, {.centre = {14, -4, 0.75}}}};
  const Drive a = drive(world, 3, 25), b = drive(world, 3, 25);
  EXPECT_EQ(encodeMap(a.mapper.map()), encodeMap(b.mapper.map()));
  EXPECT_EQ(a.reports.back().moving.size(), b.reports.back().moving.size());
}

}  // namespace
}  // namespace hgg::mapper_movers_test
