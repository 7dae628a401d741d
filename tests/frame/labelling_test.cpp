#include "frame/labelling.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "frame/rig_scene.h"

namespace hgg::labelling_test {
namespace {

using rig_scene::kCar, rig_scene::kRoad, rig_scene::kWall;

/// A wall 10 m ahead, and a box of 2 x 2 m before it at 5 m, both sampled every 5 cm.
std::vector<Point> wallPoints() { return rig_scene::face(10, 4); }
std::vector<Point> boxPoints() { return rig_scene::face(5, 1); }

constexpr double kBaseline = 0.5;  // m: as if the LiDAR sat so far beside the camera

RigCamera camera(int margin) {
  RigCamera camera = rig_scene::camera("front", 0);
  camera.margin = margin;
  return camera;
}

/// What the camera sees of the two: the box over the wall; the box's mask grown by `bleed` pixels.
LabelImage image(const RigCamera& camera, int bleed = 0) {
  LabelImage image = rig_scene::blank(camera, kWall);
  const double f = camera.model.fx;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (std::max(std::abs(x - camera.model.cx), std::abs(y - camera.model.cy)) <= f / 5 + 0.5 + bleed) {
        image.labels[image.at(x, y)] = kCar;
      }
    }
  }
  return image;
}

LabelReport label(std::vector<Point>& points, const RigCamera& camera, const LabelImage& image) {
  const LabelView view{&camera, &image, 0, camera.T_body_camera.inverse(), kBaseline};
  return labelPoints(points, std::span(&view, 1), {});
}

std::int64_t count(const std::vector<Point>& points, float x, ClassId label) {
  return std::ranges::count_if(points, [&](const Point& p) { return p.x == x && p.label == label; });
}

std::vector<Point> both() {
  std::vector<Point> points = wallPoints();
  const auto box = boxPoints();
  points.insert(points.end(), box.begin(), box.end());
  return points;
}

TEST(Labelling, APointTakesTheLabelOfItsPixel) {
  const RigCamera c = camera(0);
  std::vector<Point> points = {{5, 0, 0, 0, 0}, {10, 3, 0, 0, 0}, {-5, 0, 0, 0, 0}, {1, 30, 0, 0, 7}};
  const LabelReport report = label(points, c, image(c));
  EXPECT_EQ(points[0].label, kCar);
  EXPECT_EQ(points[1].label, kWall);
  EXPECT_EQ(points[2].label, kUnknownClass);  // behind
  EXPECT_EQ(points[3].label, kUnknownClass);  // beside
  EXPECT_EQ(report.all.points, 4);
  EXPECT_EQ(report.all.seen, 2);
  EXPECT_EQ(report.all.labelled, 2);
}

TEST(Labelling, APointBehindANearerSurfaceTakesNoLabelFromIt) {
  const RigCamera c = camera(0);
  std::vector<Point> points = both();
  label(points, c, image(c));
  EXPECT_EQ(count(points, 5, kCar), std::ssize(boxPoints()));
  // The wall behind the box's mask: hidden, but for a rim as wide as two cells, where the box is not on all sides.
  std::int64_t inside = 0;
  for (const Point& p : points) {
    if (p.x == 10 && std::max(std::abs(p.y), std::abs(p.z)) < 1.6F) {
      ++inside;
      EXPECT_EQ(p.label, kUnknownClass) << p.y << ", " << p.z;
    }
  }
  EXPECT_GT(inside, 3000);
}

TEST(Labelling, ASlantedSurfaceDoesNotHideItself) {
  const RigCamera c = camera(0);
  std::vector<Point> ground;
  for (float x = 2; x < 40; x *= 1.03F) {
    for (float y = -x / 2; y < x / 2; y += x / 200) {
      ground.push_back({x, y, -1, 0, 0});
    }
  }
  const LabelReport report = label(ground, c, rig_scene::blank(c, kRoad));
  EXPECT_GT(report.all.seen, 5000);
  EXPECT_EQ(report.all.hidden, 0);
  EXPECT_EQ(report.all.labelled, report.all.seen);
}

TEST(Labelling, NearABorderTheDepthUndoesWhatHasBled) {
  const LabelImage bled = image(camera(0), 2);
  std::vector<Point> blind = both();
  std::erase_if(blind, [](const Point& p) {  // what the LiDAR sees past the box
    return p.x == 10 && std::max(std::abs(p.y), std::abs(p.z)) < 2.05F;
  });
  std::vector<Point> careful = blind;
  label(blind, camera(0), bled);
  label(careful, camera(3), bled);
  const std::int64_t wrong_blind = count(blind, 10, kCar), wrong_careful = count(careful, 10, kCar);
  EXPECT_GT(wrong_blind, 200);
  EXPECT_LE(wrong_careful, wrong_blind / 50);
  EXPECT_EQ(count(careful, 5, kCar), std::ssize(boxPoints()));
}

TEST(Labelling, WhatIsThinnerThanTheMarginKeepsItsLabel) {
  const RigCamera c = camera(3);
  LabelImage image = rig_scene::blank(c, kWall);
  for (int y = 0; y < image.height; ++y) {
    image.labels[image.at(160, y)] = kCar;  // a pole, one pixel wide
  }
  std::vector<Point> points = wallPoints();
  const auto wall = points.size();
  for (float z = -1; z < 1; z += 0.02F) {
    points.push_back({4, 0, z, 0, 0});
  }
  label(points, c, image);
  for (std::size_t i = wall; i < points.size(); ++i) {
    EXPECT_EQ(points[i].label, kCar);
  }
}

TEST(Labelling, OfTwoCamerasTheSurerOneIsBelieved) {
  const RigCamera c = camera(0);
  LabelImage sure = rig_scene::blank(c, kCar), unsure = rig_scene::blank(c, kWall);
  sure.confidence.assign(sure.labels.size(), 200);
  unsure.confidence.assign(unsure.labels.size(), 100);
  const std::vector<LabelView> views = {{&c, &unsure, 0, c.T_body_camera.inverse()},
                                        {&c, &sure, 1, c.T_body_camera.inverse()}};
  std::vector<Point> points = {{5, 0, 0, 0, 0}};
  labelPoints(points, views, {});
  EXPECT_EQ(points[0].label, kCar);
  const std::vector<LabelView> three = {views[0], views[1], views[0], views[0]};  // 3 x 100 against 200
  labelPoints(points, three, {});
  EXPECT_EQ(points[0].label, kWall);
}

TEST(Labelling, PixelsOfTooLittleConfidenceHaveNoSay) {
  const RigCamera c = camera(0);
  LabelImage image = rig_scene::blank(c, kCar);
  image.confidence.assign(image.labels.size(), 100);
  std::vector<Point> points = {{5, 0, 0, 0, 0}};
  const LabelView view{&c, &image, 0, c.T_body_camera.inverse()};
  const LabelReport report = labelPoints(points, std::span(&view, 1), {0, 0.5});
  EXPECT_EQ(points[0].label, kUnknownClass);
  EXPECT_EQ(report.all.unsure, 1);
}

TEST(Labelling, NumbersOutsideTheLabelSetAreNoClassAndCounted) {
  const RigCamera c = camera(0);
  std::vector<Point> points = {{5, 0, 0, 0, 0}};
  const LabelReport report = label(points, c, rig_scene::blank(c, 9999));
  EXPECT_EQ(points[0].label, kUnknownClass);
  EXPECT_EQ(report.views[0].foreign, 1);
}

TEST(Labelling, InstancesOfTwoCamerasStayApartAndCutOnesAreLeftToClustering) {
  const RigCamera c = camera(0);
  LabelImage a = rig_scene::blank(c, kCar), b = a;
  a.instances.assign(a.labels.size(), 3);  // touches the edge
  b.instances.assign(b.labels.size(), 0);
  b.instances[b.at(160, 120)] = 3;
  std::vector<Point> points = {{5, 0, 0, 0, 0}};
  const std::vector<LabelView> only_a = {{&c, &a, 0, c.T_body_camera.inverse()}};
  labelPoints(points, only_a, {});
  EXPECT_NE(points[0].instance, 0U);  // of one camera there is no other half
  const std::uint32_t of_a = points[0].instance;
  const std::vector<LabelView> two = {{&c, &b, 1, c.T_body_camera.inverse()}, {&c, &a, 0, c.T_body_camera.inverse()}};
  labelPoints(points, two, {});
  EXPECT_NE(points[0].instance, 0U);
  EXPECT_NE(points[0].instance, of_a);
  const std::vector<LabelView> cut = {{&c, &a, 0, c.T_body_camera.inverse()}, {&c, &a, 1, c.T_body_camera.inverse()}};
  labelPoints(points, cut, {});
  EXPECT_EQ(points[0].instance, 0U);
}

TEST(Labelling, PointsThatAreNoNumbersDoNoHarm) {
  const RigCamera c = camera(2);
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  std::vector<Point> points = {{nan, 0, 0, 0, 0}, {inf, 0, 0, 0, 0}, {0, 0, 0, 0, 0}, {1e30F, 1, 1, 0, 0}};
  label(points, c, image(c));
  EXPECT_EQ(points[0].label, kUnknownClass);
}

}  // namespace
}  // namespace hgg::labelling_test
