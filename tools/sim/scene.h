#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sim/world.h"

namespace hgg {

/// A world and the way a sensor takes through it.
struct Scene {
  World world;
  std::function<Pose(double time)> T_world_body;
};

/// Names makeScene() knows.
std::vector<std::string> sceneNames();
/// nullopt when there is no world of that name. The seed varies the placement of objects.
std::optional<Scene> makeScene(const std::string& name, std::uint64_t seed);

/// "yard": a house and trees inside a loop road, parked cars, bicycles, poles, signs, trees and houses around it. One
/// lap of the oval takes 20 s, at 3 to 5 m/s.
Scene makeYard(std::uint64_t seed);

}  // namespace hgg
