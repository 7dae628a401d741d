#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "frame/assemble.h"
#include "frame/labelling.h"
#include "frame/rig.h"
#include "frame/rig_counts.h"
#include "frame/stream.h"

namespace hgg {

/// Bundles what a rig measured at one time: the cloud of the first source with its odometry, the clouds of the others,
/// the label images of the cameras; and makes a labelled frame of it. A sensor that is late or dead costs its share of
/// the frame, never the frame, which waits for it no longer than Rig::wait_us; one that has been silent for a second is
/// not waited for. Knows no clock, as FrameAssembler.
class RigAssembler {
 public:
  using DecodeLabels = std::function<Result<LabelImage>(std::span<const std::uint8_t>)>;

  RigAssembler(Rig rig, const LabellingOptions& options, DecodeLabels decode);
  RigAssembler(const RigAssembler&) = delete;
  RigAssembler& operator=(const RigAssembler&) = delete;

  /// Of source `source` (cloudSources), in the body frame, unlabelled, stamped with the sensor's own time. Returns the
  /// time of its frame.
  Micros addCloud(std::size_t source, SemanticCloud cloud, Micros arrival_us, FrameAssembler& frames);
  /// Of camera `camera`, as it came: only images that are used are decoded.
  void addLabels(std::size_t camera, Micros utime_us, std::span<const std::uint8_t> message, Micros arrival_us);
  /// A message of a sensor that could not be read at all.
  void countUnreadable(const std::string& sensor, const std::string& why);
  /// The next labelled frame; frames that still wait for images stay.
  std::optional<Frame> next(Micros now_us, FrameAssembler& frames, Micros delay_us);
  void finish() { finished_ = true; }

  bool isWaiting() const { return !held_.empty(); }
  const Rig& rig() const { return rig_; }
  const RigCounts& counts() const { return counts_; }

 private:
  struct Held {
    Frame frame;
    Micros since_us = 0;
  };
  struct Camera {
    Stream<std::vector<std::uint8_t>> images;
    std::int64_t frames_without = 0;  // in a row
    std::int64_t frames_late = 0;     // in a row: the image is not the nearest, which did not come in time
    std::string last_trouble;
  };

  bool isComplete(const Held& held, Micros now_us, const OdometryBuffer& odometry, Micros delay_us) const;
  template <typename T>
  bool isAwaited(const Stream<T>& stream, Micros now_us) const;
  void join(Frame& frame, const OdometryBuffer& odometry, Micros delay_us);
  void label(Frame& frame, const OdometryBuffer& odometry, Micros delay_us);
  std::optional<LabelImage> take(std::size_t camera, Micros utime_us);
  std::optional<LabelImage> refuse(std::size_t camera, const std::string& why);
  void noteStanding();

  Rig rig_;
  std::vector<CloudSource> sources_;
  LabellingOptions options_;
  DecodeLabels decode_;
  struct Side {
    Stream<SemanticCloud> clouds;
    std::optional<Micros> last_us;  // of the cloud that was used last
  };
  std::vector<Side> sides_;  // all sources but the first, which goes to the FrameAssembler
  std::vector<Camera> cameras_;
  std::deque<Held> held_;
  std::optional<Micros> first_us_;  // when the first frame was seen
  bool finished_ = false;
  RigCounts counts_;
};

}  // namespace hgg
