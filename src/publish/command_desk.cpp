#include "publish/command_desk.h"

#include <fmt/format.h>

#include <algorithm>

namespace hgg {
namespace {

/// Why commands of this kind are refused; empty when they are not.
std::string whyRefused(CommandKind kind) {
  switch (kind) {
    case CommandKind::kPublishOctomap:
    case CommandKind::kPublishTraversability:
      return {};
    case CommandKind::kSave:
      return "SAVE is not supported yet";
    case CommandKind::kReset:
      return "RESET is not supported yet";
    case CommandKind::kResendAll:
      return "RESEND_ALL is not supported yet: a complete update comes every 10 s or so";
    case CommandKind::kPublishGeometry:
      return "PUBLISH_GEOMETRY is not supported yet";
  }
  return fmt::format("{} is no command", static_cast<int>(kind));
}

}  // namespace

CommandReply refusal(const Command& command, std::string why) {
  CommandReply reply;
  reply.client = command.client, reply.request_id = command.request_id, reply.kind = command.kind;
  reply.text = std::move(why);
  return reply;
}

CommandDesk::Admission CommandDesk::admit(const Command& command) {
  const Key key{command.client, command.request_id};
  const auto told = std::ranges::find_if(
      told_, [&](const CommandReply& r) { return r.request_id == command.request_id && r.client == command.client; });
  if (told != told_.end()) {
    return {false, *told};
  }
  if (waiting_.contains(key)) {
    return {};
  }
  if (std::string why = whyRefused(command.kind); !why.empty()) {
    remember(refusal(command, std::move(why)));
    return {false, told_.back()};
  }
  if (waiting_.size() >= kMostWaiting) {
    return {false, refusal(command, fmt::format("{} commands wait already: ask again later", waiting_.size()))};
  }
  waiting_.insert(key);
  return {true, std::nullopt};
}

void CommandDesk::answered(const CommandReply& reply) {
  waiting_.erase({reply.client, reply.request_id});
  remember(reply);
}

void CommandDesk::remember(const CommandReply& reply) {
  told_.push_back(reply);
  if (told_.size() > kMostRemembered) {
    told_.pop_front();
  }
}

}  // namespace hgg
