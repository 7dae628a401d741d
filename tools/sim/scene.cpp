#include "sim/scene.h"

#include <map>

namespace hgg {
namespace {

using Maker = Scene (*)(std::uint64_t seed, double dynamics);

/// For worlds in which nothing moves.
template <Scene (*make)(std::uint64_t)>
Scene still(std::uint64_t seed, double /*dynamics*/) {
  return make(seed);
}

/// For worlds that can have plates, without them.
template <Scene (*make)(std::uint64_t, double, bool)>
Scene plain(std::uint64_t seed, double dynamics) {
  return make(seed, dynamics, false);
}

const std::map<std::string, Maker>& makers() {
  static const std::map<std::string, Maker> kMakers = {{"yard", &still<makeYard>},
                                                       {"stairs", &still<makeStairs>},
                                                       {"ramp", &still<makeRamp>},
                                                       {"hole", &still<makeHole>},
                                                       {"bridge", &still<makeBridge>},
                                                       {"walk", &still<makeWalk>},
                                                       {"street", &plain<makeStreet>},
                                                       {"campus", &plain<makeCampus>},
                                                       {"apartment", &makeApartment},
                                                       {"office", &makeOffice},
                                                       {"hall", &makeHall},
                                                       {"corridor", &makeCorridor},
                                                       {"passes", &makePasses}};
  return kMakers;
}

}  // namespace

std::vector<std::string> sceneNames() {
  std::vector<std::string> names;
  for (const auto& [name, maker] : makers()) {
    names.push_back(name);
  }
  return names;
}

bool hasPlates(const std::string& name) { return name == "street" || name == "campus"; }

std::optional<Scene> makeScene(const std::string& name, std::uint64_t seed, double dynamics, bool plates) {
  if (plates && hasPlates(name)) {
    return name == "street" ? makeStreet(seed, dynamics, true) : makeCampus(seed, dynamics, true);
  }
  const auto maker = makers().find(name);
  return maker == makers().end() ? std::nullopt : std::optional(maker->second(seed, dynamics));
}

}  // namespace hgg
