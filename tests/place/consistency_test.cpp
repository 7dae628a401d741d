#include "place/consistency.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "place/landmarks.h"

namespace hgg::consistency_test {
namespace {

/// An edge of the consistency graph: horizontal distances agree within 2.5 deviations and 1 %, differences of height
/// within that and 5 degrees.
bool areConsistent(std::span<const Landmark> a, std::span<const Landmark> b, const Match& p, const Match& q) {
  if (p.a == q.a || p.b == q.b) {
    return false;
  }
  const Landmark &ap = a[static_cast<std::size_t>(p.a)], &aq = a[static_cast<std::size_t>(q.a)];
  const Landmark &bp = b[static_cast<std::size_t>(p.b)], &bq = b[static_cast<std::size_t>(q.b)];
  const Vec3 da = aq.mean - ap.mean, db = bq.mean - bp.mean;
  const double along_a = std::hypot(da.x(), da.y()), along_b = std::hypot(db.x(), db.y());
  const double variance = ap.sigma * ap.sigma + aq.sigma * aq.sigma + bp.sigma * bp.sigma + bq.sigma * bq.sigma;
  const double tolerance = 2.5 * std::sqrt(variance) + 0.01 * std::max(along_a, along_b);
  return std::abs(along_a - along_b) < tolerance &&
         std::abs(da.z() - db.z()) < tolerance + 5 * M_PI / 180 * std::max(along_a, along_b);
}

/// The largest set of mutually consistent pairs, by trying them all.
std::size_t largestClique(std::span<const Landmark> a, std::span<const Landmark> b, const std::vector<Match>& pairs,
                          std::vector<Match>& chosen, std::size_t next) {
  std::size_t best = chosen.size();
  for (std::size_t k = next; k < pairs.size(); ++k) {
    if (std::all_of(chosen.begin(), chosen.end(), [&](const Match& m) { return areConsistent(a, b, m, pairs[k]); })) {
      chosen.push_back(pairs[k]);
      best = std::max(best, largestClique(a, b, pairs, chosen, k + 1));
      chosen.pop_back();
    }
  }
  return best;
}

TEST(Consistency, FitUprightIsExactOnExactPoints) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 100; ++trial) {
    const Pose T = uprightPose(uniform(random, -3.1, 3.1), randomVector(random, 50));
    std::vector<PointPair> pairs;
    for (int k = 0; k < 2 + trial % 5; ++k) {
      const Vec3 b = randomVector(random, 10);
      pairs.push_back({T * b, b, uniform(random, 0.1, 5)});
    }
    EXPECT_TRUE(fitUpright(pairs).isApprox(T, 1e-9)) << trial;
  }
}

TEST(Consistency, FitUprightIsTheMinimum) {
  std::mt19937 random(2);
  std::vector<PointPair> pairs;
  for (int k = 0; k < 6; ++k) {
    pairs.push_back({randomVector(random, 5), randomVector(random, 5), uniform(random, 0.1, 5)});
  }
  const auto cost = [&](const Pose& T) {
    double sum = 0;
    for (const PointPair& p : pairs) {
      sum += p.weight * (p.a - T * p.b).squaredNorm();
    }
    return sum;
  };
  const Pose best = fitUpright(pairs);
  for (int trial = 0; trial < 200; ++trial) {
    EXPECT_LE(cost(best), cost(uprightPose(uniform(random, -0.1, 0.1), randomVector(random, 0.1)) * best));
  }
}

TEST(Consistency, FitUprightOfNothingOrOnePointIsFinite) {
  EXPECT_TRUE(fitUpright({}).isApprox(Pose::Identity()));
  const std::vector<PointPair> one{{Vec3(1, 2, 3), Vec3(0, 0, 1), 2}};
  EXPECT_TRUE(fitUpright(one).isApprox(uprightPose(0, Vec3(1, 2, 2))));
}

TEST(Consistency, FindsTheLargestClique) {
  for (unsigned seed = 1; seed <= 25; ++seed) {
    std::mt19937 random(seed);
    const Pose T_a_b = uprightPose(uniform(random, -3.1, 3.1), randomVector(random, 30));
    std::vector<Landmark> b = randomLandmarks(random, 7, 10);
    std::vector<Landmark> a = moved(T_a_b, b);
    a.resize(5);  // two of b are not in a, and each has three of its own
    for (std::vector<Landmark>* landmarks : {&a, &b}) {
      for (const Landmark& l : moved(uprightPose(0, landmarks->front().mean), randomLandmarks(random, 3, 10))) {
        landmarks->push_back(l);
      }
    }
    const auto candidates = candidateMatches(a, b, kSame, 1000);
    std::vector<Match> chosen;
    const std::size_t largest = largestClique(a, b, candidates, chosen, 0);
    const auto found = findHypotheses(a, b, candidates, 5);
    ASSERT_FALSE(found.empty()) << seed;
    EXPECT_EQ(found.front().clique.size(), largest) << seed;
    EXPECT_LT((found.front().T_a_b.matrix() - T_a_b.matrix()).cwiseAbs().maxCoeff(), 0.1) << seed;
    for (const Match& p : found.front().clique) {
      for (const Match& q : found.front().clique) {
        EXPECT_TRUE(p.a == q.a || areConsistent(a, b, p, q)) << seed;
      }
    }
  }
}

TEST(Consistency, AMirrorImageIsNoPlace) {
  std::mt19937 random(3);
  const std::vector<Landmark> a = randomLandmarks(random, 12, 10);
  std::vector<Landmark> b = a;
  for (Landmark& l : b) {
    l.mean.y() = -l.mean.y();  // all distances agree
  }
  const auto found = findHypotheses(a, b, candidateMatches(a, b, kSame, 1000), 5);
  ASSERT_FALSE(found.empty());
  EXPECT_LT(found.front().clique.size(), 6U);
  const auto itself = findHypotheses(a, a, candidateMatches(a, a, kSame, 1000), 5);
  ASSERT_FALSE(itself.empty());
  EXPECT_EQ(itself.front().clique.size(), 12U);
  EXPECT_GT(itself.front().weight, 2 * found.front().weight);
}

TEST(Consistency, HeightsCount) {
  const std::vector<Landmark> a{landmarkAt({0, 0, 0}), landmarkAt({4, 0, 0})};
  const std::vector<Landmark> b{landmarkAt({0, 0, 0}), landmarkAt({4, 0, 2})};
  EXPECT_FALSE(findHypotheses(a, a, candidateMatches(a, a, kSame, 10), 5).empty());
  EXPECT_TRUE(findHypotheses(a, b, candidateMatches(a, b, kSame, 10), 5).empty());
}

TEST(Consistency, ATiltOfFiveDegreesIsForgiven) {
  std::mt19937 random(4);
  const std::vector<Landmark> a = randomLandmarks(random, 10, 20);
  Pose T = uprightPose(2, Vec3(5, 5, 1));
  T.linear() = T.linear() * Eigen::AngleAxisd(4.9 * M_PI / 180, Vec3(1, 1, 0).normalized()).toRotationMatrix();
  const std::vector<Landmark> b = moved(T.inverse(), a);
  const auto found = findHypotheses(a, b, candidateMatches(a, b, kSame, 1000), 3);
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found.front().clique.size(), 10U);
}

TEST(Consistency, ASymmetricWorldHasSeveralPlaces) {
  std::vector<Landmark> a;
  for (const double x : {-6.0, 6.0}) {
    for (const double y : {-6.0, 6.0}) {
      a.push_back(landmarkAt({x, y, 0}));
    }
  }
  const auto found = findHypotheses(a, a, candidateMatches(a, a, kSame, 1000), 10);
  ASSERT_GE(found.size(), 4U);
  EXPECT_NEAR(found[3].weight, found[0].weight, 1e-6);
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_TRUE(areDistinct(found[i].T_a_b, found[j].T_a_b, Vec3::Zero()));
    }
  }
}

TEST(Consistency, NothingAndOnePairGiveNoPlace) {
  EXPECT_TRUE(findHypotheses({}, {}, {}, 5).empty());
  const std::vector<Landmark> one{landmarkAt({0, 0, 0})};
  EXPECT_TRUE(findHypotheses(one, one, candidateMatches(one, one, kSame, 10), 5).empty());
}

}  // namespace
}  // namespace hgg::consistency_test
