#include <hgg/command_reply_t.hpp>
#include <hgg/command_t.hpp>

#include "bus/codec.h"
#include "bus/wire.h"

namespace hgg {
namespace {

constexpr bool isOnWireAs(CommandKind kind, std::int8_t value) { return static_cast<std::int8_t>(kind) == value; }
static_assert(isOnWireAs(CommandKind::kSave, hgg::command_t::SAVE));
static_assert(isOnWireAs(CommandKind::kReset, hgg::command_t::RESET));
static_assert(isOnWireAs(CommandKind::kResendAll, hgg::command_t::RESEND_ALL));
static_assert(isOnWireAs(CommandKind::kPublishGeometry, hgg::command_t::PUBLISH_GEOMETRY));
static_assert(isOnWireAs(CommandKind::kPublishOctomap, hgg::command_t::PUBLISH_OCTOMAP));
static_assert(isOnWireAs(CommandKind::kPublishTraversability, hgg::command_t::PUBLISH_TRAVERSABILITY));

}  // namespace

Result<Command> decodeCommand(Bytes message) {
  WireReader in(message);
  Command command;
  in.fingerprint(hgg::command_t::getHash());
  in.utime();
  command.client = in.string("client is no string of at most 255 bytes");
  command.request_id = in.integer<std::int64_t>();
  command.kind = static_cast<CommandKind>(in.integer<std::int8_t>());
  const bool has_region = in.boolean();
  std::array<double, 4> region{};
  for (double& v : region) {
    v = in.real();
  }
  if (has_region) {
    command.region = region;
  }
  command.reference_z = in.real();
  command.resolution = in.real();
  in.end();
  return in.failed() ? Result<Command>::fail(in.error()) : Result<Command>::ok(std::move(command));
}

std::vector<std::uint8_t> encodeCommandReply(const CommandReply& reply) {
  hgg::command_reply_t message{};
  message.utime = reply.utime_us;
  message.client = reply.client;
  message.request_id = reply.request_id;
  message.command = static_cast<std::int8_t>(reply.kind);
  message.ok = reply.ok ? 1 : 0;
  message.text = reply.text;
  message.revision = reply.revision;
  message.ms = reply.ms;
  return encode(message);
}

}  // namespace hgg
