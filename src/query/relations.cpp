#include "query/relations.h"

#include <algorithm>
#include <cmath>

namespace hgg {
namespace {

// Scales by hand, from how things of a room lie to each other; powers on the tuning part of the language scans
// (docs/language.md).
constexpr double kNearScale = 0.4, kNearPower = 7;         // m
constexpr double kClosestScale = 0.25, kClosestPower = 9;  // m
constexpr double kFarPower = 11;
constexpr double kTouch = 0.1;         // m: boxes of things that touch are so far apart at most
constexpr double kHeightNoise = 0.12;  // m: boxes have headboards and backrests
constexpr double kReach = 0.35;        // m: above, below and on are said of what is so far to the side, at most
constexpr double kTurnNoise = 3;       // concentration of directions people say: about 35 degrees
constexpr double kFloor = 0.02;        // what people say and no model follows

double logistic(double x) { return 1 / (1 + std::exp(-x)); }

double floored(double likelihood) { return kFloor + (1 - kFloor) * likelihood; }

double sigmaBetween(const SceneThing& a, const SceneThing& b) { return std::hypot(a.sigma, b.sigma); }

/// Along the ground as nearDistance is in space.
double groundDistance(const SceneThing& a, const SceneThing& b) {
  return groundGapBetween(a, b) + 0.1 * (a.centre - b.centre).head<2>().norm();
}

double bottomOf(const SceneThing& t) { return t.centre.z() - t.half.z(); }
double topOf(const SceneThing& t) { return t.centre.z() + t.half.z(); }

/// That a height difference is above zero, its noise and that of the places included.
double isAboveZero(double height, double sigma) { return logistic(height / std::hypot(kHeightNoise, sigma)); }

}  // namespace

double nearness(double distance, double sigma, double scale, double power) {
  const auto at = [&](double d) { return std::pow(1 + std::max(d, 0.0) / scale, -power); };
  if (sigma < 0.01 * (scale + distance)) {
    return at(distance);
  }
  const double step = std::sqrt(3.0) * sigma;  // Gauss-Hermite with three points
  return at(distance) * 2 / 3 + (at(distance - step) + at(distance + step)) / 6;
}

double nearDistance(const SceneThing& a, const SceneThing& b) {
  return gapBetween(a, b) + 0.1 * (a.centre - b.centre).norm();
}

double likelihoodNear(const SceneThing& thing, const SceneThing& anchor) {
  return nearness(nearDistance(thing, anchor), sigmaBetween(thing, anchor), kNearScale, kNearPower);
}

double likelihoodClosest(const SceneThing& thing, const SceneThing& anchor, double nearest) {
  return nearness(std::max(nearDistance(thing, anchor), nearest), sigmaBetween(thing, anchor), kClosestScale,
                  kClosestPower);
}

double likelihoodFar(const SceneThing& thing, const SceneThing& anchor, double farthest) {
  const double d = std::min(nearDistance(thing, anchor), farthest);
  return std::pow((kClosestScale + d) / (kClosestScale + farthest), kFarPower);
}

double likelihoodOn(const SceneThing& thing, const SceneThing& anchor) {
  const double sigma = sigmaBetween(thing, anchor);
  const double lift = std::max(bottomOf(thing) - topOf(anchor), 0.0);
  const double over = std::sqrt(footprintShare(thing, anchor));
  const double rests =
      over * isAboveZero(thing.centre.z() - anchor.centre.z(), sigma) * nearness(lift, sigma, kTouch, 2);
  const double hangs = 0.3 * nearness(gapBetween(thing, anchor), sigma, kTouch, 3);
  return floored(std::max(rests, hangs));
}

double likelihoodAbove(const SceneThing& thing, const SceneThing& anchor) {
  const double sigma = sigmaBetween(thing, anchor);
  return floored(isAboveZero(thing.centre.z() - topOf(anchor), sigma) *
                 nearness(groundDistance(thing, anchor), sigma, kReach, 3) *
                 nearness(std::max(bottomOf(thing) - topOf(anchor), 0.0), sigma, 1.0, 1));
}

double likelihoodBelow(const SceneThing& thing, const SceneThing& anchor) {
  const double sigma = sigmaBetween(thing, anchor);
  return floored(isAboveZero(bottomOf(anchor) - thing.centre.z(), sigma) *
                 nearness(groundDistance(thing, anchor), sigma, kReach, 3) *
                 nearness(std::max(bottomOf(anchor) - topOf(thing), 0.0), sigma, 1.0, 1));
}

double likelihoodInside(const SceneThing& thing, const SceneThing& anchor) {
  const double share = ((anchor.half + thing.half - (thing.centre - anchor.centre).cwiseAbs()).cwiseMax(0).array() /
                        (2 * thing.half.array()))
                           .cwiseMin(1)
                           .prod();
  return floored(std::max(share, 0.3 * nearness(gapBetween(thing, anchor), sigmaBetween(thing, anchor), kTouch, 2)));
}

double likelihoodWith(const SceneThing& thing, const SceneThing& anchor) {
  const double touches = nearness(gapBetween(thing, anchor), sigmaBetween(thing, anchor), kReach, 3);
  return floored(std::max(likelihoodOn(anchor, thing), 0.8 * touches));
}

double likelihoodBetween(const SceneThing& thing, const SceneThing& a, const SceneThing& b) {
  const Vec2 from = a.centre.head<2>(), along = b.centre.head<2>() - from, at = thing.centre.head<2>() - from;
  const double length = std::max(along.norm(), 0.1);
  const double t = at.dot(along) / (length * length);
  const double aside = std::abs(at.x() * along.y() - at.y() * along.x()) / length;
  const double past = std::max({-t, t - 1, 0.0}) * length;
  const double width = 0.3 + 0.25 * length;  // m
  return floored(std::exp(-std::pow(aside / width, 2) - std::pow(past / 0.3, 2) - 2 * std::pow(t - 0.5, 2)));
}

double likelihoodTowards(const SceneThing& thing, const SceneThing& anchor, const Vec2& towards) {
  const Vec2 offset = (thing.centre - anchor.centre).head<2>();
  const double distance = std::max(offset.norm(), 1e-3);
  // Beside something wide, the direction to its middle says little: what counts is where the thing lies past its edge.
  return floored(std::exp(kTurnNoise * (offset.dot(towards) / distance - 1)));
}

double likelihoodBeside(const SceneThing& thing, const SceneThing& anchor, const Vec2& towards) {
  return likelihoodTowards(thing, anchor, towards) *
         nearness(gapBetween(thing, anchor), sigmaBetween(thing, anchor), 1.0, 1.5);
}

}  // namespace hgg
