#pragma once

#include <string>

#include "publish/messages.h"

namespace hgg {

/// Logs a line a status, while frames come, every warning, and what was asked for.
Sink logSink();

/// The line of a status: rates, size of the map, drops, how the last pose came about.
std::string statusLine(const Status& status);
/// The line of an answer to a query: what is meant, how sure, and how far it is.
std::string goalLine(const GoalReply& reply);

}  // namespace hgg
