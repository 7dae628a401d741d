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

const std::map<std::string, Maker>& makers() {
  static const std::map<std::string, Maker> kMakers = {{"yard", &still<makeYard>},
                                                       {"stairs", &still<makeStairs>},
                                                       {"ramp", &still<makeRamp>},
                                                       {"hole", &still<makeHole>},
                                                       {"bridge", &still<makeBridge>},
                                                       {"walk", &still<makeWalk>},
                                                       {"street", &makeStreet},
                                                       {"campus", &makeCampus},
                                                       {"apartment", &makeApartment},
                                                       {"office", &makeOffice},
                                                       {"hall", &makeHall},
                                                       {"corridor", &makeCorridor}};
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

std::optional<Scene> makeScene(const std::string& name, std::uint64_t seed, double dynamics) {
  const auto maker = makers().find(name);
  return maker == makers().end() ? std::nullopt : std::optional(maker->second(seed, dynamics));
}

}  // namespace hgg
