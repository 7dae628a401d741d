#pragma once

#include <optional>

#include "query/request.h"
#include "query/scene.h"

namespace hgg {

/// How likely people say a relation of a thing and its anchor, above 0, at most 1: the floor is what people say that a
/// model does not follow. All are functions of boxes; where a distance decides, how well the places are known is
/// integrated over (expectedOver).

/// (1 + d / scale)^-power, for a distance d with standard deviation sigma: what is meant by near falls off with
/// distance as a power, since people judge distances by their ratios.
double nearness(double distance, double sigma, double scale, double power);

/// Distance that "near" and "closest" judge: that of the surfaces, and a tenth of that of the middles, which decides
/// between things that touch the anchor.
double nearDistance(const SceneThing& a, const SceneThing& b);

double likelihoodNear(const SceneThing& thing, const SceneThing& anchor);
/// Closest and farthest of those that could be meant: what is nearer than the nearest of them (m), or farther than the
/// farthest, is so by what it is not.
double likelihoodClosest(const SceneThing& thing, const SceneThing& anchor, double nearest = 0);
double likelihoodFar(const SceneThing& thing, const SceneThing& anchor, double farthest);
double likelihoodOn(const SceneThing& thing, const SceneThing& anchor);
double likelihoodAbove(const SceneThing& thing, const SceneThing& anchor);
double likelihoodBelow(const SceneThing& thing, const SceneThing& anchor);
double likelihoodInside(const SceneThing& thing, const SceneThing& anchor);
double likelihoodWith(const SceneThing& thing, const SceneThing& anchor);
double likelihoodBetween(const SceneThing& thing, const SceneThing& a, const SceneThing& b);
/// In the direction `towards` (unit vector) from the anchor.
double likelihoodTowards(const SceneThing& thing, const SceneThing& anchor, const Vec2& towards);
/// In the direction and not far along it.
double likelihoodBeside(const SceneThing& thing, const SceneThing& anchor, const Vec2& towards);

}  // namespace hgg
