#include "correction/window.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/spd.h"
#include "random_geometry.h"

namespace hgg::window_test {
namespace {

/// Noise so small that linearisation holds. The default robust scale then leaves 99 % of the factors alone.
constexpr double kSmallShare = 0.02, kSmallNoise = 0.005, kKappa = 1e4;  // share, m, points
constexpr double kMoveSigma = 0.01, kTurnSigma = 0.002;                  // m, rad
constexpr double kKnownSigma = 1e-4, kKnownTurn = 1e-5;

template <int Size>
Eigen::Matrix<double, Size, 1> normals(std::mt19937& random) {
  std::normal_distribution<double> normal(0, 1);
  Eigen::Matrix<double, Size, 1> v;
  for (double& value : v) {
    value = normal(random);
  }
  return v;
}

Mat6 informationOf(double sigma, double sigma_turn) {
  Vec6 deviations;
  deviations << Vec3::Constant(sigma), Vec3::Constant(sigma_turn);
  return deviations.cwiseAbs2().cwiseInverse().asDiagonal();
}

Vec6 poseNoise(std::mt19937& random, double sigma, double sigma_turn) {
  Vec6 xi = normals<6>(random);
  xi.head<3>() *= sigma;
  xi.tail<3>() *= sigma_turn;
  return xi;
}

struct World {
  std::vector<Pose> poses;
  std::vector<Belief> objects;
};

/// A winding way among objects, all seen from everywhere.
World randomWorld(std::mt19937& random, int poses, int objects) {
  World world;
  Pose T = randomPose(random, 100);
  for (int m = 0; m < poses; ++m) {
    world.poses.push_back(T);
    T = retract(T, (Vec6() << randomVector(random, 1), randomVector(random, 0.3)).finished());
  }
  for (int i = 0; i < objects; ++i) {
    world.objects.push_back({world.poses[0].translation() + randomVector(random, 15), randomSpd(random, 0.02), kKappa});
  }
  return world;
}

/// The world as it would be measured without any noise; nothing known of the objects before.
WindowProblem exactProblem(const World& world) {
  WindowProblem problem;
  problem.poses = world.poses;
  problem.oldest = {world.poses[0], informationOf(kKnownSigma, kKnownTurn)};
  problem.objects.resize(world.objects.size());
  for (int m = 0; m < static_cast<int>(world.poses.size()); ++m) {
    const Pose& T = world.poses[static_cast<std::size_t>(m)];
    if (m > 0) {
      const Pose T_a_b = world.poses[static_cast<std::size_t>(m) - 1].inverse() * T;
      problem.constraints.push_back({m - 1, m, T_a_b, kMoveSigma, kTurnSigma, false});
    }
    for (int i = 0; i < static_cast<int>(world.objects.size()); ++i) {
      problem.observations.push_back({m, i, transform(T.inverse(), world.objects[static_cast<std::size_t>(i)])});
    }
  }
  return problem;
}

/// Moves all poses but the first from where they are.
void disturbPoses(std::mt19937& random, double sigma, double sigma_turn, WindowProblem& problem) {
  for (std::size_t m = 1; m < problem.poses.size(); ++m) {
    problem.poses[m] = retract(problem.poses[m], poseNoise(random, sigma, sigma_turn));
  }
}

/// A belief drawn from the model's noise about the true one: its mean, and its extent's r_Sigma.
Belief drawn(std::mt19937& random, const Belief& truth, double views, const WindowConfig& config) {
  const ObjectObservation model = observationOf(truth, views, config.sigma_floor, config.noise);
  const Eigen3 e = eigenSymmetric(model.cov);
  const Vec6 r = normals<6>(random) / std::sqrt(model.extent_information);
  const auto offDiagonal = [&](Eigen::Index a, Eigen::Index b, double value) {
    const double x = 0.5 * std::log(e.values[b] / e.values[a]);
    return value / (std::sqrt(2.0) * (std::abs(x) < 1e-6 ? 1 : std::sinh(x) / x));
  };
  Mat3 on_axes = r.head<3>().asDiagonal();
  on_axes(0, 1) = on_axes(1, 0) = offDiagonal(0, 1, r[3]);
  on_axes(0, 2) = on_axes(2, 0) = offDiagonal(0, 2, r[4]);
  on_axes(1, 2) = on_axes(2, 1) = offDiagonal(1, 2, r[5]);
  const Mat3 cov = symExp(spdLog(model.cov) + e.vectors * on_axes * e.vectors.transpose());
  return {truth.mean + model.mean_information.llt().matrixU().solve(normals<3>(random)),
          withFloor(cov, 0) - config.sigma_floor * config.sigma_floor * Mat3::Identity(), truth.kappa};
}

WindowConfig smallNoise() {
  WindowConfig config;
  config.noise = {.position = {.view_share = kSmallShare, .view_noise = kSmallNoise}};
  config.position_covariances = true;
  return config;
}

/// Everything measured with exactly the noise that the window assumes. Every other object is known from two views.
WindowProblem noisyProblem(std::mt19937& random, const World& world, const WindowConfig& config) {
  WindowProblem problem = exactProblem(world);
  problem.oldest = {retract(world.poses[0], poseNoise(random, kMoveSigma, kTurnSigma)),
                    informationOf(kMoveSigma, kTurnSigma)};
  for (BetweenConstraint& e : problem.constraints) {
    e.T_a_b = retract(e.T_a_b, poseNoise(random, kMoveSigma, kTurnSigma));
  }
  for (WindowObservation& o : problem.observations) {
    o.belief_body = drawn(random, o.belief_body, 1, config);
  }
  for (std::size_t i = 0; i < world.objects.size(); i += 2) {
    Belief twice = world.objects[i];
    twice.kappa = 2 * kKappa;
    problem.objects[i] = drawn(random, twice, 2, config);
  }
  problem.poses[0] = problem.oldest.T_map_body;
  for (std::size_t m = 1; m < problem.poses.size(); ++m) {
    problem.poses[m] = problem.poses[m - 1] * problem.constraints[m - 1].T_a_b;
  }
  return problem;
}

std::string bytesOf(const WindowSolution& solution) {
  std::string bytes;
  const auto append = [&bytes](const auto& matrix) {
    bytes.append(reinterpret_cast<const char*>(matrix.data()),
                 sizeof(double) * static_cast<std::size_t>(matrix.size()));
  };
  for (const Pose& T : solution.poses) {
    append(T.matrix());
  }
  for (const Belief& object : solution.objects) {
    append(object.mean);
    append(object.cov);
  }
  for (const Mat3& cov : solution.position_cov) {
    append(cov);
  }
  append(solution.last_pose_information);
  return bytes;
}

/// Wilson and Hilferty's quantile of a chi-square's mean, `z` standard deviations from the middle.
double chiSquareMean(double degrees, double z) {
  return std::pow(1 - 2 / (9 * degrees) + z * std::sqrt(2 / (9 * degrees)), 3);
}

TEST(Window, RecoversPosesAndExtentsFromExactObservations) {
  std::mt19937 random(1);
  for (int run = 0; run < 10; ++run) {
    const World world = randomWorld(random, 6, 12);
    WindowProblem problem = exactProblem(world);
    disturbPoses(random, 0.1, 0.03, problem);
    const WindowSolution solution = solveWindow(problem, {});
    ASSERT_TRUE(solution.usable);
    EXPECT_GT(solution.cost_before, 1);
    EXPECT_LT(solution.cost_after, 1e-9);
    for (std::size_t m = 0; m < world.poses.size(); ++m) {
      EXPECT_LE(localCoordinates(solution.poses[m], world.poses[m]).norm(), 1e-6);
    }
    for (std::size_t i = 0; i < world.objects.size(); ++i) {
      EXPECT_LE((solution.objects[i].mean - world.objects[i].mean).norm(), 1e-6);
      EXPECT_LE(relativeError(solution.objects[i].cov, world.objects[i].cov), 1e-6);
      EXPECT_EQ(solution.objects[i].kappa, 6 * kKappa);
    }
  }
}

TEST(Window, ErrsAsMuchAsItSays) {
  std::mt19937 random(2);
  const WindowConfig config = smallNoise();
  constexpr int kRuns = 200, kObjects = 6;
  double of_pose = 0, of_position = 0, of_odometry = 0, of_pose_by_odometry = 0;
  for (int run = 0; run < kRuns; ++run) {
    const World world = randomWorld(random, 5, kObjects);
    const WindowProblem problem = noisyProblem(random, world, config);
    const WindowSolution solution = solveWindow(problem, config);
    ASSERT_TRUE(solution.usable);
    const Vec6 off = localCoordinates(world.poses.back(), solution.poses.back());
    of_pose += off.dot(solution.last_pose_information * off) / 6 / kRuns;
    of_odometry += localCoordinates(world.poses.back(), problem.poses.back()).head<3>().norm() / kRuns;
    of_pose_by_odometry += off.head<3>().norm() / kRuns;
    const std::size_t i =
        static_cast<std::size_t>(run) % kObjects;  // one per run: those of one run are not independent
    of_position +=
        std::pow(mahalanobis(solution.objects[i].mean - world.objects[i].mean, solution.position_cov[i]), 2) / 3 /
        kRuns;
  }
  RecordProperty("nees_pose", std::to_string(of_pose));
  RecordProperty("nees_position", std::to_string(of_position));
  EXPECT_GT(of_pose, chiSquareMean(6 * kRuns, -2.576));
  EXPECT_LT(of_pose, chiSquareMean(6 * kRuns, 2.576));
  EXPECT_GT(of_position, chiSquareMean(3 * kRuns, -2.576));
  EXPECT_LT(of_position, chiSquareMean(3 * kRuns, 2.576));
  EXPECT_LT(of_pose_by_odometry, 0.8 * of_odometry);
}

TEST(Window, ExtentsOfNoisyViewsComeCloserToTheTruth) {
  std::mt19937 random(3);
  const WindowConfig config = smallNoise();
  double before = 0, after = 0;
  for (int run = 0; run < 20; ++run) {
    const World world = randomWorld(random, 8, 6);
    const WindowProblem problem = noisyProblem(random, world, config);
    const WindowSolution solution = solveWindow(problem, config);
    for (std::size_t i = 1; i < 6; i += 2) {
      const Belief seen = transform(problem.poses[0], problem.observations[i].belief_body);
      before += affineInvariantDistance(seen.cov, world.objects[i].cov);
      after += affineInvariantDistance(solution.objects[i].cov, world.objects[i].cov);
    }
  }
  EXPECT_LT(after, 0.5 * before);  // eight views: about 0.35
}

TEST(Window, AnObservationOfAnotherObjectMovesNoPose) {
  std::mt19937 random(4);
  for (int run = 0; run < 10; ++run) {
    const World world = randomWorld(random, 5, 12);
    WindowProblem problem = exactProblem(world);
    problem.observations[below(random, 60)].belief_body.mean += 3 * randomVector(random, 1).normalized();
    const WindowSolution solution = solveWindow(problem, {});
    ASSERT_TRUE(solution.usable);
    for (std::size_t m = 0; m < world.poses.size(); ++m) {
      EXPECT_LE((solution.poses[m].translation() - world.poses[m].translation()).norm(), 0.02);
    }
  }
}

TEST(Window, BeliefsFromBeforeAnchorIt) {
  std::mt19937 random(5);
  const World world = randomWorld(random, 4, 12);
  WindowProblem problem = exactProblem(world);
  problem.objects = world.objects;
  problem.oldest.information = informationOf(1, 0.2);
  // The window's own idea of where it is lies aside; only the map knows better.
  for (Pose& T : problem.poses) {
    T = retract(T, (Vec6() << 0.2, -0.1, 0.1, 0, 0, 0).finished());
  }
  problem.oldest.T_map_body = problem.poses[0];
  const WindowSolution anchored = solveWindow(problem, {});
  ASSERT_TRUE(anchored.usable);
  EXPECT_LE((anchored.poses[3].translation() - world.poses[3].translation()).norm(), 0.02);
  EXPECT_EQ(anchored.objects[0].kappa, 5 * kKappa);
  problem.objects.assign(world.objects.size(), {});
  const WindowSolution adrift = solveWindow(problem, {});
  EXPECT_GE((adrift.poses[3].translation() - world.poses[3].translation()).norm(), 0.2);
}

TEST(Window, GivesTheSameBytesTwice) {
  std::mt19937 random(6);
  const WindowConfig config = smallNoise();
  const WindowProblem problem = noisyProblem(random, randomWorld(random, 6, 20), config);
  const WindowSolution a = solveWindow(problem, config), b = solveWindow(problem, config);
  EXPECT_EQ(bytesOf(a), bytesOf(b));
}

TEST(Window, MovesRigidlyWithItsProblem) {
  std::mt19937 random(7);
  const WindowConfig config = smallNoise();
  const WindowProblem problem = noisyProblem(random, randomWorld(random, 5, 8), config);
  const Pose G = randomPose(random, 50);
  Mat6 turn = Mat6::Zero();
  turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = G.linear();
  WindowProblem carried = problem;
  carried.oldest = {G * problem.oldest.T_map_body, turn * problem.oldest.information * turn.transpose()};
  for (Pose& T : carried.poses) {
    T = G * T;
  }
  for (Belief& object : carried.objects) {
    object = transform(G, object);
  }
  const WindowSolution here = solveWindow(problem, config), there = solveWindow(carried, config);
  EXPECT_NEAR(there.cost_after, here.cost_after, 1e-6 * here.cost_after);
  for (std::size_t m = 0; m < here.poses.size(); ++m) {
    EXPECT_LE(localCoordinates(there.poses[m], G * here.poses[m]).norm(), 1e-6);
  }
  for (std::size_t i = 0; i < here.objects.size(); ++i) {
    const Belief expected = transform(G, here.objects[i]);
    EXPECT_LE((there.objects[i].mean - expected.mean).norm(), 1e-6);
    EXPECT_LE(relativeError(there.objects[i].cov, expected.cov), 1e-6);
  }
  EXPECT_LE(relativeError(there.last_pose_information, turn * here.last_pose_information * turn.transpose()), 1e-6);
}

TEST(Window, FlatExtentsNeitherGrowNorBreakWindowAfterWindow) {
  std::mt19937 random(8);
  World world = randomWorld(random, 4, 6);
  for (Belief& object : world.objects) {
    object.cov = rotatedDiagonal(randomRotation(random), Vec3(1, 0.5, 1e-6));
  }
  WindowProblem problem = exactProblem(world);
  for (int window = 0; window < 20; ++window) {
    const WindowSolution solution = solveWindow(problem, {});
    ASSERT_TRUE(solution.usable);
    problem.objects = solution.objects;
  }
  for (std::size_t i = 0; i < world.objects.size(); ++i) {
    EXPECT_LE((problem.objects[i].cov - world.objects[i].cov).norm(), 1e-6);
  }
}

TEST(Window, WithoutObjectsFollowsTheConstraints) {
  std::mt19937 random(9);
  const World world = randomWorld(random, 5, 0);
  WindowProblem problem = exactProblem(world);
  disturbPoses(random, 0.1, 0.03, problem);
  const WindowSolution solution = solveWindow(problem, {});
  ASSERT_TRUE(solution.usable);
  EXPECT_LE(localCoordinates(solution.poses.back(), world.poses.back()).norm(), 1e-6);
}

TEST(Window, OfOnePoseMergesTheFrame) {
  std::mt19937 random(10);
  const World world = randomWorld(random, 1, 4);
  const WindowSolution solution = solveWindow(exactProblem(world), {});
  ASSERT_TRUE(solution.usable);
  EXPECT_LE(localCoordinates(solution.poses[0], world.poses[0]).norm(), 1e-9);
  EXPECT_LE(relativeError(solution.last_pose_information, informationOf(kKnownSigma, kKnownTurn)), 1e-6);
  EXPECT_LE((solution.objects[2].mean - world.objects[2].mean).norm(), 1e-9);
}

TEST(Window, LeavesObjectsWithoutObservationsAlone) {
  std::mt19937 random(11);
  const World world = randomWorld(random, 3, 4);
  WindowProblem problem = exactProblem(world);
  problem.objects.push_back(randomBelief(random, 10));
  problem.objects.emplace_back();
  WindowConfig config;
  config.position_covariances = true;
  const WindowSolution solution = solveWindow(problem, config);
  ASSERT_TRUE(solution.usable);
  EXPECT_EQ(solution.objects[4].mean, problem.objects[4].mean);
  EXPECT_EQ(solution.objects[4].cov, problem.objects[4].cov);
  EXPECT_EQ(solution.objects[5].kappa, 0);
  EXPECT_EQ(solution.position_cov[4], Mat3::Zero());
}

TEST(Window, PassesOverWhatSaysNothing) {
  std::mt19937 random(12);
  const World world = randomWorld(random, 3, 6);
  const WindowProblem clean = exactProblem(world);
  WindowProblem problem = clean;
  problem.observations.push_back({0, 1, {Vec3::Zero(), Mat3::Identity(), 0}});
  problem.observations.push_back({0, 1, {Vec3::Zero(), -Mat3::Identity(), 5}});
  problem.observations.push_back({0, 1, {Vec3::Constant(NAN), Mat3::Identity(), 5}});
  problem.observations.push_back({0, 1, {Vec3::Zero(), 1e300 * Mat3::Identity(), 1e-300}});
  problem.observations.push_back({7, 1, clean.observations[0].belief_body});
  problem.observations.push_back({0, -1, clean.observations[0].belief_body});
  problem.constraints.push_back({1, 1, Pose::Identity(), 1, 1, false});
  problem.constraints.push_back({1, 9, Pose::Identity(), 1, 1, false});
  problem.constraints.push_back({0, 1, Pose::Identity(), 0, 1, false});
  problem.constraints.push_back({0, 1, Pose::Identity(), 1, NAN, false});
  const WindowSolution expected = solveWindow(clean, {}), solution = solveWindow(problem, {});
  ASSERT_TRUE(solution.usable);
  EXPECT_EQ(solution.poses[2].matrix(), expected.poses[2].matrix());
  EXPECT_EQ(solution.objects[1].mean, expected.objects[1].mean);
}

TEST(Window, SurvivesPointsAndObjectsOnTopOfEachOther) {
  std::mt19937 random(13);
  World world = randomWorld(random, 3, 6);
  for (Belief& object : world.objects) {
    object = {world.objects[0].mean, Mat3::Zero(), 1};
  }
  WindowProblem problem = exactProblem(world);
  disturbPoses(random, 0.1, 0.03, problem);
  const WindowSolution solution = solveWindow(problem, {});
  ASSERT_TRUE(solution.usable);
  EXPECT_TRUE(solution.last_pose_information.allFinite());
  EXPECT_LE(solution.objects[3].cov.norm(), 0.1);
}

TEST(Window, IsNotUsableWhereNothingHoldsThePose) {
  std::mt19937 random(14);
  const World world = randomWorld(random, 3, 6);
  EXPECT_FALSE(solveWindow({}, {}).usable);
  WindowProblem unknown = exactProblem(world);
  unknown.oldest.information.setZero();
  unknown.constraints.clear();
  unknown.observations.clear();
  const WindowSolution solution = solveWindow(unknown, {});
  EXPECT_FALSE(solution.usable);
  EXPECT_EQ(solution.poses[2].matrix(), unknown.poses[2].matrix());
  WindowProblem broken = exactProblem(world);
  broken.poses[1].translation().x() = NAN;
  EXPECT_FALSE(solveWindow(broken, {}).usable);
}

TEST(Window, WeighsAllViewsAlikeInTheAblation) {
  std::mt19937 random(15);
  WindowConfig config = smallNoise();
  WindowProblem problem = noisyProblem(random, randomWorld(random, 4, 8), config);
  config.noise.uniform_weights = true;
  problem.objects.assign(8, {});
  const WindowSolution a = solveWindow(problem, config);
  for (WindowObservation& o : problem.observations) {
    o.belief_body.kappa = uniform(random, 1, 1000);
  }
  const WindowSolution b = solveWindow(problem, config);
  EXPECT_LE(localCoordinates(a.poses[3], b.poses[3]).norm(), 1e-4);  // their starts differ
}

}  // namespace
}  // namespace hgg::window_test
