#include "alignment/recovery.h"

#include <gtest/gtest.h>

#include "alignment/places.h"
#include "creation/object_graph.h"
#include "mapper.h"

namespace hgg::recovery_test {
namespace {

using align_test::at;
using align_test::carPark;
using align_test::Place;

const SearchReach kReach{4.8, 20 * kDegree};
constexpr double kLeastShare = 0.5;

Config config() {
  Config config;
  config.creation.beam_spacing_deg = 0.2;
  return config;
}

Mapper mapOf(Place& place) {
  Mapper mapper(config(), testClasses());
  for (int i = 0; i < 5; ++i) {
    mapper.step(place.seenFrom(at(-0.8 + 0.2 * i, 0), 100'000 * (i + 1)));
  }
  return mapper;
}

std::optional<Recovery> recovered(const Mapper& mapper, const Frame& frame, const std::vector<Pose>& guesses,
                                  double least_share = kLeastShare) {
  return recover(frame, mapper.map(), guesses, kReach, least_share, testClasses(), config());
}

void expectAt(const std::optional<Recovery>& found, const Pose& T_true) {
  ASSERT_TRUE(found);
  const Pose off = T_true.inverse() * found->alignment.pose.T_map_body;
  EXPECT_LT(off.translation().norm(), 0.05);
  EXPECT_LT(turnOf(off), 0.5 * kDegree);
  EXPECT_GT(found->alignment.fit.share(), kLeastShare);
}

TEST(Recover, BringsBackAFrameThatIsMetresAndDegreesOff) {
  Place place = carPark();
  const Mapper mapper = mapOf(place);
  const Pose T_true = at(0.3, 0.1, 2);
  const Frame frame = place.seenFrom(T_true, 900'000);
  for (const Pose& off : {at(1.5, 0, 8), at(-1, 1.1, -8), at(3, 0, -12)}) {
    expectAt(recovered(mapper, frame, {T_true * off}), T_true);
  }
}

TEST(Recover, CutsTheFrameWhereItIsFound) {
  Place place = carPark();
  const Mapper mapper = mapOf(place);
  const auto found = recovered(mapper, place.seenFrom(at(0.3, 0), 900'000), {at(1.8, 0, 8)});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->local.utime_us, 900'000);
  EXPECT_FALSE(found->alignment.pairs.empty());
  for (const ObjectPair& pair : found->alignment.pairs) {
    ASSERT_LT(static_cast<std::size_t>(pair.local), found->local.objects.size());
    EXPECT_EQ(found->local.objects[static_cast<std::size_t>(pair.local)].label, mapper.map().find(pair.map)->label);
  }
}

TEST(Recover, AGuessBeyondTheReachOfTheFirstOneIsTried) {
  Place place = carPark();
  const Mapper mapper = mapOf(place);
  const Pose T_true = at(0.3, 0.1, 2);
  const Frame frame = place.seenFrom(T_true, 900'000);
  const Pose far = T_true * at(0, 0, 90);
  expectAt(recovered(mapper, frame, {far, T_true * at(0.2, 0.1, 1)}), T_true);
  if (const auto alone = recovered(mapper, frame, {far})) {
    EXPECT_TRUE(areDistinctPoses(alone->alignment.pose.T_map_body, T_true));
  }
}

TEST(Recover, AnotherPlaceIsNotTakenForThisOne) {
  Place place = carPark(), poles(9), yard(10);
  for (int k = 0; k < 5; ++k) {
    poles.addBlock(kPole, Vec3(6 * std::cos(1.3 * k), 6 * std::sin(1.3 * k), -1), Vec3(0.2, 0.2, 3));
  }
  for (int k = 0; k < 6; ++k) {
    yard.addBlock(kCar, Vec3(9 * std::cos(1.05 * k), 9 * std::sin(1.05 * k), -1), Vec3(1.5, 1, 2.5));
  }
  const Mapper mapper = mapOf(place);
  EXPECT_FALSE(recovered(mapper, poles.seenFrom(at(0, 0), 900'000), {at(0.5, 0)}));
  EXPECT_FALSE(recovered(mapper, yard.seenFrom(at(0, 0), 900'000), {at(0.5, 0)}));
}

TEST(Recover, PlacesThatRepeatThemselvesAreNotTakenForEachOther) {
  Place row(4);
  row.addPatch(kRoad, Vec3(-20, -15, -1), Vec3(40, 0, 0), Vec3(0, 30, 0), 40);
  for (int k = -4; k <= 4; ++k) {  // one alike every 3 m
    row.addBlock(kPole, Vec3(3.0 * k, 4, -1), Vec3(0.2, 0.2, 3));
    row.addBlock(kPole, Vec3(3.0 * k, -4, -1), Vec3(0.2, 0.2, 3));
  }
  const Mapper mapper = mapOf(row);
  EXPECT_FALSE(recovered(mapper, row.seenFrom(at(0, 0), 900'000, 7), {at(1.5, 0)}));
}

TEST(Recover, AnEmptyMapHasNothingToFindItIn) {
  Place place = carPark();
  const Mapper nothing(config(), testClasses());
  EXPECT_FALSE(recovered(nothing, place.seenFrom(at(0, 0), 900'000), {at(1, 0)}));
}

TEST(IsFoundAt, TellsTheRightPoseFromOneThatIsMetresOff) {
  Place place = carPark();
  const Mapper mapper = mapOf(place);
  const Pose T_true = at(0.3, 0.1, 2);
  const Frame frame = place.seenFrom(T_true, 900'000);
  const Config c = config();
  for (const auto& [off, expected] : {std::pair(at(0, 0), true), {at(2.5, 0), false}, {at(-2, 1), false}}) {
    const Pose T = T_true * off;
    const LocalGraph local = createLocalGraph(frame, T, testClasses(), c);
    EXPECT_EQ(isFoundAt(T, local, mapper.map(), {4.8, 20 * kDegree}, c), expected) << T.translation().transpose();
  }
}

TEST(FitsClearlyBetter, IsATenthMoreOfTheLeavesOnTheMap) {
  EXPECT_TRUE(fitsClearlyBetter({200, 111}, {100, 100}));
  EXPECT_FALSE(fitsClearlyBetter({200, 109}, {100, 100}));
  EXPECT_FALSE(fitsClearlyBetter({0, 0}, {0, 0}));
}

}  // namespace
}  // namespace hgg::recovery_test
