#pragma once

#include <fstream>
#include <string>

#include "core/result.h"
#include "directory_lock.h"
#include "mapper.h"
#include "stats.h"

namespace hgg {

/// A pose as a line of a trajectory has it: x y z qx qy qz qw.
std::string poseText(const Pose& T);

/// The directory a run or replay leaves behind: map.hgg, trajectory.tum, live.tum, moving.jsonl, stats.json.
/// It has it to itself.
class OutputDirectory {
 public:
  /// Creates the directory where needed, keeps what a killed run left there (leftovers.h) and opens the trajectory.
  /// `is_resumed`: this run goes on from what the last one into the directory left.
  static Result<OutputDirectory> open(const std::string& directory, bool is_resumed = false);

  /// Adds one line to the trajectory (t x y z qx qy qz qw), one to live.tum (the same as it was published, and a word
  /// for how sure it was), one a mover in view to moving.jsonl, and the frame's cost to the statistics.
  void add(const StepReport& report, const FrameTiming& timing, const Map& map);
  /// Writes the map and the statistics; an error line, empty when done.
  std::string finish(const Mapper& mapper, const RunCounts& counts);
  /// Leaves what an earlier run left as it is; for a run that came to nothing.
  void discard();

  std::string path(const char* name) const { return directory_ + "/" + name; }

 private:
  OutputDirectory(std::string directory, DirectoryLock lock)
      : directory_(std::move(directory)), lock_(std::move(lock)) {}

  std::string directory_;
  DirectoryLock lock_;
  std::ofstream trajectory_, live_, moving_;
  RunStats stats_;
};

}  // namespace hgg
