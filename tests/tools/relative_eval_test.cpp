#include <gtest/gtest.h>

#include "eval/relative.h"
#include "map/test_map.h"

namespace hgg::relative_eval_test {
namespace {

constexpr ClassId kCar = 10;

TruthObject truthAt(std::int64_t id, const Vec3& mean) {
  TruthObject object;
  object.id = id, object.label = kCar;
  object.belief.mean = mean;
  return object;
}

std::vector<ObjectMatch> matchesOf(const std::vector<std::pair<NodeId, std::int64_t>>& pairs) {
  std::vector<ObjectMatch> matches;
  for (const auto& [prediction, truth] : pairs) {
    matches.emplace_back();
    matches.back().prediction = prediction, matches.back().truth = truth;
  }
  return matches;
}

TEST(RelativeCalibration, IsOfDifferencesSoThatWhatAllHaveDriftedAlikeDoesNotCount) {
  const Vec3 drifted(5, -3, 1);
  const std::vector<TruthObject> truth{truthAt(11, Vec3(0, 0, 0)), truthAt(12, Vec3(10, 0, 0)),
                                       truthAt(13, Vec3(0, 20, 0))};
  const Map map = mapOf({nodeAt(kCar, drifted), nodeAt(kCar, drifted + Vec3(10, 0.3, 0)),
                         nodeAt(kCar, drifted + Vec3(0, 20, 0)), nodeAt(kCar, Vec3(0, 0, 0))});
  const auto matches = matchesOf({{1, 11}, {2, 12}, {3, 13}});
  const Calibration c = relativeCalibration(map, matches, truth, Mat3::Identity(), 30);
  ASSERT_EQ(c.count, 3U);
  const double variance = 2 * positionCovariance(*map.find(1))(0, 0);
  EXPECT_NEAR(c.mean_over_3, 2 * 0.09 / variance / 9, 1e-9) << "two of the three pairs have the second";
  EXPECT_NEAR(c.mean_sigma, std::sqrt(variance), 1e-9);
  EXPECT_EQ(relativeCalibration(map, matches, truth, Mat3::Identity(), 15).count, 1U);
  EXPECT_EQ(relativeCalibration(map, {}, truth, Mat3::Identity(), 30).count, 0U);
}

TEST(RelativeCalibration, TurnsTheMapIntoTheTruth) {
  const Mat3 R = Eigen::AngleAxisd(M_PI / 2, Vec3::UnitZ()).toRotationMatrix();
  const std::vector<TruthObject> truth{truthAt(11, Vec3(0, 0, 0)), truthAt(12, Vec3(0, 10, 0))};
  const Map map = mapOf({nodeAt(kCar, Vec3(0, 0, 0)), nodeAt(kCar, Vec3(10, 0, 0))});
  EXPECT_NEAR(relativeCalibration(map, matchesOf({{1, 11}, {2, 12}}), truth, R, 30).mean_over_3, 0, 1e-20);
}

}  // namespace
}  // namespace hgg::relative_eval_test
