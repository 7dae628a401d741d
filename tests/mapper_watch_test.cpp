#include <gtest/gtest.h>

#include <algorithm>

#include "mapper.h"
#include "traffic_world.h"

namespace hgg::mapper_watch_test {
namespace {

constexpr int kFrames = 3000;  // five minutes

/// A pole, a parked car, one person who waits for a minute before leaving, and others who walk by, one every 12 s.
TrafficWorld squareWithPeople() {
  TrafficWorld world;
  world.columns = 260;
  world.boxes = {{.label = kPole, .half = {0.1, 0.1, 1.5}, .centre = {5, 9, 1.5}}, {.centre = {-8, -4, 0.75}}};
  const Vec3 person(0.25, 0.25, 0.85);
  world.boxes.push_back(
      {.label = kWalker, .half = person, .centre = {4, -5, 0.85}, .velocity = {1.2, 0, 0}, .from_s = 60});
  for (int k = 0; k < 25; ++k) {
    const double side = k % 2 == 0 ? 1 : -1, y = 3 + k % 5;
    world.boxes.push_back({.label = kWalker,
                           .half = person,
                           .centre = {-70 * side, y, 0.85},
                           .velocity = {1.5 * side, 0, 0},
                           .from_s = 12.0 * k - 40});
  }
  return world;
}

TEST(LongWatch, OfPeopleWhoPassNobodyBecomesFurnitureAndNothingGrows) {
  const TrafficWorld world = squareWithPeople();
  std::mt19937 random(1);
  Config config;
  config.creation.beam_spacing_deg = TrafficWorld::kBeamSpacingDeg;
  Mapper mapper(config, trafficClasses());
  Pose T = Pose::Identity();
  T.translation() = Vec3(0, 0, 1.8);
  std::size_t leaves = 0;
  double megabytes = 0;
  for (int k = 0; k < kFrames; ++k) {
    mapper.step(world.frameAt(0.1 * k, T, random));
    if (k == kFrames / 2) {
      leaves = mapper.map().leafCount(), megabytes = mapper.map().megabytes();
    }
  }
  EXPECT_LE(mapper.map().leafCount(), leaves + leaves / 10);
  EXPECT_LE(mapper.map().megabytes(), 1.1 * megabytes);
  EXPECT_EQ(mapper.map().keyframes().poses().size(), 1U);
  mapper.finish();
  int poles = 0, cars = 0;
  for (const auto& [id, node] : mapper.map().nodes()) {
    if (!node.stuff && isConfirmed(node)) {
      poles += node.label == kPole ? 1 : 0, cars += node.label == kCar ? 1 : 0;
      EXPECT_NE(node.label, kWalker) << node.belief.mean.transpose();
    }
  }
  EXPECT_EQ(poles, 1);
  EXPECT_EQ(cars, 1);
}

}  // namespace
}  // namespace hgg::mapper_watch_test
