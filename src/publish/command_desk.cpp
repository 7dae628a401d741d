#include "publish/command_desk.h"

#include <fmt/format.h>

#include <utility>

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
  Requests::Admission admission = desk_.admit({command.client, command.request_id});
  if (admission.verdict == Requests::Verdict::kFull) {
    return {false, refusal(command, fmt::format("{} commands wait already: ask again later", kMostWaiting))};
  }
  if (admission.verdict != Requests::Verdict::kNew) {
    return {false, std::move(admission.reply)};
  }
  if (std::string why = whyRefused(command.kind); !why.empty()) {
    CommandReply reply = refusal(command, std::move(why));
    answered(reply);
    return {false, std::move(reply)};
  }
  return {true, std::nullopt};
}

}  // namespace hgg
