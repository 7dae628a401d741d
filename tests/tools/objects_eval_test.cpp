#include <gtest/gtest.h>

#include <cmath>

#include "eval/objects.h"
#include "sim/random.h"

namespace hgg::objects_eval_test {
namespace {

constexpr ClassId kCar = 10, kPole = 80;

TruthObject truthAt(std::int64_t id, const Vec3& mean, ClassId label = kCar, bool dynamic = false) {
  return {id, label, dynamic, false, 1, {mean, Mat3::Identity(), 100}};
}

MappedObject predictionAt(NodeId id, const Vec3& mean, ClassId label = kCar, bool stuff = false) {
  return {id, label, stuff, {mean, Mat3::Identity(), 100}};
}

TEST(EvaluateObjects, PerfectMapScoresOneAndZeroMetres) {
  const std::vector<TruthObject> truth{truthAt(1, Vec3(0, 0, 0)), truthAt(2, Vec3(5, 0, 0)),
                                       truthAt(3, Vec3(0, 5, 0), kPole)};
  const std::vector<MappedObject> map{predictionAt(7, Vec3(5, 0, 0)), predictionAt(8, Vec3(0, 0, 0)),
                                      predictionAt(9, Vec3(0, 5, 0), kPole)};
  const auto e = evaluateObjects(map, truth, 1.0, {});
  ASSERT_EQ(e.classes.size(), 2u);
  for (const ObjectScore* s : {&e.overall, &e.classes.at(kCar), &e.classes.at(kPole)}) {
    EXPECT_EQ(s->precision(), 1.0);
    EXPECT_EQ(s->recall(), 1.0);
    EXPECT_EQ(s->f1(), 1.0);
    EXPECT_EQ(s->positionError().mean, 0.0);
    EXPECT_EQ(s->positionError().median, 0.0);
    EXPECT_EQ(s->positionError().max, 0.0);
  }
  EXPECT_EQ(e.overall.truth, 3u);
  EXPECT_EQ(e.classes.at(kCar).truth, 2u);
}

TEST(EvaluateObjects, KnownPerturbationsScoreTheirArithmetic) {
  const std::vector<TruthObject> truth{truthAt(1, Vec3(0, 0, 0)), truthAt(2, Vec3(10, 0, 0)),
                                       truthAt(3, Vec3(20, 0, 0)), truthAt(4, Vec3(30, 0, 0)),
                                       truthAt(5, Vec3(40, 0, 0))};
  const std::vector<MappedObject> map{predictionAt(1, Vec3(0.1, 0, 0)),  predictionAt(2, Vec3(10, 0.2, 0)),
                                      predictionAt(3, Vec3(20, 0, 0.3)), predictionAt(4, Vec3(30.3, 0.4, 1.2)),
                                      predictionAt(5, Vec3(100, 0, 0)),  predictionAt(6, Vec3(200, 0, 0))};
  const auto s = evaluateObjects(map, truth, 1.5, {}).overall;
  EXPECT_EQ(s.matches.size(), 4u);
  EXPECT_DOUBLE_EQ(s.precision(), 4.0 / 6.0);
  EXPECT_DOUBLE_EQ(s.recall(), 4.0 / 5.0);
  EXPECT_DOUBLE_EQ(s.f1(), 8.0 / 11.0);
  EXPECT_NEAR(s.positionError().mean, (0.1 + 0.2 + 0.3 + 1.3) / 4, 1e-12);
  EXPECT_NEAR(s.positionError().median, 0.25, 1e-12);
  EXPECT_NEAR(s.positionError().max, 1.3, 1e-12);
  EXPECT_EQ(s.missed, std::vector<std::int64_t>{5});
  EXPECT_EQ(s.ghosts, (std::vector<NodeId>{5, 6}));
}

TEST(EvaluateObjects, ExtentErrorIsTheWassersteinDistance) {
  // Commuting covariances: W2^2 = |difference of means|^2 + sum of (difference of deviations)^2.
  TruthObject object = truthAt(1, Vec3(0, 0, 0));
  object.belief.cov = Vec3(4.0, 1.0, 0.25).asDiagonal();
  MappedObject perfect = predictionAt(1, Vec3(0, 0, 0)), off = predictionAt(1, Vec3(0.3, 0, 0));
  perfect.belief.cov = object.belief.cov;
  off.belief.cov = Vec3(2.25, 1.0, 0.0).asDiagonal();
  EXPECT_NEAR(evaluateObjects(std::vector{perfect}, std::vector{object}, 1.0, {}).overall.extentError().max, 0.0, 1e-7);
  const auto s = evaluateObjects(std::vector{off}, std::vector{object}, 1.0, {}).overall;
  EXPECT_NEAR(s.extentError().mean, std::sqrt(0.09 + 0.25 + 0.25), 1e-9);
}

TEST(EvaluateObjects, CalibrationIsOfThePublishedCovariance) {
  std::vector<TruthObject> truth;
  std::vector<MappedObject> map;
  for (int i = 0; i < 4; ++i) {
    truth.push_back(truthAt(i, Vec3(10.0 * i, 0, 0)));
    map.push_back(predictionAt(i, Vec3(10.0 * i + 0.2, 0, 0)));
    map.back().position_cov = (i < 3 ? 0.04 : 0.0025) * Mat3::Identity();  // 1 and 4 deviations off
  }
  const Calibration c = evaluateObjects(map, truth, 1.0, {}).overall.calibration();
  EXPECT_EQ(c.count, 4u);
  EXPECT_NEAR(c.mean_over_3, (1.0 + 1.0 + 1.0 + 16.0) / 12, 1e-9);
  EXPECT_DOUBLE_EQ(c.inside_90, 0.75);
  EXPECT_NEAR(c.mean_sigma, std::sqrt((3 * 0.04 + 0.0025) / 4), 1e-12);
}

TEST(EvaluateObjects, CalibrationIsOfTheMapsOwnFrame) {
  MappedObject car = predictionAt(1, Vec3::Zero());
  car.position_cov = Vec3(0.04, 1, 1).asDiagonal();
  Pose T_beliefs = Pose::Identity();  // the fit moved the map by -0.4 m along y and turned it by -90 degrees
  T_beliefs.linear() = Eigen::AngleAxisd(M_PI / 2, Vec3::UnitZ()).toRotationMatrix();
  T_beliefs.translation() = Vec3(0, 0.4, 0);
  const auto s = evaluateObjects(std::vector{car}, std::vector{truthAt(1, Vec3::Zero())}, 1.0, {}, T_beliefs).overall;
  EXPECT_NEAR(s.calibration().mean_over_3, 0.16 / 0.04 / 3, 1e-9);
  EXPECT_EQ(s.positionError().max, 0) << "matched where it lies";
}

TEST(EvaluateObjects, CalibrationByPointsIsOfTheExtentOverThePoints) {
  MappedObject car = predictionAt(1, Vec3(0.2, 0, 0));
  car.belief.cov = 4 * Mat3::Identity();
  car.belief.kappa = 400;
  car.position_cov = 0.04 * Mat3::Identity();
  const auto s = evaluateObjects(std::vector{car}, std::vector{truthAt(1, Vec3::Zero())}, 1.0, {}).overall;
  EXPECT_NEAR(s.calibration().mean_over_3, 1.0 / 3, 1e-9);
  EXPECT_NEAR(s.calibrationByPoints().mean_over_3, 4.0 / 3, 1e-9);
  EXPECT_NEAR(s.calibrationByPoints().mean_sigma, 0.1, 1e-12);
}

TEST(EvaluateObjects, DuplicateIsAGhost) {
  const std::vector<TruthObject> truth{truthAt(1, Vec3(0, 0, 0))};
  const std::vector<MappedObject> map{predictionAt(1, Vec3(0.5, 0, 0)), predictionAt(2, Vec3(0.2, 0, 0))};
  const auto s = evaluateObjects(map, truth, 1.0, {}).overall;
  ASSERT_EQ(s.matches.size(), 1u);
  EXPECT_EQ(s.matches[0].prediction, 2);
  EXPECT_EQ(s.ghosts, std::vector<NodeId>{1});
  EXPECT_EQ(s.precision(), 0.5);
  EXPECT_EQ(s.recall(), 1.0);
}

TEST(EvaluateObjects, ClosestPairGoesFirst) {
  // Prediction 1 is nearest to truth 1, but truth 1 has a closer prediction: 1 takes what is left.
  const std::vector<TruthObject> truth{truthAt(1, Vec3(0, 0, 0)), truthAt(2, Vec3(2, 0, 0))};
  const std::vector<MappedObject> map{predictionAt(1, Vec3(0.8, 0, 0)), predictionAt(2, Vec3(-0.1, 0, 0))};
  const auto s = evaluateObjects(map, truth, 1.5, {}).overall;
  ASSERT_EQ(s.matches.size(), 2u);
  EXPECT_EQ(s.matches[0].prediction, 2);
  EXPECT_EQ(s.matches[0].truth, 1);
  EXPECT_EQ(s.matches[1].prediction, 1);
  EXPECT_EQ(s.matches[1].truth, 2);
}

TEST(EvaluateObjects, TieGoesToTheSmallerIds) {
  const std::vector<TruthObject> truth{truthAt(2, Vec3(1, 0, 0)), truthAt(1, Vec3(-1, 0, 0))};
  const std::vector<MappedObject> map{predictionAt(9, Vec3(0, 1, 0)), predictionAt(4, Vec3(0, -1, 0))};
  const auto s = evaluateObjects(map, truth, 2.0, {}).overall;
  ASSERT_EQ(s.matches.size(), 2u);
  EXPECT_EQ(s.matches[0].prediction, 4);
  EXPECT_EQ(s.matches[0].truth, 1);
}

TEST(EvaluateObjects, WrongClassIsBothMissedAndGhost) {
  const std::vector<TruthObject> truth{truthAt(1, Vec3(0, 0, 0))};
  const std::vector<MappedObject> map{predictionAt(1, Vec3(0, 0, 0), kPole)};
  const auto e = evaluateObjects(map, truth, 1.0, {});
  EXPECT_EQ(e.overall.matches.size(), 0u);
  EXPECT_EQ(e.classes.at(kCar).recall(), 0.0);
  EXPECT_EQ(e.classes.at(kPole).precision(), 0.0);
  EXPECT_EQ(e.overall.f1(), 0.0);
  EXPECT_TRUE(std::isnan(e.classes.at(kCar).precision()));
  EXPECT_TRUE(std::isnan(e.overall.positionError().mean));
}

TEST(EvaluateObjects, RadiusIncludesItsEdge) {
  const std::vector<TruthObject> truth{truthAt(1, Vec3(0, 0, 0))};
  EXPECT_EQ(evaluateObjects(std::vector{predictionAt(1, Vec3(0, 1.5, 0))}, truth, 1.5, {}).overall.recall(), 1.0);
  const double beyond = std::nextafter(1.5, 2.0);
  EXPECT_EQ(evaluateObjects(std::vector{predictionAt(1, Vec3(0, beyond, 0))}, truth, 1.5, {}).overall.recall(), 0.0);
}

TEST(EvaluateObjects, DynamicTruthNeitherCountsNorCosts) {
  const std::vector<TruthObject> truth{truthAt(1, Vec3(0, 0, 0)), truthAt(2, Vec3(10, 0, 0), kCar, true),
                                       truthAt(3, Vec3(50, 0, 0), kCar, true)};
  const std::vector<MappedObject> map{predictionAt(1, Vec3(0, 0, 0)), predictionAt(2, Vec3(10.1, 0, 0)),
                                      predictionAt(3, Vec3(10.5, 0, 0))};
  const auto e = evaluateObjects(map, truth, 1.0, {});
  EXPECT_EQ(e.overall.truth, 1u);
  EXPECT_EQ(e.overall.recall(), 1.0);
  ASSERT_EQ(e.dynamic.size(), 1u);
  EXPECT_EQ(e.dynamic[0].prediction, 2);
  EXPECT_EQ(e.overall.predicted, 2u);  // the second node on the moving car is a ghost
  EXPECT_EQ(e.overall.ghosts, std::vector<NodeId>{3});
}

TEST(EvaluateObjects, WhatWasTakenAwayMayBeInTheMapOrNot) {
  std::vector<TruthObject> truth{truthAt(1, Vec3(0, 0, 0)), truthAt(2, Vec3(10, 0, 0))};
  truth[1].gone = true;
  const auto kept =
      evaluateObjects(std::vector{predictionAt(1, Vec3(0, 0, 0)), predictionAt(2, Vec3(10, 0, 0))}, truth, 1.0, {});
  const auto dropped = evaluateObjects(std::vector{predictionAt(1, Vec3(0, 0, 0))}, truth, 1.0, {});
  for (const auto* e : {&kept, &dropped}) {
    EXPECT_EQ(e->overall.recall(), 1.0);
    EXPECT_EQ(e->overall.precision(), 1.0);
  }
}

TEST(EvaluateObjects, DynamicTruthTakesNothingFromStaticTruth) {
  const std::vector<TruthObject> truth{truthAt(1, Vec3(0, 0, 0)), truthAt(2, Vec3(1, 0, 0), kCar, true)};
  const auto e = evaluateObjects(std::vector{predictionAt(1, Vec3(0.9, 0, 0))}, truth, 1.0, {});
  EXPECT_EQ(e.overall.recall(), 1.0);
  EXPECT_TRUE(e.dynamic.empty());
}

TEST(EvaluateObjects, StuffIsLeftOut) {
  const std::vector<MappedObject> map{predictionAt(1, Vec3(0, 0, 0), 40, true), predictionAt(2, Vec3(0, 0, 0))};
  const auto e = evaluateObjects(map, std::vector{truthAt(1, Vec3(0, 0, 0))}, 1.0, {});
  EXPECT_EQ(e.overall.predicted, 1u);
  EXPECT_FALSE(e.classes.contains(40));
}

TEST(MarkThings, GhostsCannotHideAsStuffInAClassOfThings) {
  std::vector<MappedObject> map{predictionAt(1, Vec3(0, 0, 0)), predictionAt(2, Vec3(9, 0, 0), kCar, true),
                                predictionAt(3, Vec3(0, 0, 0), 40, true)};
  const std::vector<TruthObject> truth{truthAt(1, Vec3(0, 0, 0))};
  markThings(map, truth);
  EXPECT_FALSE(map[1].stuff);
  EXPECT_TRUE(map[2].stuff);
  EXPECT_EQ(evaluateObjects(map, truth, 1.0, {}).overall.ghosts, std::vector<NodeId>{2});
}

TEST(EvaluateObjects, OnlyAskedClassesAreLookedAt) {
  const std::vector<TruthObject> truth{truthAt(1, Vec3(0, 0, 0)), truthAt(2, Vec3(5, 0, 0), kPole)};
  const std::vector<MappedObject> map{predictionAt(1, Vec3(0, 0, 0)), predictionAt(2, Vec3(9, 0, 0), kPole)};
  const auto e = evaluateObjects(map, truth, 1.0, {kCar});
  EXPECT_EQ(e.overall.truth, 1u);
  EXPECT_EQ(e.overall.precision(), 1.0);
  EXPECT_EQ(e.classes.size(), 1u);
}

TEST(EvaluateObjects, OrderOfInputDoesNotMatter) {
  std::vector<TruthObject> truth;
  std::vector<MappedObject> map;
  const RandomKey key{11, 0};
  for (int i = 0; i < 40; ++i) {
    const auto c = static_cast<std::uint64_t>(3 * i);
    truth.push_back(truthAt(i, 6.0 * Vec3(uniform(key, c), uniform(key, c + 1), 0)));
    map.push_back(predictionAt(i, 6.0 * Vec3(uniform(key, 1000 + c), uniform(key, 1001 + c), 0)));
  }
  const auto forward = evaluateObjects(map, truth, 1.0, {});
  std::reverse(truth.begin(), truth.end());
  std::reverse(map.begin(), map.end());
  const auto backward = evaluateObjects(map, truth, 1.0, {});
  ASSERT_GT(forward.overall.matches.size(), 10u);
  ASSERT_EQ(forward.overall.matches.size(), backward.overall.matches.size());
  for (std::size_t i = 0; i < forward.overall.matches.size(); ++i) {
    EXPECT_EQ(forward.overall.matches[i].prediction, backward.overall.matches[i].prediction);
    EXPECT_EQ(forward.overall.matches[i].truth, backward.overall.matches[i].truth);
  }
}

TEST(EvaluateObjects, NothingAgainstNothingHasNoScore) {
  const auto s = evaluateObjects({}, {}, 1.0, {}).overall;
  EXPECT_TRUE(std::isnan(s.precision()));
  EXPECT_TRUE(std::isnan(s.recall()));
  EXPECT_TRUE(std::isnan(s.f1()));
}

}  // namespace
}  // namespace hgg::objects_eval_test
