#include <hgg/status_t.hpp>

#include "bus/codec.h"
#include "bus/wire.h"

namespace hgg {

std::vector<std::uint8_t> encodeStatus(const Status& status) {
  hgg::status_t message{};  // what is not set here is not known, and zero or empty says so
  message.queued = kNone;
  message.disk_free_mb = message.saved_age_s = kNone;
  message.utime = status.utime_us;
  message.state = static_cast<std::int8_t>(status.state);
  message.fragment = status.fragment;
  message.position_sigma = status.position_sigma;
  message.heading_sigma = status.heading_sigma;
  message.num_alarms = static_cast<std::int32_t>(status.alarms.size());
  for (const Alarm& alarm : status.alarms) {
    hgg::alarm_t told{};
    told.severity = alarm.is_serious ? hgg::alarm_t::SERIOUS : hgg::alarm_t::WARNING;
    told.code = alarm.code, told.subject = alarm.subject, told.text = alarm.text;
    message.alarms.push_back(std::move(told));
  }
  message.frames = status.frames;
  message.dropped_busy = status.dropped_busy;
  message.dropped_odometry = status.dropped_odometry;
  message.dropped_invalid = status.dropped_invalid;
  message.num_drops = static_cast<std::int32_t>(status.drops.size());
  for (const auto& [cause, messages] : status.drops) {
    message.drop_causes.push_back(cause);
    message.drop_counts.push_back(messages);
  }
  message.frame_rate = status.frame_rate;
  message.frame_ms = status.frame_ms;
  message.num_stages = static_cast<std::int32_t>(status.stage_ms.size());
  for (const auto& [name, ms] : status.stage_ms) {
    message.stage_names.push_back(name);
    message.stage_ms.push_back(ms);
  }
  message.objects = status.objects;
  message.leaves = status.leaves;
  message.keyframes = status.keyframes;
  message.loops = status.loops;
  message.map_mb = status.map_mb;
  message.rss_mb = status.rss_mb;
  message.unknown_labels = status.unknown_labels;
  message.revision = status.revision;
  message.alignment = status.alignment;
  message.degenerate = status.degenerate;
  return encode(message);
}

}  // namespace hgg
