#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "publish/desk.h"
#include "publish/messages.h"

namespace hgg {

/// Takes commands in and says which are to be carried out.
class CommandDesk {
  using Requests = Desk<std::pair<std::string, std::int64_t>, CommandReply>;  // by client and request_id

 public:
  static constexpr std::size_t kMostWaiting = Requests::kMostAtWork, kMostRemembered = Requests::kMostRemembered;

  struct Admission {
    bool is_accepted = false;           // carry it out, then tell answered()
    std::optional<CommandReply> reply;  // to be sent now
  };
  Admission admit(const Command& command);
  void answered(const CommandReply& reply) { desk_.close({reply.client, reply.request_id}, reply); }

 private:
  Requests desk_;
};

/// The answer to a command that is not carried out.
CommandReply refusal(const Command& command, std::string why);

}  // namespace hgg
