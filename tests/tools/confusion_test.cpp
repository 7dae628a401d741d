#include "sim/confusion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "sim/labels.h"

namespace hgg::confusion_test {
namespace {

constexpr ClassId kCar = 10, kTrunk = 71, kRare = 13, kHouse = 50;
constexpr std::size_t kFrames = 2000;

/// 60 cars, 30 trunks, one bus that is not common, and a house.
struct Town {
  World world;
  std::size_t house = 0;
  std::vector<CloudPoint> surface;  // of the house, 40 m long

  Town() {
    const auto add = [&](ClassId label, bool thing) {
      return addObject(world, {.label = label, .thing = thing, .name = ""}, {});
    };
    for (int i = 0; i < 90; ++i) {
      add(i < 60 ? kCar : kTrunk, true);
    }
    add(kRare, true);
    house = add(kHouse, false);
    for (int i = 0; i < 400; ++i) {
      surface.push_back({0.1F * static_cast<float>(i) + 0.05F, 0.0F, 1.0F, kHouse, world.objects[house].id});
    }
  }
  auto mistakes(double share) const { return commonMistakes(world, surface, share, 1, kFrames); }
};

TEST(Confusion, ComesAtItsShareOfThingsAndOfStretchesOfStuff) {
  const Town town;
  std::map<bool, double> number;  // by whether it is a patch
  for (const auto& frame : town.mistakes(0.05)) {
    for (const Mistake& mistake : frame) {
      number[mistake.patch.has_value()] += 1;
    }
  }
  const double things = 91.0 * kFrames, stretches = 4.0 * kFrames;
  EXPECT_NEAR(number[false] / things, 0.05, 0.005);
  EXPECT_NEAR(number[true] / stretches, 0.05, 0.025);
}

TEST(Confusion, NamesOtherCommonClassesByHowManyThereAre) {
  const Town town;
  std::map<ClassId, std::map<ClassId, int>> named;  // by what it is
  for (const auto& frame : town.mistakes(0.1)) {
    for (const Mistake& mistake : frame) {
      ++named[town.world.objects[mistake.object].label][mistake.label];
    }
  }
  EXPECT_EQ(named[kCar].size(), 1u);
  EXPECT_EQ(named[kCar].count(kTrunk), 1u);
  EXPECT_EQ(named[kTrunk].count(kCar), 1u);
  EXPECT_EQ(named[kTrunk].count(kRare), 0u);
  ASSERT_EQ(named[kHouse].size(), 2u);
  EXPECT_GT(named[kHouse][kCar], named[kHouse][kTrunk]);
}

TEST(Confusion, LastsFiveToTwentyFrames) {
  const Town town;
  const auto by_frame = town.mistakes(0.02);
  std::map<std::size_t, std::size_t> since;
  std::multiset<std::size_t> lengths;
  for (std::size_t f = 0; f < by_frame.size(); ++f) {
    std::set<std::size_t> now;
    for (const Mistake& mistake : by_frame[f]) {
      now.insert(mistake.object);
      since.try_emplace(mistake.object, f);
    }
    for (auto it = since.begin(); it != since.end();) {
      if (!now.contains(it->first)) {
        lengths.insert(it->second == 0 ? kShortestMistake : f - it->second);  // those at the start are cut
        it = since.erase(it);
      } else {
        ++it;
      }
    }
  }
  ASSERT_GT(lengths.size(), 100u);
  EXPECT_GE(*lengths.begin(), std::size_t{kShortestMistake});
  // Two can follow each other; that is rare.
  EXPECT_GT(lengths.count(kLongestMistake), 0u);
  EXPECT_LT(std::distance(lengths.upper_bound(kLongestMistake), lengths.end()),
            static_cast<std::ptrdiff_t>(lengths.size() / 10));
}

TEST(Confusion, PatchesLieOnTheSurfaceAndAreOneToThreeMetresAcross) {
  const Town town;
  for (const auto& frame : town.mistakes(0.1)) {
    for (const Mistake& mistake : frame) {
      ASSERT_EQ(mistake.patch.has_value(), mistake.object == town.house);
      if (mistake.patch) {
        EXPECT_NEAR(mistake.patch->center.z(), 1.0, 1e-6);
        EXPECT_GE(mistake.patch->radius, 0.5);
        EXPECT_LE(mistake.patch->radius, 1.5);
      }
    }
  }
}

TEST(Confusion, WithoutAShareNothingIsTakenForAnything) {
  for (const auto& frame : Town().mistakes(0.0)) {
    EXPECT_TRUE(frame.empty());
  }
}

TEST(Confusion, ASegmenterNamesThePatchAndNothingBesideIt) {
  World world;
  addObject(world, {.label = kHouse, .thing = false, .name = ""}, {});
  RayGrid grid;
  grid.width = 5, grid.height = 1;
  Scan scan;
  for (int x = 0; x < grid.width; ++x) {
    grid.directions.push_back(Vec3(5.0, x - 2.0, 0.0).normalized());
    scan.range.push_back(static_cast<float>(Vec3(5.0, x - 2.0, 0.0).norm()));
    scan.object.push_back(0);
  }
  scan.true_range = scan.range;
  const Pose T_world_sensor(Eigen::Translation3d(0.0, 100.0, 0.0));
  const FrameMistakes mistakes{{{0, kTrunk, Patch{Vec3(5.0, 101.0, 0.0), 1.2}}}, {T_world_sensor}};
  std::vector<ClassId> names{kHouse};
  const LabelImage image = segment({&world, {}, {kHouse}, true}, grid, scan, names, {1, 1}, 1, mistakes);
  EXPECT_EQ(image.labels, (std::vector<ClassId>{kHouse, kHouse, kTrunk, kTrunk, kTrunk}));
  EXPECT_EQ(image.instances, (std::vector<std::uint32_t>(5, 0)));
}

TEST(Confusion, WholeObjectsAreRenamedAndPatchesKept) {
  std::vector<ClassId> names{kCar, kHouse};
  const std::vector<Mistake> mistakes{{0, kTrunk}, {1, kCar, Patch{Vec3::Zero(), 1.0}}};
  EXPECT_EQ(nameWholeObjects(mistakes, names).size(), 1u);
  EXPECT_EQ(names, (std::vector<ClassId>{kTrunk, kHouse}));
}

}  // namespace
}  // namespace hgg::confusion_test
