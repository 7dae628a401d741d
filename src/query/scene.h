#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "traversability/map_leaves.h"

namespace hgg {

using Vec2 = Eigen::Vector2d;

/// How near and closest are judged. Maps are asked with kSurfaces; the others are there to be measured against it
/// (docs/language.md): neighbours of the anchor in the graph first, in the order of their edge weights, as the paper
/// does, or the order of the middles' distances.
enum class NearnessRule : std::uint8_t { kSurfaces, kEdges, kCentroids };

/// A thing of the map as queries see it. Metres, in the frame of the scene (QueryScene::yaw); z is up.
struct SceneThing {
  NodeId id = 0;
  ClassId label = 0;
  bool stuff = false;
  ClassWeights classes;        // probabilities
  Vec3 centre = Vec3::Zero();  // of its box
  Vec3 half = Vec3::Zero();    // half the edges of its box, along the axes of the scene
  double sigma = 0;            // how well its place is known: standard deviation along one axis, to its neighbours
  double existence = 1;
  std::optional<Vec3> lab;        // colour: CIE L*a*b*
  std::optional<Vec2> front;      // unit vector to the side it is used from
  std::optional<Vec2> seen_from;  // unit vector to where it was first seen from
  std::map<int, double> edges;    // to its neighbours in the graph, by index in the scene: their weights (addEdges)
};

/// What queries are asked about: the confirmed nodes of a map, made once for many queries.
struct QueryScene {
  double yaw = 0;  // rad: the scene is the map turned back by this, so that most walls lie along its axes and boxes fit
  std::vector<SceneThing> things;                // ascending by id
  std::map<ClassId, std::vector<int>> of_class;  // things that may well be of the class
  std::map<ClassId, std::string> class_names;
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  // the box of all things
  Vec2 middle = Vec2::Zero();                    // of the things
  NearnessRule nearness = NearnessRule::kSurfaces;
};

QueryScene sceneOf(const MapLeaves& map, const std::map<ClassId, std::string>& class_names);
QueryScene sceneOf(const Map& map);
/// The relative neighbourhood graph of the things, which NearnessRule::kEdges asks for. Not the map's own: there most
/// neighbours of a thing are tiles of floor and wall.
void addEdges(const Map& map, QueryScene& scene);

/// Shortest way between the boxes of two things, m; 0 when they touch or overlap.
double gapBetween(const SceneThing& a, const SceneThing& b);
/// The same along the ground.
double groundGapBetween(const SceneThing& a, const SceneThing& b);
/// What share of a's footprint lies over b's, 0..1.
double footprintShare(const SceneThing& a, const SceneThing& b);

/// CIE L*a*b* (D65) of an sRGB colour.
Vec3 labOf(const std::array<std::uint8_t, 3>& rgb);

}  // namespace hgg
