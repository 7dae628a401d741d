#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "mapper.h"
#include "output.h"
#include "stats.h"

namespace CLI {
class App;
}

namespace hgg {

// What the commands share.

/// Exit codes: done, the answer is no, bad input or usage.
constexpr int kDone = 0, kNo = 1, kBadInput = 2;

/// What the command line asks for; returns the exit code.
using Action = std::function<int()>;

/// Says on stderr what was wrong; returns kBadInput.
int fail(const std::string& error);

/// From here on the first SIGINT, SIGTERM or SIGHUP raises the flag that is returned, so that work can end and what
/// there is be kept; a second one kills.
const std::atomic<bool>& stopOnSignals();

/// Says on stdout what a run or a replay made of its messages, and where the map is.
void summarise(const Mapper& mapper, const RunCounts& counts, const OutputDirectory& out);

}  // namespace hgg
