#pragma once

#include "bus/bus.h"
#include "config.h"
#include "publish/messages.h"

namespace hgg {

/// Sends messages over LCM on the channels of `lcm`. `bus` must outlive the sink.
Sink lcmSink(Bus& bus, const LcmConfig& lcm);

}  // namespace hgg
