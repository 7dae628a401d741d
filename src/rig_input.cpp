#include "rig_input.h"

#include <utility>

#include "core/units.h"
#include "frame/motion.h"

namespace hgg {
namespace {

LabellingOptions optionsOf(const Config& config) {
  return {config.creation.beam_spacing_deg * kDegree, config.frame.min_confidence};
}

}  // namespace

Config configFor(const Rig& rig, Config config) {
  config.lcm.lidar_semantic = cloudSources(rig).front().channel;
  return config;
}

Result<std::optional<Rig>> takeRig(LoadedConfig& loaded) {
  using Taken = Result<std::optional<Rig>>;
  if (loaded.rig_path.empty()) {
    return Taken::ok(std::nullopt);
  }
  auto rig = loadRig(loaded.rig_path, loaded.classes);
  if (!rig) {
    return Taken::fail(rig.error);
  }
  loaded.config = configFor(*rig, std::move(loaded.config));
  loaded.classes = loaded.classes.withUnknown();
  return Taken::ok(std::move(*rig));
}

RigInput::RigInput(const Rig& rig, const Config& config)
    : assembler_(rig, optionsOf(config), [](Bytes message) { return decodeLabelImage(message); }),
      sources_(cloudSources(assembler_.rig())) {
  for (std::size_t k = 0; k < sources_.size(); ++k) {
    depth_.push_back(sources_[k].camera != nullptr ? std::optional<DepthToCloud>(*sources_[k].camera) : std::nullopt);
    if (k > 0) {
      sides_[sources_[k].channel] = {k, std::nullopt};
    }
  }
  for (std::size_t k = 0; k < assembler_.rig().cameras.size(); ++k) {
    sides_[assembler_.rig().cameras[k].labels] = {std::nullopt, k};
  }
}

std::vector<std::string> RigInput::sideChannels() const {
  std::vector<std::string> channels;
  for (const auto& [channel, side] : sides_) {
    channels.push_back(channel);
  }
  return channels;
}

Result<SemanticCloud> RigInput::decode(std::size_t source, Bytes message) const {
  if (!depth_[source]) {
    auto cloud = decodeCloud(message);
    if (cloud) {
      moveToBody(*cloud, sources_[source].lidar->T_body_lidar);
    }
    return cloud;
  }
  const auto image = decodeDepthImage(message);
  if (!image) {
    return Result<SemanticCloud>::fail(image.error);
  }
  auto cloud = (*depth_[source])(*image);
  return cloud ? Result<SemanticCloud>::ok(std::move(*cloud))
               : Result<SemanticCloud>::fail("the depth image is not of the size in the rig file");
}

Result<Micros> RigInput::addMain(Bytes message, Micros arrival_us, FrameAssembler& frames) {
  auto cloud = decode(0, message);
  if (!cloud) {
    return Result<Micros>::fail(cloud.error);
  }
  return Result<Micros>::ok(assembler_.addCloud(0, std::move(*cloud), arrival_us, frames));
}

void RigInput::addSide(const std::string& channel, Bytes message, Micros arrival_us, FrameAssembler& frames) {
  const Side& side = sides_.at(channel);
  if (side.camera) {
    const auto head = peekHead(message);
    if (!head || head->kind != MessageKind::kLabelImage) {
      assembler_.countUnreadable(assembler_.rig().cameras[*side.camera].name, "not a label image");
    } else if (head->utime_us < 0 || head->utime_us > kMaxUtime_us) {
      assembler_.countUnreadable(assembler_.rig().cameras[*side.camera].name, "utime out of bounds");
    } else {
      assembler_.addLabels(*side.camera, head->utime_us, message, arrival_us);
    }
    return;
  }
  auto cloud = decode(*side.source, message);
  if (!cloud) {
    assembler_.countUnreadable(sources_[*side.source].name, cloud.error);
    return;
  }
  assembler_.addCloud(*side.source, std::move(*cloud), arrival_us, frames);
}

}  // namespace hgg
