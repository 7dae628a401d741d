#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "bus/log.h"
#include "core/result.h"
#include "mapper.h"
#include "pipeline.h"

namespace hgg {

struct ReplayReport {
  std::int64_t events = 0;  // whole events of the log, of any channel
  RunCounts counts;
  LogLoss loss;
  bool stopped = false;  // by `stop`, before the end of the log
};

/// Share of the log that has been read (0..1) and frames so far.
using OnProgress = std::function<void(double share, std::int64_t frames)>;

/// Maps a whole log, as fast as it can and deterministically: no frame is dropped for being busy, and time is the
/// log's. A raised `stop` ends it early with everything so far kept. Fails when the log cannot be opened, when no frame
/// came of it, and when its stamps are such that no map should be made of it; the line says what the log holds. `rig`
/// as for Pipeline.
Result<ReplayReport> replayLog(const std::string& log_path, Mapper& mapper, const OnFrame& on_frame,
                               const OnProgress& on_progress, const std::atomic<bool>& stop,
                               const std::optional<Rig>& rig = std::nullopt);

}  // namespace hgg
