#include <algorithm>
#include <hgg/goal_query_t.hpp>
#include <hgg/goal_reply_t.hpp>

#include "bus/codec.h"
#include "bus/wire.h"

namespace hgg {
namespace {

constexpr bool isOnWireAs(GoalStatus status, std::int8_t value) { return static_cast<std::int8_t>(status) == value; }
static_assert(isOnWireAs(GoalStatus::kOk, hgg::goal_reply_t::OK));
static_assert(isOnWireAs(GoalStatus::kAmbiguous, hgg::goal_reply_t::AMBIGUOUS));
static_assert(isOnWireAs(GoalStatus::kNotFound, hgg::goal_reply_t::NOT_FOUND));
static_assert(isOnWireAs(GoalStatus::kNotUnderstood, hgg::goal_reply_t::NOT_UNDERSTOOD));
static_assert(isOnWireAs(GoalStatus::kFailed, hgg::goal_reply_t::FAILED));
constexpr bool isOnWireAs(GoalKind kind, std::int8_t value) { return static_cast<std::int8_t>(kind) == value; }
static_assert(isOnWireAs(GoalKind::kNone, hgg::goal_reply_t::NO_GOAL));
static_assert(isOnWireAs(GoalKind::kReachable, hgg::goal_reply_t::REACHABLE));
static_assert(isOnWireAs(GoalKind::kNearest, hgg::goal_reply_t::NEAREST));

// Promised in lcmtypes/hgg_goal_reply_t.lcm.
constexpr std::size_t kMostAnswers = 100, kMostWaypoints = 10'000;

hgg::goal_answer_t toWire(const GoalAnswer& answer) {
  hgg::goal_answer_t out{};
  out.kind = hgg::goal_answer_t::OBJECT;
  out.id = answer.id;
  out.name = answer.name;
  out.probability = answer.probability;
  store(answer.mean, out.mean);
  std::copy_n(answer.cov.data(), 9, out.cov);  // symmetric: rows and columns are the same
  out.reason = answer.reason;
  return out;
}

}  // namespace

Result<GoalQuery> decodeGoalQuery(Bytes message) {
  WireReader in(message);
  GoalQuery query;
  in.fingerprint(hgg::goal_query_t::getHash());
  in.utime();
  query.client = in.string("client is no string of at most 255 bytes");
  query.request_id = in.integer<std::int64_t>();
  query.text = in.string("text is no string of at most 65,535 bytes", kMaxTextBytes);
  const bool has_start = in.boolean();
  std::array<double, 4> start{};
  for (double& v : start) {
    v = in.real();
  }
  if (has_start) {
    query.start = start;
  }
  query.max_answers = in.integer<std::int32_t>();
  query.with_goal = in.boolean();
  in.end();
  return in.failed() ? Result<GoalQuery>::fail(in.error()) : Result<GoalQuery>::ok(std::move(query));
}

std::vector<std::uint8_t> encodeGoalReply(const GoalReply& reply) {
  hgg::goal_reply_t message{};
  message.utime = reply.utime_us;
  message.client = reply.client;
  message.request_id = reply.request_id;
  message.revision = reply.revision;
  message.status = static_cast<std::int8_t>(reply.status);
  message.text = reply.text;
  message.parse = reply.parse;
  for (std::size_t k = 0; k < std::min(reply.answers.size(), kMostAnswers); ++k) {
    message.answers.push_back(toWire(reply.answers[k]));
  }
  message.num_answers = static_cast<std::int32_t>(message.answers.size());
  message.goal_kind = static_cast<std::int8_t>(reply.goal_kind);
  store(reply.goal, message.goal);
  message.goal[3] = reply.goal_yaw;
  message.goal_reason = reply.goal_reason;
  message.path_length = reply.path_length;
  message.path_confidence = reply.path_confidence;
  for (std::size_t k = 0; k < std::min(reply.path.size(), kMostWaypoints); ++k) {
    message.path_x.push_back(reply.path[k].x());
    message.path_y.push_back(reply.path[k].y());
    message.path_z.push_back(reply.path[k].z());
  }
  message.num_waypoints = static_cast<std::int32_t>(message.path_x.size());
  return encode(message);
}

}  // namespace hgg
