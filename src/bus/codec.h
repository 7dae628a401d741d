#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "core/types.h"
#include "frame/frame.h"
#include "frame/image.h"
#include "publish/messages.h"

namespace hgg {

/// Messages <-> structs, a codec_*.cpp each; LCM's message types are included there and nowhere else. Every decode is
/// bounded, never throws, and fails with a reason on: truncated or surplus bytes, a foreign fingerprint, negative or
/// absurd lengths, fields that do not fit the record, non-finite or zero-norm orientations, times outside
/// 0..kMaxUtime_us. The reasons are a fixed set of texts without values in them, so that they can be counted.
using Bytes = std::span<const std::uint8_t>;

/// What a message says it is, and its stamp, unchecked: for telling what is wrong with a log.
enum class MessageKind : std::uint8_t { kPose, kCloud, kLabelImage, kDepthImage, kOther };
struct MessageHead {
  MessageKind kind = MessageKind::kOther;
  Micros utime_us = 0;  // of all but kOther
};
/// nullopt where the message is shorter than a head.
std::optional<MessageHead> peekHead(Bytes message);

/// Limits of what is accepted from the wire.
constexpr std::int64_t kMaxPoints = 4'000'000;
constexpr std::int32_t kMaxFields = 64;
constexpr std::int32_t kMaxStringBytes = 256;
constexpr std::int32_t kMaxTextBytes = 65'536;
constexpr std::int64_t kMaxPixels = 16'777'216;
constexpr std::int32_t kMaxEmbeddings = 65'536;
constexpr std::int32_t kMaxEmbeddingSize = 4096;
constexpr Micros kMaxUtime_us = Micros{1} << 60;  // times of any source can be subtracted without overflow

/// bot_core.pose_t -> odometry sample (pos and orientation only; the orientation is normalised).
Result<OdometrySample> decodePose(Bytes message);

/// bot_core.pointcloud2_t with fields x, y, z (f32), label (u16; u8, u32 and i32 accepted too), optional instance (u32
/// or u16), confidence (f32) and time (f32, s after utime). Points whose confidence is not at least `min_confidence`
/// are left out. Labels above 65535 become 65535. Points with non-finite coordinates are kept: creation drops and
/// counts them.
Result<SemanticCloud> decodeSemanticCloud(Bytes message, float min_confidence);

/// bot_core.pointcloud2_t with fields x, y, z (f32) at least, optional time (f32): an unlabelled cloud; every point
/// gets label 0.
Result<SemanticCloud> decodeCloud(Bytes message);

/// hgg.label_image_t. Planes that do not have a value for every pixel, once unpacked, are errors.
Result<LabelImage> decodeLabelImage(Bytes message);

/// bot_core.image_t of little-endian 16-bit grey values, or of 32-bit floats in m, which become whole mm; rows padded
/// or not.
Result<DepthImage> decodeDepthImage(Bytes message);

/// hgg.command_t. Numbers that make no sense are taken as they are: they have to be answered.
Result<Command> decodeCommand(Bytes message);

/// hgg.goal_query_t. Its text may be longer than what is answered, and no UTF-8.
Result<GoalQuery> decodeGoalQuery(Bytes message);

/// A pose in whatever frame its channel speaks of: odom on the way in, map on the way out.
std::vector<std::uint8_t> encodePose(Micros utime_us, const Pose& T_parent_body);
/// Likewise, to the last bit as it is given.
std::vector<std::uint8_t> encodePose(Micros utime_us, const Vec3& position, const Eigen::Quaterniond& orientation);
/// x, y, z (f32), label (u16), and instance (u32) when any point has one.
std::vector<std::uint8_t> encodeSemanticCloud(Micros utime_us, std::span<const Point> points);
/// Likewise, and time (f32, s after utime_us; negative = before) for each point. As many times as points, or none.
std::vector<std::uint8_t> encodeSemanticCloud(Micros utime_us, std::span<const Point> points,
                                              std::span<const float> times);
/// x, y, z (f32), and time where there are times; labels and instances are left out.
std::vector<std::uint8_t> encodeCloud(Micros utime_us, std::span<const Point> points,
                                      std::span<const float> times = {});
enum class Packing { kRaw, kZstd };
std::vector<std::uint8_t> encodeLabelImage(const LabelImage& image, Packing packing = Packing::kZstd);
std::vector<std::uint8_t> encodeDepthImage(const DepthImage& image);
std::vector<std::uint8_t> encodeRigidTransform(Micros utime_us, const Pose& T_map_odom);
std::vector<std::uint8_t> encodeGraphUpdate(const GraphUpdate& update);
std::vector<std::uint8_t> encodeRegions(const RegionsUpdate& update);
std::vector<std::uint8_t> encodeStatus(const Status& status);
std::vector<std::uint8_t> encodeOctomap(const OctomapBytes& octomap);
std::vector<std::uint8_t> encodeCommandReply(const CommandReply& reply);
/// At most 100 answers and 10,000 waypoints go out; of a longer path the first ones.
std::vector<std::uint8_t> encodeGoalReply(const GoalReply& reply);

/// A message that is larger is sent in parts where it can be. Receivers have buffers of a few MB.
constexpr std::size_t kMostMessageBytes = 1 << 20;
/// The grid as messages of hgg.traversability_t, side by side, none of them larger than `most_bytes` but for a single
/// cell.
std::vector<std::vector<std::uint8_t>> encodeTraversability(const GroundGrid& grid,
                                                            std::size_t most_bytes = kMostMessageBytes);

}  // namespace hgg
