#include "place/candidates.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "place/consistency.h"
#include "place/landmarks.h"

namespace hgg::candidates_test {
namespace {

TEST(Candidates, AreOfOneClassAndLikeSizeAndTheRareOnesCountMost) {
  std::vector<Landmark> a, b;
  for (int k = 0; k < 9; ++k) {
    a.push_back(landmarkAt({5.0 * k, 0, 0}, 1));
  }
  a.push_back(landmarkAt({0, 30, 0}, 2));
  b = {landmarkAt({0, 0, 0}, 1), landmarkAt({3, 3, 0}, 2), landmarkAt({6, 6, 0}, 3), landmarkAt({9, 9, 0}, 1)};
  b[3].size *= 10;
  const auto matches = candidateMatches(a, b, kSame, 1000);
  ASSERT_EQ(matches.size(), 10U);
  EXPECT_EQ(matches[0].a, 9);
  EXPECT_NEAR(matches[0].weight - matches[1].weight, std::log(9.0), 1e-9);
  EXPECT_EQ(candidateMatches(a, b, kSame, 3).size(), 3U);
}

TEST(Candidates, ManyLikeThingsAreToldApartByWhatStandsAround) {
  std::mt19937 random(5);
  const Pose T_a_b = uprightPose(2, Vec3(30, -5, 0));
  const std::vector<Landmark> a = randomLandmarks(random, 1200, 250);
  std::vector<Landmark> b = moved(T_a_b.inverse(), a);
  std::shuffle(b.begin(), b.end(), random);
  for (Landmark& l : b) {
    l.mean += randomVector(random, 0.05);
  }
  const auto candidates = candidateMatches(a, b, kSame, 6000);
  EXPECT_EQ(candidates.size(), 6000U);
  std::vector<int> partners(b.size());
  int right = 0;
  for (const Match& m : candidates) {
    ++partners[static_cast<std::size_t>(m.b)];
    right +=
        (a[static_cast<std::size_t>(m.a)].mean - T_a_b * b[static_cast<std::size_t>(m.b)].mean).norm() < 0.2 ? 1 : 0;
  }
  EXPECT_EQ(*std::min_element(partners.begin(), partners.end()), 5);
  EXPECT_EQ(*std::max_element(partners.begin(), partners.end()), 5);
  EXPECT_GT(right, 1000);
  const auto found = findHypotheses(a, b, candidates, 3);
  ASSERT_FALSE(found.empty());
  EXPECT_LT((found.front().T_a_b.matrix() - T_a_b.matrix()).cwiseAbs().maxCoeff(), 0.1);
  EXPECT_GT(found.front().clique.size(), 1000U);
}

TEST(Candidates, RareThingsKeepTheirPartnersAmongManyLikeOnes) {
  std::mt19937 random(6);
  std::vector<Landmark> a = randomLandmarks(random, 300, 100, 1);
  for (const Landmark& l : randomLandmarks(random, 10, 100, 2)) {
    a.push_back(l);
  }
  const auto candidates = candidateMatches(a, a, kSame, 6000);
  EXPECT_LE(candidates.size(), 6000U);
  EXPECT_EQ(std::count_if(candidates.begin(), candidates.end(), [](const Match& m) { return m.a >= 300; }), 100);
  EXPECT_GE(candidates.front().a, 300);
}

TEST(Candidates, MoreLikeThingsThanCandidates) {
  std::mt19937 random(7);
  const std::vector<Landmark> a = randomLandmarks(random, 3000, 500);
  const auto candidates = candidateMatches(a, a, kSame, 2000);
  EXPECT_EQ(candidates.size(), 2000U);
  EXPECT_TRUE(std::all_of(candidates.begin(), candidates.end(), [](const Match& m) { return m.a == m.b; }));
}

TEST(Candidates, SimilarClassesMatchAtAPrice) {
  const std::vector<Landmark> a{landmarkAt({0, 0, 0}, 1)}, b{landmarkAt({0, 0, 0}, 2)};
  EXPECT_TRUE(candidateMatches(a, b, kSame, 10).empty());
  const auto soft = [](ClassId x, ClassId y) { return x == y ? 1.0 : 0.5; };
  ASSERT_EQ(candidateMatches(a, b, soft, 10).size(), 1U);
  EXPECT_NEAR(candidateMatches(a, a, kSame, 10)[0].weight - candidateMatches(a, b, soft, 10)[0].weight, std::log(2.0),
              1e-9);
}

}  // namespace
}  // namespace hgg::candidates_test
