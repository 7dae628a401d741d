#include "correction/pose_graph.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "random_geometry.h"

namespace hgg::pose_graph_test {
namespace {

constexpr double kStepSigma = 0.02, kStepTurn = 0.003, kLoopSigma = 0.05, kLoopTurn = 0.01;  // m, rad
constexpr int kSide = 25;                                                                    // steps of 2 m

Vec6 poseNoise(std::mt19937& random, double sigma, double sigma_turn) {
  std::normal_distribution<double> normal(0, 1);
  Vec6 xi;
  for (Eigen::Index k = 0; k < 6; ++k) {
    xi[k] = normal(random) * (k < 3 ? sigma : sigma_turn);
  }
  return xi;
}

/// Round a square of 50 m and round again, a keyframe every two metres.
std::vector<Pose> squares(int rounds) {
  std::vector<Pose> poses{Pose::Identity()};
  for (int k = 1; k <= 4 * kSide * rounds; ++k) {
    Pose T_step = Pose::Identity();
    T_step.translation().x() = 2;
    if (k % kSide == 0) {
      T_step.linear() = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitZ()).toRotationMatrix();
    }
    poses.push_back(poses.back() * T_step);
  }
  return poses;
}

BetweenConstraint constraintBetween(const std::vector<Pose>& truth, int a, int b, bool is_loop) {
  const Pose T_a_b = truth[static_cast<std::size_t>(a)].inverse() * truth[static_cast<std::size_t>(b)];
  return {a, b, T_a_b, is_loop ? kLoopSigma : kStepSigma, is_loop ? kLoopTurn : kStepTurn, is_loop};
}

struct Drive {
  std::vector<Pose> truth, drifted;
  std::vector<BetweenConstraint> constraints;
};

/// A chain with noise, and poses that have drifted along it.
Drive noisyDrive(std::mt19937& random, int rounds) {
  Drive drive{squares(rounds), {Pose::Identity()}, {}};
  for (int k = 1; k < static_cast<int>(drive.truth.size()); ++k) {
    BetweenConstraint step = constraintBetween(drive.truth, k - 1, k, false);
    step.T_a_b = retract(step.T_a_b, poseNoise(random, kStepSigma, kStepTurn));
    drive.drifted.push_back(drive.drifted.back() * step.T_a_b);
    drive.constraints.push_back(step);
  }
  return drive;
}

/// Loops between the first and the second round, `count` of them spread over it.
void addTrueLoops(std::mt19937& random, int count, Drive& drive) {
  for (int k = 0; k < count; ++k) {
    const int a = k * 4 * kSide / count;
    BetweenConstraint loop = constraintBetween(drive.truth, a, a + 4 * kSide, true);
    loop.T_a_b = retract(loop.T_a_b, poseNoise(random, kLoopSigma, kLoopTurn));
    drive.constraints.push_back(loop);
  }
}

double meanError(const std::vector<Pose>& poses, const std::vector<Pose>& truth) {
  double sum = 0;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    sum += (poses[k].translation() - truth[k].translation()).norm();
  }
  return sum / static_cast<double>(poses.size());
}

double furthestApart(const std::vector<Pose>& a, const std::vector<Pose>& b) {
  double furthest = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    furthest = std::max(furthest, (a[k].translation() - b[k].translation()).norm());
  }
  return furthest;
}

void expectSameBytes(const std::vector<Pose>& a, const std::vector<Pose>& b) {
  const auto bytes = [](const Pose& T) {
    return std::string(reinterpret_cast<const char*>(T.data()), 16 * sizeof(double));
  };
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_EQ(bytes(a[k]), bytes(b[k])) << k;
  }
}

TEST(PoseGraph, RecoversADriftedSquareFromAnExactLoop) {
  std::mt19937 random(1);
  Drive drive = noisyDrive(random, 1);
  drive.constraints.clear();
  const int last = static_cast<int>(drive.truth.size()) - 1;
  for (int k = 1; k <= last; ++k) {
    drive.constraints.push_back(constraintBetween(drive.truth, k - 1, k, false));
  }
  drive.constraints.push_back(constraintBetween(drive.truth, 0, last, true));
  ASSERT_GT(furthestApart(drive.drifted, drive.truth), 0.5);
  const PoseGraphSolution solution = solvePoseGraph(drive.drifted, drive.constraints);
  EXPECT_TRUE(solution.converged);
  EXPECT_LT(solution.cost_after, 1e-9);
  EXPECT_EQ(solution.loop_weights, std::vector<double>{1});
  for (std::size_t k = 0; k < drive.truth.size(); ++k) {
    EXPECT_LE(localCoordinates(solution.poses[k], drive.truth[k]).norm(), 1e-6);
  }
}

TEST(PoseGraph, SpreadsTheDriftOfANoisyChain) {
  std::mt19937 random(2);
  double before = 0, after = 0;
  for (int run = 0; run < 20; ++run) {
    Drive drive = noisyDrive(random, 2);
    addTrueLoops(random, 10, drive);
    const PoseGraphSolution solution = solvePoseGraph(drive.drifted, drive.constraints);
    EXPECT_TRUE(solution.converged);
    EXPECT_LT(solution.cost_after, solution.cost_before);
    EXPECT_GT(*std::min_element(solution.loop_weights.begin(), solution.loop_weights.end()), 0.5);
    before += meanError(drive.drifted, drive.truth);
    after += meanError(solution.poses, drive.truth);
  }
  EXPECT_LT(after, 0.5 * before);
}

TEST(PoseGraph, TakesAFalseLoopAmongTenTrueOnesForWhatItIs) {
  std::mt19937 random(3);
  for (int run = 0; run < 50; ++run) {
    Drive drive = noisyDrive(random, 2);
    addTrueLoops(random, 10, drive);
    const PoseGraphSolution without = solvePoseGraph(drive.drifted, drive.constraints);
    const int count = static_cast<int>(drive.truth.size());
    const int a = static_cast<int>(below(random, 100)), b = a + 30 + static_cast<int>(below(random, 60));
    BetweenConstraint lie = constraintBetween(drive.truth, a, std::min(b, count - 1), true);
    lie.T_a_b = randomPose(random, 3);  // "the same place"
    drive.constraints.push_back(lie);
    const PoseGraphSolution with = solvePoseGraph(drive.drifted, drive.constraints);
    ASSERT_EQ(with.loop_weights.size(), 11U);
    EXPECT_LT(with.loop_weights[10], 0.1) << run;
    EXPECT_LE(furthestApart(with.poses, without.poses), 0.05) << run;
  }
}

TEST(PoseGraph, KeepsThePosesOfOtherComponents) {
  std::mt19937 random(4);
  Drive drive = noisyDrive(random, 2);
  addTrueLoops(random, 5, drive);
  const std::size_t connected = drive.drifted.size();
  const auto first = static_cast<int>(connected);
  for (int k = 0; k < 3; ++k) {
    drive.drifted.push_back(randomPose(random, 100));
  }
  drive.constraints.push_back({first, first + 1, randomPose(random, 5), 1, 1, false});
  drive.constraints.push_back({first + 1, first + 2, randomPose(random, 5), 1, 1, true});
  const PoseGraphSolution solution = solvePoseGraph(drive.drifted, drive.constraints);
  EXPECT_TRUE(solution.converged);
  EXPECT_EQ(solution.loop_weights.size(), 6U);
  EXPECT_GT((solution.poses[connected - 1].translation() - drive.drifted[connected - 1].translation()).norm(), 1e-3);
  for (std::size_t k = connected; k < connected + 3; ++k) {
    EXPECT_EQ(solution.poses[k].matrix(), drive.drifted[k].matrix());
  }
  EXPECT_EQ(solution.poses[0].matrix(), drive.drifted[0].matrix());
}

TEST(PoseGraph, OfNothingOrOnePoseIsItself) {
  std::mt19937 random(5);
  EXPECT_TRUE(solvePoseGraph({}, {}).poses.empty());
  const std::vector<Pose> one{randomPose(random, 10)};
  expectSameBytes(solvePoseGraph(one, {}).poses, one);
  const std::vector<Pose> apart{randomPose(random, 10), randomPose(random, 10), randomPose(random, 10)};
  expectSameBytes(solvePoseGraph(apart, {}).poses, apart);
  const std::vector<BetweenConstraint> elsewhere{{1, 2, Pose::Identity(), 1, 1, false}};
  expectSameBytes(solvePoseGraph(apart, elsewhere).poses, apart);
}

TEST(PoseGraph, GivesTheSameBytesTwice) {
  std::mt19937 random(7);
  Drive drive = noisyDrive(random, 2);
  addTrueLoops(random, 10, drive);
  const PoseGraphSolution a = solvePoseGraph(drive.drifted, drive.constraints),
                          b = solvePoseGraph(drive.drifted, drive.constraints);
  expectSameBytes(a.poses, b.poses);
  EXPECT_EQ(a.loop_weights, b.loop_weights);
}

}  // namespace
}  // namespace hgg::pose_graph_test
