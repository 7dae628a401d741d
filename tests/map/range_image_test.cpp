#include "map/range_image.h"

#include <gtest/gtest.h>

#include <limits>

namespace hgg::range_image_test {
namespace {

/// A sensor at the origin before walls at these depths (m) along x: beams every quarter of a degree, to 20 degrees
/// around. A wall reaches from `left` to `right` (slopes).
struct Wall {
  double depth = 20, right = -1, left = 1;
};

RangeImage imageOf(const std::vector<Wall>& walls) {
  RangeImage image(Vec3::Zero());
  constexpr double kStep = 0.00436;
  for (int row = -80; row <= 80; ++row) {
    for (int column = -80; column <= 80; ++column) {
      const double u = kStep * column, v = kStep * row;
      double depth = std::numeric_limits<double>::infinity();
      for (const Wall& wall : walls) {
        depth = u >= wall.right && u <= wall.left ? std::min(depth, wall.depth) : depth;
      }
      if (std::isfinite(depth)) {
        image.add(static_cast<float>(depth), static_cast<float>(depth * u), static_cast<float>(depth * v));
      }
    }
  }
  return image;
}

const Vec3 kPlace(10, 0.5, 0.2);

Mat3 solid(double deviation) { return deviation * deviation * Mat3::Identity(); }

TEST(RangeImage, BeamsThatEndBehindAThingPassIt) {
  const BeamCount beams = imageOf({{20}}).beamsAt(kPlace, solid(0.2), 0.03);
  EXPECT_GT(beams.through, 5);
  EXPECT_EQ(beams.hits, 0);
  EXPECT_EQ(beams.hidden, 0);
}

TEST(RangeImage, ASurfaceAtThePlaceHidesWhatIsBehindIt) {
  const BeamCount beams = imageOf({{20}, {10}}).beamsAt(kPlace, solid(0.2), 0.03);
  EXPECT_EQ(beams.through, 0);
  EXPECT_GT(beams.hits, 5);
}

TEST(RangeImage, WhatIsJustBehindIsNoFreeSpace) {
  EXPECT_EQ(imageOf({{10.4}}).beamsAt(kPlace, solid(0.2), 0.03).through, 0);
}

TEST(RangeImage, BehindANearerThingNothingIsSeenThrough) {
  const BeamCount beams = imageOf({{20}, {5}}).beamsAt(kPlace, solid(0.2), 0.03);
  EXPECT_EQ(beams.through, 0);
  EXPECT_EQ(beams.hits, 0);
  EXPECT_GT(beams.hidden, 5);
}

TEST(RangeImage, OutOfViewAndWithoutReturnsThereAreNoBeams) {
  for (const Vec3& place : {Vec3(-10, 0, 0), Vec3(0, 10, 0), Vec3(10, 0, 30), Vec3(0.1, 0, 0)}) {
    const BeamCount beams = imageOf({{20}}).beamsAt(place, solid(0.1), 0.03);
    EXPECT_EQ(beams.through + beams.hits + beams.hidden, 0) << place.transpose();
  }
  EXPECT_EQ(imageOf({{20, -0.3, -0.2}}).beamsAt(kPlace, solid(0.2), 0.03).through, 0) << "no returns there";
}

TEST(RangeImage, BeamsBesideAThinThingCountLittle) {
  const RangeImage image = imageOf({{20}});
  Mat3 pole = solid(0.012);
  pole(2, 2) = 0.04;
  const double thin = image.beamsAt(kPlace, pole, 0.05).through,
               thick = image.beamsAt(kPlace, solid(0.2), 0.05).through;
  EXPECT_GT(thin, 0);
  EXPECT_LT(thin, 0.1 * thick) << "a tenth of the width, and where it is is not known to its width";
}

TEST(RangeImage, EveryFaceSeesTheSame) {
  const BeamCount front = imageOf({{20}}).beamsAt(kPlace, solid(0.2), 0.03);
  for (int turns = 1; turns < 4; ++turns) {
    const Mat3 R = Eigen::AngleAxisd(turns * std::acos(0.0), Vec3::UnitZ()).toRotationMatrix();
    RangeImage image(Vec3::Zero());
    for (int row = -80; row <= 80; ++row) {
      for (int column = -80; column <= 80; ++column) {
        const Vec3 p = R * Vec3(20, 20 * 0.00436 * column, 20 * 0.00436 * row);
        image.add(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()));
      }
    }
    EXPECT_NEAR(image.beamsAt(R * kPlace, solid(0.2), 0.03).through, front.through, 0.1 * front.through) << turns;
  }
}

TEST(RangeImage, PointsThatAreNoNumbersAreLeftOut) {
  RangeImage image(Vec3::Zero());
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kFar = std::numeric_limits<float>::infinity();
  for (const float v : {kNan, kFar, -kFar}) {
    image.add(v, 1, 1), image.add(1, v, 1), image.add(1, 1, v), image.add(v, v, v);
  }
  EXPECT_EQ(image.beamsAt(Vec3(0.7, 0.7, 0.7), solid(0.05), 0.01).hidden, 0);
}

}  // namespace
}  // namespace hgg::range_image_test
