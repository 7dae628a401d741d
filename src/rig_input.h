#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bus/codec.h"
#include "config.h"
#include "frame/depth_cloud.h"
#include "frame/rig_assembler.h"

namespace hgg {

/// The config of a run whose clouds come from a rig: the channel of its first source takes the place of the labelled
/// clouds.
Config configFor(const Rig& rig, Config config);

/// The rig that a config names, if any; makes its config and its class table those of a run with it.
Result<std::optional<Rig>> takeRig(LoadedConfig& loaded);

/// The messages of a rig's sensors, decoded and handed to its RigAssembler.
class RigInput {
 public:
  RigInput(const Rig& rig, const Config& config);

  /// Channels beside that of the first source.
  std::vector<std::string> sideChannels() const;
  bool isSideChannel(const std::string& channel) const { return sides_.contains(channel); }

  /// The time of the cloud; else why there is none.
  Result<Micros> addMain(Bytes message, Micros arrival_us, FrameAssembler& frames);
  void addSide(const std::string& channel, Bytes message, Micros arrival_us, FrameAssembler& frames);

  std::optional<Frame> next(Micros now_us, FrameAssembler& frames, Micros delay_us) {
    return assembler_.next(now_us, frames, delay_us);
  }
  void finish() { assembler_.finish(); }
  bool isWaiting() const { return assembler_.isWaiting(); }
  const RigCounts& counts() const { return assembler_.counts(); }

 private:
  /// What comes on a channel: clouds of a source, or labels of a camera.
  struct Side {
    std::optional<std::size_t> source, camera;
  };

  Result<SemanticCloud> decode(std::size_t source, Bytes message) const;

  RigAssembler assembler_;
  std::vector<CloudSource> sources_;
  std::vector<std::optional<DepthToCloud>> depth_;  // of each source that is a camera
  std::map<std::string, Side> sides_;
};

}  // namespace hgg
