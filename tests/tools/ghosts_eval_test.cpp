#include <gtest/gtest.h>

#include <map>

#include "eval/ghosts.h"

namespace hgg::ghosts_eval_test {
namespace {

constexpr ClassId kCar = 10, kHouse = 50, kTrunk = 71;
constexpr double kRadius = 1.5;

/// A car 4.4 m long along x, as its points spread.
Belief carAt(const Vec3& mean) { return {mean, Vec3(1.6, 0.3, 0.15).asDiagonal(), 1000}; }
Belief trunkAt(const Vec3& mean) { return {mean, Vec3(0.01, 0.01, 0.5).asDiagonal(), 300}; }

TruthObject truthCar(std::int64_t id, const Vec3& mean) { return {id, kCar, false, false, 9, carAt(mean)}; }
MappedObject car(NodeId id, const Vec3& mean) { return {id, kCar, false, carAt(mean)}; }
MappedObject trunk(NodeId id, const Vec3& mean) { return {id, kTrunk, false, trunkAt(mean)}; }

std::map<NodeId, Ghost> explained(const std::vector<MappedObject>& map, const std::vector<TruthObject>& truth,
                                  const std::vector<CloudPoint>& cloud = {}) {
  std::map<NodeId, Ghost> ghosts;
  for (const Ghost& ghost : explainGhosts(map, truth, evaluateObjects(map, truth, kRadius, {}), cloud, kRadius)) {
    ghosts[ghost.prediction] = ghost;
  }
  return ghosts;
}

/// A wall along x at y = 10, up to 5 m high.
std::vector<CloudPoint> wall() {
  std::vector<CloudPoint> cloud;
  for (int x = 0; x < 100; ++x) {
    for (int z = 0; z < 50; ++z) {
      cloud.push_back({0.1F * static_cast<float>(x), 10.0F, 0.1F * static_cast<float>(z), kHouse, 77});
    }
  }
  return cloud;
}

TEST(Twins, AreTwoNodesOfOneTrueThing) {
  const std::vector<TruthObject> truth{truthCar(1, Vec3::Zero()), truthCar(2, Vec3(10, 0, 0))};
  const std::vector<MappedObject> map{car(5, Vec3(0.2, 0, 0)), car(3, Vec3(-0.1, 0, 0)), car(4, Vec3(10, 0, 0))};
  const auto twins = findTwins(map, truth, kRadius);
  ASSERT_EQ(twins.size(), 1u);
  EXPECT_EQ(twins[0].a, 3);
  EXPECT_EQ(twins[0].b, 5);
  EXPECT_EQ(twins[0].truth, 1);
  EXPECT_NEAR(twins[0].distance, 0.3, 1e-12);
}

TEST(Twins, AreNeitherTwoNeighboursNorTwoClassesNorTwoGhosts) {
  const std::vector<TruthObject> truth{{1, kTrunk, false, false, 9, trunkAt(Vec3::Zero())},
                                       {2, kTrunk, false, false, 9, trunkAt(Vec3(0.4, 0, 0))}};
  const std::vector<MappedObject> map{trunk(1, Vec3::Zero()), trunk(2, Vec3(0.4, 0, 0)),  // two true ones
                                      car(3, Vec3(0.1, 0, 0)),                            // another class
                                      trunk(4, Vec3(50, 0, 0)), trunk(5, Vec3(50, 0, 0))};
  EXPECT_TRUE(findTwins(map, truth, kRadius).empty());
}

TEST(Ghosts, OnAThingThatHasItsNodeAreSecondOnes) {
  const std::vector<TruthObject> truth{truthCar(1, Vec3::Zero())};
  const auto ghosts = explained({car(1, Vec3::Zero()), car(2, Vec3(2.2, 0, 0)), car(3, Vec3(0, 3, 0))}, truth);
  ASSERT_EQ(ghosts.size(), 2u);
  EXPECT_EQ(ghosts.at(2).cause, GhostCause::kSecond) << "a piece of its end, farther off than the radius";
  EXPECT_EQ(ghosts.at(2).of, 1);
  EXPECT_EQ(ghosts.at(3).cause, GhostCause::kNothing) << "beside it";
}

TEST(Ghosts, OnTheTrackOfAMoverAreLeftByIt) {
  TruthObject mover = truthCar(1, Vec3(50, 0, 0));
  mover.dynamic = true;
  mover.belief.cov(0, 0) = 900;
  mover.track = {Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(8, 0, 0), Vec3(90, 0, 0), Vec3(94, 0, 0)};
  const auto ghosts = explained({car(1, Vec3(50, 0, 0)),  // set aside: it stands for the mover
                                 car(2, Vec3(5.5, 1, 0.4)), car(3, Vec3(30, 0, 0)), trunk(4, Vec3(2, 0.5, 0))},
                                {mover});
  ASSERT_EQ(ghosts.size(), 3u);
  EXPECT_EQ(ghosts.at(2).cause, GhostCause::kMover);
  EXPECT_EQ(ghosts.at(2).of, 1);
  EXPECT_EQ(ghosts.at(3).cause, GhostCause::kNothing) << "where it was not seen";
  EXPECT_EQ(ghosts.at(4).cause, GhostCause::kMover) << "under another name";
}

TEST(Ghosts, WhereAThingWasAreOfWhatIsGone) {
  TruthObject gone = truthCar(1, Vec3::Zero());
  gone.gone = true;
  const auto ghosts = explained({car(1, Vec3::Zero()), car(2, Vec3(0.5, 0, 0))}, {gone});
  ASSERT_EQ(ghosts.size(), 1u);
  EXPECT_EQ(ghosts.at(2).cause, GhostCause::kGone);
}

TEST(Ghosts, OnAnotherClassAreKnownByTheirLeavesAndTheCloud) {
  const std::vector<TruthObject> truth{{3, kTrunk, false, false, 9, trunkAt(Vec3(50, 0, 0))},
                                       truthCar(4, Vec3(0, -9, 0))};
  MappedObject on_wall = trunk(1, Vec3(5, 9.4, 2)),
               in_the_air = trunk(2, Vec3(5, 5, 2));  // the mean of a corner is off it
  on_wall.geometry = {trunkAt(Vec3(5, 10.1, 1)), trunkAt(Vec3(5, 9.95, 2)), trunkAt(Vec3(5, 7, 3))};
  in_the_air.geometry = {trunkAt(Vec3(5, 10.1, 1)), trunkAt(Vec3(5, 5, 2)), trunkAt(Vec3(5, 6, 3))};
  const auto ghosts = explained({on_wall, in_the_air, trunk(5, Vec3(0.3, -9, 0))}, truth, wall());
  ASSERT_EQ(ghosts.size(), 3u);
  EXPECT_EQ(ghosts.at(1).cause, GhostCause::kSurface);
  EXPECT_EQ(ghosts.at(1).of, 77);
  EXPECT_EQ(ghosts.at(2).cause, GhostCause::kNothing);
  EXPECT_EQ(ghosts.at(5).cause, GhostCause::kSurface) << "a true thing of another class, without a cloud";
  EXPECT_EQ(ghosts.at(5).of, 4);
}

TEST(Moving, IsCalledDynamicOrNotAndWhatStaysShouldNotBe) {
  TruthObject seen = truthCar(1, Vec3(50, 0, 0)), missed = truthCar(2, Vec3(50, 20, 0)), brief = missed;
  seen.dynamic = missed.dynamic = brief.dynamic = true;
  seen.frames = missed.frames = kSeenFrames;
  brief.id = 3, brief.frames = kSeenFrames - 1;
  seen.track = {Vec3(0, 0, 0), Vec3(4, 0, 0)};
  missed.track = brief.track = {Vec3(0, 20, 0), Vec3(4, 20, 0)};
  std::vector<MappedObject> map{car(1, Vec3(3.8, 0.2, 0)), car(2, Vec3(0, 40, 0)), car(3, Vec3(0, 60, 0)),
                                car(4, Vec3(1, 20, 0))};
  map[0].dynamic = map[1].dynamic = map[2].dynamic = true;
  const std::vector<TruthObject> truth{seen, missed, brief, truthCar(4, Vec3(0.1, 40, 0))};
  const MovingScore score = scoreMoving(map, truth, kRadius);
  EXPECT_EQ(score.truth, 2u);
  EXPECT_EQ(score.said, 1u);
  EXPECT_EQ(score.parked, std::vector<NodeId>{2});
  EXPECT_EQ(score.elsewhere, std::vector<NodeId>{3});
  const auto objects = evaluateObjects(map, truth, kRadius, {}).overall;
  EXPECT_EQ(objects.ghosts, std::vector<NodeId>{4}) << "not those that are said to move";
  EXPECT_EQ(objects.missed, std::vector<std::int64_t>{4}) << "the parked one has no node that stays";
}

/// A car that drives along y = `y`, seen in frames from `first` on.
TruthObject drivingCar(std::int64_t id, double y, std::int64_t first, std::int64_t frames) {
  TruthObject car = truthCar(id, Vec3(90, y, 0));
  car.dynamic = true;
  car.frames = frames;
  for (std::int64_t k = 0; k < frames; ++k) {
    car.track.emplace_back(static_cast<double>(k), y, 0);
    car.track_points.push_back(k == 0 ? 1 : 100);
    car.track_frames.push_back(first + k);
  }
  return car;
}

ToldMover toldFrom(NodeId id, const TruthObject& of, std::size_t from) {
  ToldMover told{id, of.label, {}, {}, {}};
  for (std::size_t k = from; k < of.track.size(); ++k) {
    told.places.push_back(of.track[k] + Vec3(0.4, 0.3, 0));
    told.frames.push_back(of.track_frames[k]);
  }
  return told;
}

TEST(Moving, WasToldOfInTimeOrLateOrNever) {
  const std::vector<TruthObject> truth{drivingCar(1, 0, 0, 20), drivingCar(2, 20, 5, 20), drivingCar(3, 40, 0, 20),
                                       drivingCar(4, 60, 0, 10), truthCar(5, Vec3(0, 80, 0))};
  ToldMover parked{103, kCar, {truth[4].belief.mean}, {}, {0}}, of_nothing{104, kCar, {Vec3(0, 100, 0)}, {}, {0}};
  std::vector<ToldMover> told{toldFrom(101, truth[0], 10), toldFrom(102, truth[1], 11), parked, of_nothing};
  const MovingScore score = scoreMoving(told, truth, kRadius);
  EXPECT_EQ(score.truth, 3u) << "one is seen in nine frames only, as one point makes no object";
  EXPECT_EQ(score.said, 2u);
  EXPECT_EQ(score.soon, 1u);
  EXPECT_EQ(score.parked, std::vector<NodeId>{103});
  EXPECT_EQ(score.elsewhere, std::vector<NodeId>{104});
  told[0].frames = told[1].frames = {};
  EXPECT_EQ(scoreMoving(told, truth, kRadius).said, 2u) << "without frames, by place";
}

TEST(Moving, AtAnotherTimeIsAnother) {
  const TruthObject early = drivingCar(1, 0, 0, 20), late = drivingCar(2, 0, 50, 20);
  const std::vector<TruthObject> truth{early, late};
  const std::vector<ToldMover> told{toldFrom(101, late, 3)};
  const MovingScore score = scoreMoving(told, truth, kRadius);
  EXPECT_EQ(score.said, 1u);
  EXPECT_EQ(score.soon, 1u);
  EXPECT_TRUE(score.parked.empty() && score.elsewhere.empty());
}

TEST(Ghosts, OfAMapWithoutAnyAreNone) {
  EXPECT_TRUE(explained({car(1, Vec3::Zero())}, {truthCar(1, Vec3::Zero())}).empty());
}

}  // namespace
}  // namespace hgg::ghosts_eval_test
