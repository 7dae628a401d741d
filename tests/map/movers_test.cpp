#include "map/movers.h"

#include <gtest/gtest.h>

#include "core/units.h"
#include "map/test_map.h"
#include "map/track_assignment.h"
#include "traffic_world.h"

namespace hgg::movers_test {
namespace {

LocalObject thingAt(ClassId label, const Vec3& p, double deviation = 0.5) {
  LocalObject object;
  object.label = label;
  object.belief = {p, deviation * deviation * Mat3::Identity(), 100};
  object.T_body_object.translation() = p;
  return object;
}

/// A mover of cars at `p`, last seen at time 0.
Track moverAt(NodeId id, const Vec3& p, const Vec3& velocity) {
  Track track;
  track.mover.id = id;
  track.mover.label = kCar;
  track.mover.views = 10;
  track.extent = 0.25 * Mat3::Identity();
  track.mover.motion = seenAt(p, 0.01 * Mat3::Identity(), 0.1 * Mat3::Identity());
  track.mover.motion.mean.tail<3>() = velocity;
  return track;
}

TEST(TakeMoving, TakesTheObjectWhereTheMoverIsExpectedOutOfGraphEdgesAndPairs) {
  Movers movers;
  movers.tracks = {moverAt(9, {5, 0, 0}, {10, 0, 0})};
  LocalGraph local;
  local.utime_us = 100'000;
  local.objects = {thingAt(kPole, {0, 9, 0}), thingAt(kCar, {6.1, 0, 0}), thingAt(kCar, {6, -9, 0})};
  local.edges = {{0, 1}, {0, 2}, {1, 2}};
  std::vector<ObjectPair> pairs{{0, 31, 0}, {1, 32, 0}, {2, 33, 0}};
  const auto taken = takeMoving(movers, local, pairs, Pose::Identity(), trafficClasses());
  ASSERT_EQ(taken.size(), 1U);
  EXPECT_EQ(taken[0].belief.mean.x(), 6.1);
  ASSERT_EQ(local.objects.size(), 2U);
  EXPECT_EQ(local.objects[1].belief.mean.y(), -9);
  EXPECT_EQ(local.edges, (std::vector<std::pair<int, int>>{{0, 1}}));
  ASSERT_EQ(pairs.size(), 2U);
  EXPECT_EQ(pairs[0].local, 0);
  EXPECT_EQ(pairs[1].local, 1);
  EXPECT_EQ(pairs[1].map, 33);
}

TEST(TakeMoving, LeavesTheParkedCarBesideToItsOwnTrack) {
  Movers movers;
  movers.tracks = {moverAt(9, {5, 0, 0}, {10, 0, 0}), moverAt(0, {6, 2, 0}, Vec3::Zero())};
  LocalGraph local;
  local.utime_us = 100'000;
  local.objects = {thingAt(kCar, {6, 2, 0})};  // the mover is hidden
  std::vector<ObjectPair> pairs;
  EXPECT_TRUE(takeMoving(movers, local, pairs, Pose::Identity(), trafficClasses()).empty());
  EXPECT_EQ(local.objects.size(), 1U);
}

TEST(TakeMoving, TakesPiecesUnderAWrongNameWithinTheMover) {
  Movers movers;
  movers.tracks = {moverAt(9, {5, 0, 0}, {10, 0, 0})};
  LocalGraph local;
  local.utime_us = 100'000;
  local.objects = {thingAt(kPole, {6.3, 0, 0}, 0.1), thingAt(kPole, {9, 0, 0}, 0.1)};
  std::vector<ObjectPair> pairs;
  EXPECT_EQ(takeMoving(movers, local, pairs, Pose::Identity(), trafficClasses()).size(), 1U);
  EXPECT_EQ(local.objects[0].belief.mean.x(), 9);
}

TEST(TakeMoving, TakesNothingWithoutMovers) {
  Movers movers;
  movers.tracks = {moverAt(0, {5, 0, 0}, Vec3::Zero())};
  LocalGraph local;
  local.objects = {thingAt(kCar, {5, 0, 0})};
  std::vector<ObjectPair> pairs{{0, 31, 0}};
  EXPECT_TRUE(takeMoving(movers, local, pairs, Pose::Identity(), trafficClasses()).empty());
  EXPECT_EQ(pairs.size(), 1U);
}

TEST(MoveAlong, MovesTracksAsACorrectionMovesTheRobot) {
  Movers movers;
  movers.tracks = {moverAt(9, {5, 0, 0}, {10, 0, 0})};
  movers.tracks[0].glimpses = {{0, {4, 0, 0}, {{Vec3(4, 0, 0), Mat3::Identity(), 3}}}};
  Pose T = Pose::Identity();
  T.linear() = Eigen::AngleAxisd(kPi / 2, Vec3::UnitZ()).toRotationMatrix();
  T.translation() = Vec3(0, 0, 1);
  moveAlong(movers, T);
  const Track& track = movers.tracks[0];
  EXPECT_LE((track.mover.motion.position() - Vec3(0, 5, 1)).norm(), 1e-12);
  EXPECT_LE((track.mover.motion.velocity() - Vec3(0, 10, 0)).norm(), 1e-12);
  EXPECT_LE((track.glimpses[0].leaves[0].mean - Vec3(0, 4, 1)).norm(), 1e-12);
  EXPECT_EQ(forgetMovers(movers), std::vector<NodeId>{9});
  EXPECT_TRUE(movers.tracks.empty());
}

}  // namespace
}  // namespace hgg::movers_test
