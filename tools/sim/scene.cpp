#include "sim/scene.h"

namespace hgg {

std::vector<std::string> sceneNames() { return {"yard"}; }

std::optional<Scene> makeScene(const std::string& name, std::uint64_t seed) {
  return name == "yard" ? std::optional(makeYard(seed)) : std::nullopt;
}

}  // namespace hgg
