#pragma once

#include <atomic>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

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

/// Prints what `answer` makes of each line of a file of JSON values, one line an answer, in their order; blank lines
/// are skipped. Where `answer` gives nothing, the line of `refuse` stands in its place, and stderr says the number of
/// the line and what it should be, `form`. Returns the exit code: bad input when any line was refused.
int answerLines(const std::string& path, const std::string& form,
                const std::function<std::optional<std::string>(const nlohmann::json&)>& answer,
                const std::function<std::string(const std::string& why)>& refuse);
/// The finite numbers that an object holds as a list under `key`; nothing when it does not.
std::optional<std::vector<double>> numbersOf(const nlohmann::json& object, const char* key);

/// From here on the first SIGINT, SIGTERM or SIGHUP raises the flag that is returned, so that work can end and what
/// there is be kept; a second one kills.
const std::atomic<bool>& stopOnSignals();

/// Says on stdout what a run or a replay made of its messages, and where the map is.
void summarise(const Mapper& mapper, const RunCounts& counts, const OutputDirectory& out);

}  // namespace hgg
