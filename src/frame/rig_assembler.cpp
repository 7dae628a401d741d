#include "frame/rig_assembler.h"

#include <algorithm>
#include <utility>

#include "frame/motion.h"

namespace hgg {
namespace {

constexpr std::size_t kMostHeld = 32;        // frames that wait for images: 3 s of 10 Hz
constexpr Micros kPatience_us = 1'000'000;   // a sensor that has sent nothing by then is not waited for
constexpr std::int64_t kStandingFrames = 5;  // in a row, before it is an alarm
constexpr double kForeignShare = 0.5;        // of a camera's points: its numbers are those of another label set
constexpr Micros kCloudsApart_us = 100'000;  // most between the clouds of one frame

constexpr char kNone[] = "no image in time";
constexpr char kLateImage[] = "late: labels of an older image are used";
constexpr char kWrongSize[] = "the image is not of the size in the rig file";
constexpr char kForeign[] = "most labels are not in its label set";
constexpr char kNoMotion[] = "no odometry at the time of its image";
constexpr char kBadStamp[] = "stamp late, twice or out of line";
constexpr char kNoCloud[] = "no cloud in time";

/// m from the camera to the farthest of the sources.
double baselineOf(const std::vector<CloudSource>& sources, const Pose& T_camera_body) {
  double farthest = 0;
  for (const CloudSource& source : sources) {
    const Pose& T = source.lidar != nullptr ? source.lidar->T_body_lidar : source.camera->T_body_camera;
    farthest = std::max(farthest, (T_camera_body * Vec3(T.translation())).norm());
  }
  return farthest;
}

}  // namespace

RigAssembler::RigAssembler(Rig rig, const LabellingOptions& options, DecodeLabels decode)
    : rig_(std::move(rig)),
      sources_(cloudSources(rig_)),
      options_(options),
      decode_(std::move(decode)),
      sides_(sources_.size() - 1),
      cameras_(rig_.cameras.size()) {}

Micros RigAssembler::addCloud(std::size_t source, SemanticCloud cloud, Micros arrival_us, FrameAssembler& frames) {
  const CloudSource& from = sources_[source];
  cloud.utime_us += from.lidar != nullptr ? from.lidar->offset_us : from.camera->offset_us;
  for (Point& p : cloud.points) {
    p.label = kUnknownClass, p.instance = 0;
  }
  const Micros utime_us = cloud.utime_us;
  if (source == 0) {
    frames.addCloud(std::move(cloud), arrival_us);
  } else if (!sides_[source - 1].clouds.add(utime_us, std::move(cloud), arrival_us)) {
    countUnreadable(from.name, kBadStamp);
  }
  return utime_us;
}

void RigAssembler::addLabels(std::size_t camera, Micros utime_us, std::span<const std::uint8_t> message,
                             Micros arrival_us) {
  const RigCamera& model = rig_.cameras[camera];
  if (!cameras_[camera].images.add(utime_us + model.offset_us, {message.begin(), message.end()}, arrival_us)) {
    countUnreadable(model.name, kBadStamp);
  }
}

void RigAssembler::countUnreadable(const std::string& sensor, const std::string& why) {
  ++counts_.troubles[sensor + ": " + why];
}

std::optional<Frame> RigAssembler::next(Micros now_us, FrameAssembler& frames, Micros delay_us) {
  while (auto frame = frames.next(now_us)) {
    held_.push_back({std::move(*frame), now_us});
  }
  if (held_.empty()) {
    return std::nullopt;
  }
  first_us_ = std::min(first_us_.value_or(now_us), now_us);
  Held& front = held_.front();
  front.since_us = std::min(front.since_us, now_us);  // a log whose clock went back must not wait for ever
  if (!isComplete(front, now_us, frames.odometry(), delay_us)) {
    return std::nullopt;
  }
  Frame frame = std::move(front.frame);
  held_.pop_front();
  deskew(frame, frames.odometry(), delay_us);
  join(frame, frames.odometry(), delay_us);
  label(frame, frames.odometry(), delay_us);
  noteStanding();
  return frame;
}

template <typename T>
bool RigAssembler::isAwaited(const Stream<T>& stream, Micros now_us) const {
  return stream.received() == 0 ? now_us - *first_us_ <= kPatience_us : !stream.isSilent(now_us);
}

bool RigAssembler::isComplete(const Held& held, Micros now_us, const OdometryBuffer& odometry, Micros delay_us) const {
  if (finished_ || held_.size() > kMostHeld || now_us - held.since_us > rig_.wait_us) {
    return true;
  }
  const Micros utime_us = held.frame.utime_us;
  const auto isMissing = [&](const auto& stream) {
    if (!stream.isSettled(utime_us)) {
      return isAwaited(stream, now_us);
    }
    return odometry.missAt(stream.nearest(utime_us)->utime_us + delay_us) == OdometryMiss::kAhead;
  };
  return std::ranges::none_of(cameras_, [&](const Camera& camera) { return isMissing(camera.images); }) &&
         std::ranges::none_of(sides_, [&](const Side& side) { return isMissing(side.clouds); });
}

/// Adds the clouds of the other sources, taken to the body at the frame's time.
void RigAssembler::join(Frame& frame, const OdometryBuffer& odometry, Micros delay_us) {
  for (std::size_t k = 0; k < sides_.size(); ++k) {
    Side& side = sides_[k];
    const auto* found = side.clouds.nearest(frame.utime_us);
    if (found == nullptr || side.clouds.distance(found->utime_us, frame.utime_us) > kCloudsApart_us) {
      countUnreadable(sources_[k + 1].name, kNoCloud);
      continue;
    }
    if (found->utime_us == side.last_us) {
      continue;  // slower than the first: its points count once
    }
    side.last_us = found->utime_us;
    std::vector<Point> points = found->value.points;
    if (movePoints(points, found->value.times, found->utime_us, frame.utime_us, odometry, delay_us)) {
      frame.points.insert(frame.points.end(), points.begin(), points.end());
    } else {
      countUnreadable(sources_[k + 1].name, kNoMotion);
    }
  }
}

void RigAssembler::label(Frame& frame, const OdometryBuffer& odometry, Micros delay_us) {
  std::vector<LabelImage> images;
  std::vector<LabelView> views;
  images.reserve(cameras_.size());  // views point into it
  for (std::size_t k = 0; k < cameras_.size(); ++k) {
    auto image = take(k, frame.utime_us);
    if (!image) {
      continue;
    }
    const auto T_then_now = motionBetween(odometry, frame.utime_us, image->utime_us, delay_us);
    if (!T_then_now) {
      refuse(k, kNoMotion);
      continue;
    }
    images.push_back(std::move(*image));
    const Pose T_camera_body = rig_.cameras[k].T_body_camera.inverse() * *T_then_now;
    views.push_back({&rig_.cameras[k], &images.back(), k, T_camera_body, baselineOf(sources_, T_camera_body)});
  }
  const LabelReport report = labelPoints(frame.points, views, options_);
  counts_.labels += report.all;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const LabelCounts& seen = report.views[v];
    if (static_cast<double>(seen.foreign) > kForeignShare * static_cast<double>(seen.seen)) {
      refuse(views[v].number, kForeign);
    } else {
      cameras_[views[v].number].frames_without = 0;
    }
  }
}

/// The image of a camera for a cloud, its time that of the exposure.
std::optional<LabelImage> RigAssembler::take(std::size_t camera, Micros utime_us) {
  Camera& from = cameras_[camera];
  const RigCamera& model = rig_.cameras[camera];
  const auto* found = from.images.nearest(utime_us);
  if (found == nullptr || from.images.distance(found->utime_us, utime_us) > rig_.max_age_us) {
    return refuse(camera, kNone);
  }
  auto image = decode_(found->value);
  if (!image) {
    return refuse(camera, image.error);
  }
  if (image->width != model.model.width || image->height != model.model.height) {
    return refuse(camera, kWrongSize);
  }
  const bool is_late = !from.images.isSettled(utime_us);
  from.frames_late = is_late ? from.frames_late + 1 : 0;
  if (is_late) {
    countUnreadable(model.name, kLateImage);
  }
  image->utime_us = found->utime_us;
  return std::move(*image);
}

/// Notes that a frame does without a camera. Always nothing.
std::optional<LabelImage> RigAssembler::refuse(std::size_t camera, const std::string& why) {
  ++cameras_[camera].frames_without;
  cameras_[camera].last_trouble = why;
  countUnreadable(rig_.cameras[camera].name, why);
  return std::nullopt;
}

void RigAssembler::noteStanding() {
  counts_.standing.clear();
  for (std::size_t k = 0; k < cameras_.size(); ++k) {
    const Camera& camera = cameras_[k];
    const std::string& name = rig_.cameras[k].name;
    if (camera.frames_without >= kStandingFrames) {
      counts_.standing.push_back({name, "camera_out", "camera " + name + " gives no labels: " + camera.last_trouble});
    } else if (camera.frames_late >= kStandingFrames) {
      counts_.standing.push_back({name, "camera_late", "camera " + name + " is " + kLateImage});
    }
  }
}

}  // namespace hgg
