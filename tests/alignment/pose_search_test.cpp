#include "alignment/pose_search.h"

#include <gtest/gtest.h>

#include "alignment/places.h"
#include "creation/object_graph.h"
#include "mapper.h"

namespace hgg::pose_search_test {
namespace {

using align_test::at;
using align_test::carPark;
using align_test::Place;

constexpr double kRadius = 12, kLeafSize = 0.4, kCell = 1.5 * kLeafSize;  // m
const SearchReach kReach{4.8, 20 * kDegree};

Config config() {
  Config config;
  config.creation.beam_spacing_deg = 0.2;
  return config;
}

/// A place, its map, and a frame of it.
struct Search {
  Place place;
  Mapper mapper{config(), testClasses()};

  explicit Search(Place seen) : place(std::move(seen)) {
    for (int i = 0; i < 4; ++i) {
      mapper.step(place.seenFrom(at(-0.6 + 0.2 * i, 0), 100'000 * (i + 1), kRadius));
    }
  }
  /// Of a frame at `T_true` that is thought to be at `T_guess`.
  std::vector<Pose> poses(const Pose& T_true, const Pose& T_guess, std::size_t count = 4,
                          const SearchReach& reach = kReach) {
    const Frame frame = place.seenFrom(T_true, 900'000, kRadius);
    const LocalGraph local = createLocalGraph(frame, T_guess, testClasses(), config());
    return searchPoses(local, mapper.map(), T_guess, reach, kRadius, kLeafSize, count);
  }
};

/// Within a cell in x and y, and a step of yaw, which is one cell at the distance of the leaves.
void expectFound(const std::vector<Pose>& poses, const Pose& T_true) {
  ASSERT_FALSE(poses.empty());
  const Pose off = T_true.inverse() * poses.front();
  EXPECT_LT(std::abs(off.translation().x()), 1.01 * kCell);
  EXPECT_LT(std::abs(off.translation().y()), 1.01 * kCell);
  EXPECT_LT(turnOf(off), 5 * kDegree);
}

TEST(SearchPoses, FindsAFrameThatIsMetresAndDegreesOff) {
  Search search(carPark());
  const Pose T_true = at(0.3, 0.2, 3);
  for (const Pose& off : {at(2.4, 0, 10), at(-1.7, 1.7, -10), at(0, -2.4, 15), at(0, 0, 0)}) {
    expectFound(search.poses(T_true, T_true * off), T_true);
  }
}

TEST(SearchPoses, HeightRollAndPitchStayThoseOfTheGuess) {
  Search search(carPark());
  Pose T_guess = at(1.8, 0, 8);
  T_guess.translation().z() = 0.15;
  T_guess.rotate(Eigen::AngleAxisd(2 * kDegree, Vec3::UnitX()));
  const std::vector<Pose> poses = search.poses(at(0.3, 0), T_guess);
  ASSERT_FALSE(poses.empty());
  for (const Pose& T : poses) {
    EXPECT_DOUBLE_EQ(T.translation().z(), 0.15);
    EXPECT_LT((T.linear().row(2) - T_guess.linear().row(2)).norm(), 1e-9) << "the way of the vertical";
  }
}

TEST(SearchPoses, TheyAreDistinctAndNoMoreThanAskedFor) {
  Search search(carPark());
  for (const std::size_t count : {1U, 3U, 8U}) {
    const std::vector<Pose> poses = search.poses(at(0.3, 0), at(2, 0, 5), count);
    EXPECT_EQ(poses.size(), count);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      for (std::size_t j = i + 1; j < poses.size(); ++j) {
        EXPECT_TRUE(areDistinctPoses(poses[i], poses[j])) << i << " and " << j;
      }
    }
  }
}

TEST(SearchPoses, TheyLieWithinTheReach) {
  Search search(carPark());
  const Pose T_guess = at(2.4, 0, 10);
  const SearchReach reach{1, 4 * kDegree};
  for (const Pose& T : search.poses(at(0, 0), T_guess, 8, reach)) {
    const Vec3 off = T.translation() - T_guess.translation();
    EXPECT_LT(off.cwiseAbs().maxCoeff(), reach.distance + kCell);
    EXPECT_LT(turnOf(T_guess.inverse() * T), reach.turn + 5 * kDegree);
  }
}

TEST(SearchPoses, TwoSearchesFindTheSame) {
  Search a(carPark()), b(carPark());
  const auto from_a = a.poses(at(0.3, 0), at(2, 1, 8)), from_b = b.poses(at(0.3, 0), at(2, 1, 8));
  ASSERT_EQ(from_a.size(), from_b.size());
  for (std::size_t k = 0; k < from_a.size(); ++k) {
    EXPECT_EQ(from_a[k].matrix(), from_b[k].matrix());
  }
}

TEST(SearchPoses, LevelGroundTellsNothing) {
  Place field(2);
  field.addPatch(kRoad, Vec3(-25, -25, -1), Vec3(50, 0, 0), Vec3(0, 50, 0), 30);
  Search search(std::move(field));
  EXPECT_TRUE(search.poses(at(0, 0), at(1, 0)).empty());
  EXPECT_TRUE(searchPoses({}, search.mapper.map(), at(0, 0), kReach, kRadius, kLeafSize, 4).empty());
}

TEST(AreDistinctPoses, BeyondAMetreOrFiveDegrees) {
  const Pose T = at(100, -30, 70);
  EXPECT_FALSE(areDistinctPoses(T, T * at(0.7, 0.7, 4.9)));
  EXPECT_TRUE(areDistinctPoses(T, T * at(0.8, 0.8)));
  EXPECT_TRUE(areDistinctPoses(T, T * at(0, 0, 5.1)));
}

}  // namespace
}  // namespace hgg::pose_search_test
