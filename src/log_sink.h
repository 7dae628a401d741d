#pragma once

#include <string>

#include "publish/messages.h"

namespace hgg {

/// Logs a line a status, while frames come, and every warning.
Sink logSink();

/// The line of a status: rates, size of the map, drops, how the last pose came about.
std::string statusLine(const Status& status);

}  // namespace hgg
