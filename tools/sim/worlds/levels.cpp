#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "sim/worlds/grounds.h"

namespace hgg {
namespace {

double atHeight(double /*s*/) { return 0.0; }

/// Footprint of a rectangle along the axes.
Footprint rectangle(double x0, double y0, double x1, double y1) {
  return {Vec2(0.5 * (x0 + x1), 0.5 * (y0 + y1)), Vec2(0.5 * (x1 - x0), 0.5 * (y1 - y0)), 0.0};
}

void addFlatFloor(Scene& scene, const Hall& hall) {
  addBlocks(scene.world, objectOf(Indoor::kFloor), {hall.lo.x(), hall.hi.x()}, {hall.lo.y(), hall.hi.y()},
            [](const Vec2& /*p*/) { return 0.0; });
}

/// The way's height where it passes along x through the strip |y - middle| < half, which `profile` (by x) describes.
std::function<double(double)> alongStrip(const std::vector<Vec2>& corners, double middle, double half,
                                         const std::function<double(double x)>& profile) {
  return [way = hallTravel(corners).way(), middle, half, profile](double s) {
    const WayPoint at = way.at(s);
    const bool is_on = std::abs(at.position.y() - middle) < half && std::abs(at.along.x()) > std::abs(at.along.y());
    return is_on ? profile(at.position.x()) : 0.0;
  };
}

double ramp(double x, double foot, double head, double height) {
  return height * std::clamp((x - foot) / (head - foot), 0.0, 1.0);
}

}  // namespace

Scene makeStairs(std::uint64_t seed) {
  constexpr double kRise = 0.16, kRun = 0.30;  // m, as in public buildings
  constexpr int kSteps = 9;
  constexpr double kHeight = kSteps * kRise, kFoot = 3.0, kTop = kFoot + kSteps * kRun, kEnd = 11.0, kRampFoot = 15.0;
  constexpr double kMiddle = 8.0, kHalfWidth = 1.0;
  const Hall hall{{0.0, 0.0}, {20.0, 12.0}};
  const std::vector<Vec2> corners{{9.0, 3.0}, {1.3, 3.0}, {1.3, kMiddle}, {17.5, kMiddle}, {17.5, 3.0}};
  const auto profile = [](double x) {
    return x < kEnd ? ramp(x, kFoot - kRun, kTop - kRun, kHeight) : ramp(x, kRampFoot, kEnd, kHeight);
  };
  Scene scene = makeHallScene(hall, corners, alongStrip(corners, kMiddle, kHalfWidth, profile),
                              {rectangle(kFoot, kMiddle - 2.0, kRampFoot, kMiddle + 2.0)}, seed);
  addFlatFloor(scene, hall);
  const double south = kMiddle - kHalfWidth, north = kMiddle + kHalfWidth;
  Shapes steps;
  for (int i = 0; i < kSteps; ++i) {
    steps.push_back(block(kFoot + (i + 0.5) * kRun, kMiddle, 0.0, kRun, north - south, (i + 1) * kRise));
  }
  addObject(scene.world, objectOf(Indoor::kStairs), steps);
  addObject(scene.world, objectOf(Indoor::kFloor),
            {block(0.5 * (kTop + kEnd), kMiddle, 0.0, kEnd - kTop, 2.0 * (north - south), kHeight),
             rampBox({kRampFoot, kMiddle, 0.0}, {kEnd, kMiddle, kHeight}, north - south)});
  return scene;
}

Scene makeRamp(std::uint64_t seed) {
  constexpr double kHeight = 0.9, kHalfTop = 0.6, kWidth = 2.4;
  const Hall hall{{0.0, 0.0}, {20.0, 13.0}};
  struct Ridge {
    double x, y, slope_deg;
    double run() const { return kHeight / std::tan(slope_deg * kDegree); }
  };
  const Ridge ridges[] = {{10.0, 10.0, 12.0}, {10.0, 3.0, 25.0}, {10.0, 6.5, 40.0}};
  const std::vector<Vec2> corners{{3.5, 3.0}, {18.0, 3.0}, {18.0, 10.0}, {1.8, 10.0}, {1.8, 3.0}};
  const auto height = [&ridges](const Ridge& ridge) {
    return [ridge](double x) { return ramp(-std::abs(x - ridge.x), -kHalfTop - ridge.run(), -kHalfTop, kHeight); };
  };
  const auto south = alongStrip(corners, ridges[1].y, 0.5 * kWidth, height(ridges[1]));
  const auto north = alongStrip(corners, ridges[0].y, 0.5 * kWidth, height(ridges[0]));
  std::vector<Footprint> taken;
  for (const Ridge& r : ridges) {
    taken.push_back({{r.x, r.y}, {kHalfTop + r.run(), 0.5 * kWidth}, 0.0});
  }
  Scene scene = makeHallScene(
      hall, corners, [=](double s) { return std::max(south(s), north(s)); }, taken, seed);
  addFlatFloor(scene, hall);
  for (const Ridge& r : ridges) {
    Shapes shapes{block(r.x, r.y, 0.0, 2.0 * kHalfTop, kWidth, kHeight)};
    for (const double side : {-1.0, 1.0}) {
      shapes.push_back(
          rampBox({r.x + side * (kHalfTop + r.run()), r.y, 0.0}, {r.x + side * kHalfTop, r.y, kHeight}, kWidth));
    }
    addObject(scene.world, objectOf(Indoor::kFloor), shapes);
  }
  return scene;
}

Scene makeHole(std::uint64_t seed) {
  constexpr double kDock = 15.0;  // x: beyond it the floor is lower
  const Hall hall{{0.0, 0.0}, {19.0, 12.0}};
  const Footprint pit = rectangle(4.0, 5.0, 6.0, 7.0), trench = rectangle(9.0, 4.0, 9.5, 8.0),
                  dock = rectangle(kDock, 0.0, 19.0, 12.0);
  const std::vector<Vec2> corners{{7.5, 3.0}, {13.5, 3.0}, {13.5, 9.0}, {7.5, 9.0}, {1.8, 9.0}, {1.8, 3.0}};
  Scene scene = makeHallScene(hall, corners, &atHeight, {pit, trench, dock}, seed);
  const auto height = [&](const Vec2& p) {
    const auto is_in = [&](const Footprint& f) { return ((p - f.center).cwiseAbs().array() < f.half.array()).all(); };
    return is_in(pit) ? -0.8 : is_in(trench) ? -0.6 : is_in(dock) ? -0.5 : 0.0;
  };
  addBlocks(scene.world, objectOf(Indoor::kFloor), {0.0, 4.0, 6.0, 9.0, 9.5, kDock, 19.0},
            {0.0, 4.0, 5.0, 7.0, 8.0, 12.0}, height);
  return scene;
}

Scene makeBridge(std::uint64_t seed) {
  constexpr double kHeight = 1.6, kMiddle = 6.0, kWidth = 1.8, kDeck = 0.15;
  constexpr double kFoot = 2.4, kStart = 6.4, kEnd = 11.6, kOtherFoot = 15.6;
  const Hall hall{{-1.0, 0.0}, {19.0, 12.0}};
  const std::vector<Vec2> corners{{9.0, 2.0}, {9.0, 10.0}, {0.6, 10.0}, {0.6, kMiddle}, {17.4, kMiddle}, {17.4, 2.0}};
  const auto profile = [](double x) {
    return std::min(ramp(x, kFoot, kStart, kHeight), ramp(x, kOtherFoot, kEnd, kHeight));
  };
  Scene scene = makeHallScene(hall, corners, alongStrip(corners, kMiddle, 0.5 * kWidth, profile),
                              {rectangle(kFoot, kMiddle - 0.5 * kWidth, kOtherFoot, kMiddle + 0.5 * kWidth)}, seed);
  addFlatFloor(scene, hall);
  addObject(scene.world, objectOf(Indoor::kFloor),
            {block(0.5 * (kStart + kEnd), kMiddle, kHeight - kDeck, kEnd - kStart, kWidth, kDeck),
             rampBox({kFoot, kMiddle, 0.0}, {kStart, kMiddle, kHeight}, kWidth),
             rampBox({kOtherFoot, kMiddle, 0.0}, {kEnd, kMiddle, kHeight}, kWidth)});
  return scene;
}

}  // namespace hgg
