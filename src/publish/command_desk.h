#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "publish/messages.h"

namespace hgg {

/// Takes commands in and says which are to be carried out. The bus may lose a command or its answer, so a client asks
/// again under the same id: what was answered is answered again, and what is at work is left at work.
class CommandDesk {
 public:
  struct Admission {
    bool is_accepted = false;           // carry it out, then tell answered()
    std::optional<CommandReply> reply;  // to be sent now
  };
  Admission admit(const Command& command);
  void answered(const CommandReply& reply);

  static constexpr std::size_t kMostWaiting = 8, kMostRemembered = 64;  // commands

 private:
  using Key = std::pair<std::string, std::int64_t>;
  void remember(const CommandReply& reply);

  std::set<Key> waiting_;
  std::deque<CommandReply> told_;
};

/// The answer to a command that is not carried out.
CommandReply refusal(const Command& command, std::string why);

}  // namespace hgg
