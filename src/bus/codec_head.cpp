#include <bot_core/image_t.hpp>
#include <bot_core/pointcloud2_t.hpp>
#include <bot_core/pose_t.hpp>
#include <hgg/label_image_t.hpp>

#include "bus/codec.h"
#include "bus/wire.h"

namespace hgg {

std::optional<MessageHead> peekHead(Bytes message) {
  WireReader in(message);
  const auto fingerprint = in.integer<std::int64_t>();
  const auto utime_us = in.integer<Micros>();
  if (in.failed()) {
    return std::nullopt;
  }
  if (fingerprint == bot_core::pose_t::getHash()) {
    return MessageHead{MessageKind::kPose, utime_us};
  }
  if (fingerprint == bot_core::pointcloud2_t::getHash()) {
    return MessageHead{MessageKind::kCloud, utime_us};
  }
  if (fingerprint == hgg::label_image_t::getHash()) {
    return MessageHead{MessageKind::kLabelImage, utime_us};
  }
  if (fingerprint == bot_core::image_t::getHash()) {
    return MessageHead{MessageKind::kDepthImage, utime_us};
  }
  return MessageHead{MessageKind::kOther, 0};
}

}  // namespace hgg
