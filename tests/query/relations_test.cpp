#include "query/relations.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "query/description.h"
#include "query/views.h"

namespace hgg::relations_test {
namespace {

SceneThing box(const Vec3& centre, const Vec3& size, double sigma = 0) {
  SceneThing t;
  t.centre = centre, t.half = size / 2, t.sigma = sigma;
  return t;
}

TEST(Relations, GapIsThatOfTheNearestPoints) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> at(-2, 2), edge(0.1, 2), share(0, 1);
  for (int k = 0; k < 20; ++k) {
    const SceneThing a = box({at(random), at(random), at(random)}, {edge(random), edge(random), edge(random)});
    const SceneThing b = box({at(random), at(random), at(random)}, {edge(random), edge(random), edge(random)});
    double least = 1e9;
    for (int n = 0; n < 20'000; ++n) {  // a random point of a, and the point of b nearest to it
      const Vec3 p =
          a.centre + a.half.cwiseProduct(2 * Vec3(share(random), share(random), share(random)) - Vec3::Ones());
      const Vec3 q = p.cwiseMax(b.centre - b.half).cwiseMin(b.centre + b.half);
      least = std::min(least, (p - q).norm());
    }
    EXPECT_LE(gapBetween(a, b), least + 1e-9);
    EXPECT_GT(gapBetween(a, b), least - 0.25);
  }
}

TEST(Relations, NearnessIntegratesOverThePlace) {
  std::mt19937 random(2);
  for (const auto& [distance, sigma] : std::vector<std::pair<double, double>>{{1.0, 0.1}, {2.0, 0.3}, {0.8, 0.2}}) {
    std::normal_distribution<double> at(distance, sigma);
    double sum = 0;
    constexpr int kSamples = 200'000;
    for (int k = 0; k < kSamples; ++k) {
      sum += std::pow(1 + std::max(at(random), 0.0) / 0.4, -3);
    }
    EXPECT_NEAR(nearness(distance, sigma, 0.4, 3), sum / kSamples, 0.03 * sum / kSamples);
  }
  EXPECT_DOUBLE_EQ(nearness(0.4, 0, 0.4, 3), 0.125);
}

TEST(Relations, OnIsNotBelow) {
  const SceneThing table = box({0, 0, 0.4}, {1, 1, 0.8}), lamp = box({0.2, 0, 1}, {0.2, 0.2, 0.4}),
                   bin = box({0, 0, 0.2}, {0.3, 0.3, 0.4}), far = box({3, 0, 1}, {0.2, 0.2, 0.4});
  EXPECT_GT(likelihoodOn(lamp, table), 0.8);
  EXPECT_LT(likelihoodOn(bin, table), likelihoodOn(lamp, table) / 2);
  EXPECT_LT(likelihoodOn(far, table), 0.05);
  EXPECT_GT(likelihoodBelow(bin, table), 3 * likelihoodBelow(lamp, table));
  EXPECT_GT(likelihoodAbove(lamp, table), 3 * likelihoodAbove(bin, table));
  EXPECT_GT(likelihoodWith(table, lamp), 3 * likelihoodWith(table, far));
}

TEST(Relations, ALessKnownPlaceIsLessSurelyAbove) {
  const SceneThing table = box({0, 0, 0.4}, {1, 1, 0.8});
  EXPECT_GT(likelihoodAbove(box({0, 0, 1.2}, {0.2, 0.2, 0.4}), table),
            likelihoodAbove(box({0, 0, 1.2}, {0.2, 0.2, 0.4}, 0.5), table));
}

TEST(Relations, BetweenIsBetween) {
  const SceneThing a = box({0, 0, 0}, {1, 1, 1}), b = box({4, 0, 0}, {1, 1, 1});
  const double middle = likelihoodBetween(box({2, 0, 0}, {1, 1, 1}), a, b);
  EXPECT_GT(middle, 0.9);
  EXPECT_LT(likelihoodBetween(box({2, 3, 0}, {1, 1, 1}), a, b), 0.2 * middle);
  EXPECT_LT(likelihoodBetween(box({6, 0, 0}, {1, 1, 1}), a, b), 0.2 * middle);
}

TEST(Views, LeftIsToTheLeftOfWhoLooks) {
  EXPECT_TRUE(leftOf(Vec2(1, 0)).isApprox(Vec2(0, 1)));
  const std::vector<Gaze> gaze{{Vec2(0, 1), 1}};
  EXPECT_TRUE(directionsOf(Relation::kLeft, gaze)[0].direction.isApprox(Vec2(-1, 0)));
  EXPECT_TRUE(directionsOf(Relation::kRight, gaze)[0].direction.isApprox(Vec2(1, 0)));
  EXPECT_TRUE(directionsOf(Relation::kBehind, gaze)[0].direction.isApprox(Vec2(0, 1)));
  EXPECT_TRUE(directionsOf(Relation::kFront, gaze)[0].direction.isApprox(Vec2(0, -1)));
}

TEST(Views, ProbabilitiesAddUp) {
  QueryScene scene;
  scene.things = {box({0, 3, 0}, {1, 0.2, 1}), box({2, 3, 0}, {1, 0.2, 1})};
  double sum = 0;
  for (const Gaze& g : gazesAt(scene, {0, 1})) {
    sum += g.probability;
    EXPECT_NEAR(g.direction.norm(), 1, 1e-12);
  }
  EXPECT_NEAR(sum, 1, 1e-12);
}

TEST(Description, RanksCountFromTheLargest) {
  const std::vector<int> things{0, 1, 2};
  const Peers peers{things, {true, true, true}};
  Constraint said;
  said.rank = 2, said.ranked = true;
  const std::vector<double> second = likelihoodOfRank({3, 1, 2}, peers, said);
  EXPECT_GT(second[2], second[0]);
  EXPECT_GT(second[2], second[1]);
  said.rank = -1;
  const std::vector<double> last = likelihoodOfRank({3, 1, 2}, peers, said);
  EXPECT_GT(last[1], last[2]);
}

TEST(Description, LabIsThatOfTheStandard) {  // CIE 15: white, black, and sRGB red
  EXPECT_TRUE(labOf({255, 255, 255}).isApprox(Vec3(100, 0, 0), 1e-2));
  EXPECT_NEAR(labOf({0, 0, 0}).norm(), 0, 1e-9);
  EXPECT_TRUE(labOf({255, 0, 0}).isApprox(Vec3(53.24, 80.09, 67.20), 1e-2));
}

}  // namespace
}  // namespace hgg::relations_test
