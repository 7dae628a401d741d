#include "correction/loop_closure.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "random_world.h"

namespace hgg::loop_closure_test {
namespace {

const LoopConfig kConfig = loopConfigOf(10, 0.4, 3);  // m, tiles and leaves outdoors

PlaceDescriptor describe(const Map& map, const Vec3& centre = Vec3::Zero()) {
  return describePlace(map, centre, kConfig.descriptor_radius);
}

TEST(LoopConfig, SizesOfAPlaceFollowTheTilesAndErrorsOfALoopTheLeaves) {
  const LoopConfig outdoors = loopConfigOf(10, 0.4, 3), indoors = loopConfigOf(3, 0.1, 1);
  EXPECT_DOUBLE_EQ(outdoors.place_radius, 40);
  EXPECT_DOUBLE_EQ(outdoors.descriptor_radius, 25);
  EXPECT_DOUBLE_EQ(outdoors.pass_distance, 10);
  EXPECT_DOUBLE_EQ(outdoors.prior_slack, 1.5);
  EXPECT_DOUBLE_EQ(outdoors.sigma, 0.08);
  EXPECT_NEAR(outdoors.agree_distance, 0.29, 0.002);
  EXPECT_DOUBLE_EQ(indoors.place_radius, 12);
  EXPECT_DOUBLE_EQ(indoors.descriptor_radius, 7.5);
  EXPECT_DOUBLE_EQ(indoors.pass_distance, 3);
  EXPECT_DOUBLE_EQ(indoors.sigma, 0.02);
  EXPECT_NEAR(indoors.agree_distance, 0.1, 0.002);
  EXPECT_EQ(outdoors.agree_turn, indoors.agree_turn);
}

TEST(PlaceDescriptor, IsTheSameHoweverTheMapIsTurnedAndMoved) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const World world = randomWorld(seed);
    const PlaceDescriptor expected = describe(mapOfWorld(world, Pose::Identity(), 1));
    for (const double yaw : {45.0, 180.0, -100.0}) {
      const Pose T_world_map = frame(yaw, Vec3(300, -20, 7), 2);
      const PlaceDescriptor turned = describe(mapOfWorld(world, T_world_map, 1), T_world_map.inverse().translation());
      EXPECT_GT(similarityOf(turned, expected), 0.999);
    }
  }
}

TEST(PlaceDescriptor, IsTheSameInWhateverOrderTheNodesCame) {
  std::mt19937 random(1);
  std::vector<MapNode> nodes = nodesOfWorld(randomWorld(1), Pose::Identity(), 1);
  const PlaceDescriptor expected = describe(mapOf(nodes));
  for (int run = 0; run < 10; ++run) {
    std::shuffle(nodes.begin(), nodes.end(), random);
    EXPECT_EQ(describe(mapOf(nodes)), expected);
  }
}

TEST(PlaceDescriptor, IsOfUnitLengthUnlessThereIsNothing) {
  const PlaceDescriptor place = describe(mapOfWorld(randomWorld(1), Pose::Identity(), 1));
  EXPECT_NEAR(similarityOf(place, place), 1, 1e-5);
  const PlaceDescriptor nothing = describe(Map{});
  EXPECT_EQ(similarityOf(nothing, nothing), 0);
  EXPECT_EQ(similarityOf(nothing, place), 0);
}

TEST(PlaceDescriptor, LooksMoreLikeItsOwnPlaceThanLikeAnother) {
  std::vector<PlaceDescriptor> first, second;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const World world = randomWorld(seed);
    first.push_back(describe(mapOfWorld(world, Pose::Identity(), seed)));
    second.push_back(describe(mapOfWorld(world, frame(33, Vec3(1, 0.5, 0)), 100 + seed)));
  }
  int right = 0;
  for (std::size_t a = 0; a < first.size(); ++a) {
    std::size_t best = 0;
    for (std::size_t b = 0; b < second.size(); ++b) {
      best = similarityOf(first[a], second[b]) > similarityOf(first[a], second[best]) ? b : best;
    }
    EXPECT_GT(similarityOf(first[a], second[a]), 0.9);
    right += best == a ? 1 : 0;
  }
  EXPECT_GE(right, 19);
}

TEST(PlaceDescriptor, TellsClassesApart) {
  std::mt19937 random(5);
  std::vector<MapNode> chairs, exchanged, tables, mixed;
  for (int n = 0; n < 30; ++n) {
    const Vec3 at = randomVector(random, 6);
    chairs.push_back(nodeAt(kChair, at));
    tables.push_back(nodeAt(kTable, at));
    mixed.push_back(nodeAt(n % 3 == 0 ? kChair : kTable, at));
    exchanged.push_back(nodeAt(n % 3 == 0 ? kTable : kChair, at));
  }
  EXPECT_LT(similarityOf(describe(mapOf(chairs)), describe(mapOf(tables))), 0.1);
  EXPECT_LT(similarityOf(describe(mapOf(mixed)), describe(mapOf(exchanged))), 0.8);
}

TEST(PlaceDescriptor, KnowsOnlyThingsThatAreBelievedInAndActive) {
  std::vector<MapNode> nodes = nodesOfWorld(randomWorld(1), Pose::Identity(), 1);
  const PlaceDescriptor expected = describe(mapOf(nodes));
  MapNode doubted = nodeAt(kTable, Vec3(1, 1, 0.5));
  doubted.classes = {};
  addViews(doubted.classes, {{kWall, 1000.0F}});
  doubted.belief.kappa = 1;
  ASSERT_FALSE(isConfirmed(doubted));
  nodes.push_back(doubted);
  EXPECT_EQ(describe(mapOf(nodes)), expected);
}

/// A robot that leaves the origin, drives far away and comes back: a map in which the parts do not meet.
struct Revisit {
  static constexpr double kReach = 0.5;
  Map map;
  std::vector<PlaceDescriptor> descriptors;

  Revisit() { map.setDriftReach(kReach); }

  /// A keyframe believed to be at `T`, with nodes of `world` as it sees them there: the world's frame is at
  /// T_map_world.
  void see(const World& world, const Pose& T, const Pose& T_map_world, double sigma,
           const std::function<bool(const Vec3&)>& sees = {}) {
    MapUpdate update;
    update.keyframe = NewKeyframe{{1000 * (map.keyframes().last() + 1), T}, {}};
    if (map.keyframes().last() >= 0) {
      const Pose T_last_body = map.keyframes().poses().back().T_map_body.inverse() * T;
      update.keyframe->constraints = {{map.keyframes().last(), -1, T_last_body, sigma, 1e-4, false}};
    }
    const auto seed = static_cast<unsigned>(map.keyframes().poses().size() + 1);
    update.created = nodesOfWorld(world, T_map_world.inverse(), seed, sees);
    map.apply(std::move(update));
    map.setClassNames(kNames);
    descriptors.push_back(describePlace(map, T.translation(), kConfig.descriptor_radius));
  }
  /// Away and back: two keyframes 150 m from here. `sigma` is that of the whole way.
  void wander(double sigma) {
    see({}, frame(0, Vec3(150, 0, 0)), Pose::Identity(), sigma / std::sqrt(3.0));
    see({}, frame(0, Vec3(150, 10, 0)), Pose::Identity(), sigma / std::sqrt(3.0));
  }
  std::optional<LoopCandidate> candidate() const {
    LoopSearch search;
    const auto keyframes = findLoopKeyframes(map, descriptors, kConfig, search);
    return keyframes.empty() ? std::nullopt : cutLoopCandidate(map, keyframes.front(), kConfig);
  }
};

/// Seen from the origin, left, and seen again with an error of `drift`.
Revisit revisit(const World& before, const World& now, const Pose& drift, double sigma) {
  Revisit scene;
  scene.see(before, Pose::Identity(), Pose::Identity(), 0);
  scene.wander(sigma);
  scene.see(now, drift * frame(70, Vec3(1, 0.5, 0)), drift, sigma / std::sqrt(3.0));
  return scene;
}

TEST(FindLoopCandidate, NothingWhereAllIsActive) {
  const World world = randomWorld(1);
  EXPECT_FALSE(revisit(world, world, Pose::Identity(), 0.1).candidate());
  Revisit one;
  one.see(world, Pose::Identity(), Pose::Identity(), 0);
  EXPECT_FALSE(one.candidate());
}

TEST(FindLoopCandidate, NothingWhereDriftDoesNotReach) {
  const World world = randomWorld(1);
  Revisit scene;
  scene.see(world, Pose::Identity(), Pose::Identity(), 0);
  scene.wander(1);
  const Pose T = frame(0, Vec3(25, 0, 0));  // allowed are 3 m of drift and 10 m of distance between two passes
  scene.see(world, T, T, 0.6);
  EXPECT_FALSE(scene.candidate());
}

TEST(FindLoopCandidate, IsThePlaceWhereTheRobotMayBeAgain) {
  const World world = randomWorld(1);
  const Revisit scene = revisit(world, world, frame(2, Vec3(1, 0, 0)), 1);
  const auto candidate = scene.candidate();
  ASSERT_TRUE(candidate);
  EXPECT_EQ(candidate->before_id, 0);
  EXPECT_EQ(candidate->now_id, 3);
  EXPECT_EQ(candidate->keyframe_before.utime_us, 0);
  EXPECT_EQ(candidate->keyframe_now.utime_us, 3000);
  EXPECT_EQ(candidate->prior.T_a_b.matrix(), Pose::Identity().matrix());
  EXPECT_EQ(candidate->prior.centre_b, candidate->keyframe_now.T_map_body.translation());
  EXPECT_NEAR(candidate->prior.distance, 3 * 1 + 1.5, 0.2);
  for (const auto& [id, node] : candidate->before.nodes()) {
    EXPECT_FALSE(scene.map.isActive(*scene.map.find(id)));
  }
  for (const auto& [id, node] : candidate->now.nodes()) {
    EXPECT_TRUE(scene.map.isActive(*scene.map.find(id)));
  }
  EXPECT_EQ(candidate->before.nodes().size() + candidate->now.nodes().size(), scene.map.nodes().size());
}

TEST(FindLoopCandidate, WhereDriftIsLargeLikenessTellsPlacesApart) {
  for (const unsigned here : {1U, 2U}) {
    Revisit scene;
    scene.see(randomWorld(1), frame(0, Vec3(-25, 0, 0)), frame(0, Vec3(-25, 0, 0)), 0);
    scene.see(randomWorld(2), frame(0, Vec3(25, 0, 0)), frame(0, Vec3(25, 0, 0)), 0.01);
    scene.wander(15);
    const double x = here == 1 ? 5 : -5;  // rather by the other one
    scene.see(randomWorld(here), frame(0, Vec3(x, 0, 0)), frame(0, Vec3(x, 0, 0)), 10);
    const auto candidate = scene.candidate();
    ASSERT_TRUE(candidate);
    EXPECT_EQ(candidate->before_id, here == 1 ? 0 : 1);
  }
}

TEST(FindLoopCandidate, FewThingsAreNoPlace) {
  const World world = randomWorld(1), few = randomWorld(1, 3), four = randomWorld(1, 4);
  EXPECT_FALSE(revisit(few, world, Pose::Identity(), 1).candidate());
  EXPECT_FALSE(revisit(world, few, Pose::Identity(), 1).candidate());
  EXPECT_TRUE(revisit(four, four, Pose::Identity(), 1).candidate());
}

TEST(VerifyLoop, AcceptsARevisitWithAMetreOfDrift) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const World world = randomWorld(seed);
    const Revisit scene = revisit(world, world, frame(2, Vec3(0.8, -0.6, 0)), 0.7);
    const auto candidate = scene.candidate();
    ASSERT_TRUE(candidate);
    const LoopVerification found = verifyLoop(*candidate, {}, kConfig);
    EXPECT_TRUE(found.alignment.accepted) << found.alignment.reason;
    EXPECT_EQ(found.loop.a, 0);
    EXPECT_EQ(found.loop.b, 3);
    EXPECT_TRUE(found.loop.is_loop);
    const Vec6 error = localCoordinates(found.loop.T_a_b, frame(70, Vec3(1, 0.5, 0)));
    EXPECT_LT(error.head<3>().norm(), 0.05);
    EXPECT_LT(error.tail<3>().norm(), 0.3 * kDegree);
    EXPECT_GT(found.loop.sigma, error.head<3>().norm());
  }
}

TEST(VerifyLoop, RefusesAnotherPlace) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const Revisit scene = revisit(randomWorld(seed), randomWorld(seed + 100), Pose::Identity(), 1);
    const auto candidate = scene.candidate();
    ASSERT_TRUE(candidate);
    EXPECT_FALSE(verifyLoop(*candidate, {}, kConfig).alignment.accepted);
  }
}

TEST(VerifyLoop, RefusesWhatLiesBeyondWhatDriftAllows) {
  const World world = randomWorld(1);
  const Revisit far = revisit(world, world, frame(0, Vec3(6, 0, 0)), 0.7);
  auto candidate = far.candidate();
  ASSERT_TRUE(candidate);
  EXPECT_FALSE(verifyLoop(*candidate, {}, kConfig).alignment.accepted);
  candidate->prior.distance = 8;
  EXPECT_TRUE(verifyLoop(*candidate, {}, kConfig).alignment.accepted);
  candidate->prior.turn = 1e-6;
  EXPECT_FALSE(verifyLoop(*candidate, {}, kConfig).alignment.accepted);
}

/// A long hall of equal bays: two pillars, a lamp and a bench every 4 m between two walls.
World hallOfBays(int bays) {
  World world;
  for (int k = 0; k < bays; ++k) {
    const double x = 4 * (k - 0.5 * bays);
    world.things.push_back({kLamp, Vec3(x, -4, 1), 0.02 * Mat3::Identity()});
    world.things.push_back({kLamp, Vec3(x, 4, 1), 0.02 * Mat3::Identity()});
    world.things.push_back({kChair, Vec3(x + 1, -3, 0.4), 0.04 * Mat3::Identity()});
    world.things.push_back({kTable, Vec3(x + 2, 2.5, 0.5), 0.1 * Mat3::Identity()});
  }
  addWall(world, Vec3(-2 * bays, -5, 0), Vec3(4 * bays, 0, 0));
  addWall(world, Vec3(-2 * bays, 5, 0), Vec3(4 * bays, 0, 0));
  for (double x = -2 * bays + 0.5; x < 2 * bays; ++x) {
    for (double y = -4.5; y < 5; ++y) {
      world.stuff.push_back({kFloor, Vec3(x, y, 0), plate(Vec3::UnitZ(), 0.5)});
    }
  }
  return world;
}

TEST(VerifyLoop, NeverClosesToTheNextBay) {
  const World world = hallOfBays(30);
  const auto around = [](double x) { return [x](const Vec3& p) { return std::abs(p.x() - x) < 22; }; };
  int accepted = 0;
  for (const double sigma : {0.55, 0.8, 1.0}) {
    for (const double drift : {-1.0, -0.5, 0.0, 0.7, 1.0}) {
      Revisit scene;
      scene.see(world, Pose::Identity(), Pose::Identity(), 0, around(0));
      scene.wander(sigma);
      const Pose T_drift = frame(0.5, Vec3(drift, 0, 0)), T_now = frame(0, Vec3(3, 0, 0));
      scene.see(world, T_drift * T_now, T_drift, sigma / std::sqrt(3.0), around(3));
      const auto candidate = scene.candidate();
      ASSERT_TRUE(candidate);
      const LoopVerification found = verifyLoop(*candidate, {}, kConfig);
      if (found.alignment.accepted) {
        ++accepted;
        EXPECT_LT(localCoordinates(found.loop.T_a_b, T_now).head<3>().norm(), 0.3) << sigma << ", " << drift;
      }
    }
  }
  EXPECT_GE(accepted, 3);  // where drift leaves no doubt
}

}  // namespace
}  // namespace hgg::loop_closure_test
