#pragma once

#include <fstream>
#include <string>

#include "core/result.h"
#include "mapper.h"
#include "stats.h"

namespace hgg {

/// The directory a run or replay leaves behind: map.hgg, trajectory.tum, live.tum, moving.jsonl,
/// stats.json.
class OutputDirectory {
 public:
  /// Creates the directory where needed and opens the trajectory.
  static Result<OutputDirectory> open(const std::string& directory);

  /// Adds one line to the trajectory (t x y z qx qy qz qw), one to live.tum (the same as it was published, and a word
  /// for how sure it was), one a mover in view to moving.jsonl, and the frame's cost to the statistics.
  void add(const StepReport& report, const FrameTiming& timing, const Map& map);
  /// Writes the map and the statistics; an error line, empty when done.
  std::string finish(const Mapper& mapper, const RunCounts& counts);
  /// Leaves what an earlier run left as it is; for a run that came to nothing.
  void discard();

  std::string path(const char* name) const { return directory_ + "/" + name; }

 private:
  explicit OutputDirectory(std::string directory) : directory_(std::move(directory)) {}

  std::string directory_;
  std::ofstream trajectory_, live_, moving_;
  RunStats stats_;
};

}  // namespace hgg
