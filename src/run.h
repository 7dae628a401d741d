#pragma once

#include <atomic>
#include <optional>

#include "config.h"
#include "core/result.h"
#include "mapper.h"
#include "pipeline.h"

namespace hgg {

/// Maps what comes in over LCM and publishes the results until `stop` is raised. A busy mapper takes the newest cloud
/// and counts the others as dropped. Logs one line a second; fails when the LCM url cannot be opened, and when no frame
/// came before `stop`: the line says what came instead. `rig` as for Pipeline.
Result<RunCounts> runLive(const Config& config, Mapper& mapper, const std::atomic<bool>& stop, const OnFrame& on_frame,
                          const std::optional<Rig>& rig = std::nullopt);

}  // namespace hgg
