#include "convert/label_ids.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>

namespace hgg {
namespace {

constexpr std::size_t kFramesLookedAt = 50;

/// learning_map_inv of semantic-kitti.yaml.
constexpr std::array<ClassId, 20> kRawIds = {0,  10, 11, 15, 18, 20, 30, 31, 32, 40,
                                             44, 48, 49, 50, 51, 70, 71, 72, 80, 81};
/// Raw ids that are no greater than the greatest training id; 19 and the others below are no raw ids.
constexpr std::array<ClassId, 8> kSmallRawIds = {0, 1, 10, 11, 13, 15, 16, 18};

}  // namespace

bool hasLearningIds(std::span<const KittiFrame> frames) {
  bool any_foreign = false;
  const std::size_t every = std::max<std::size_t>(1, frames.size() / kFramesLookedAt);
  for (std::size_t i = 0; i < frames.size(); i += every) {
    std::ifstream in(frames[i].labels, std::ios::binary);
    std::uint32_t word = 0;
    while (in.read(reinterpret_cast<char*>(&word), sizeof(word))) {
      const auto label = static_cast<ClassId>(word & 0xffff);
      if (label >= kRawIds.size()) {
        return false;
      }
      any_foreign |= std::ranges::find(kSmallRawIds, label) == kSmallRawIds.end();
    }
  }
  return any_foreign;
}

ClassId rawOfLearningId(ClassId learning_id) {
  return learning_id < kRawIds.size() ? kRawIds[learning_id] : learning_id;
}

}  // namespace hgg
