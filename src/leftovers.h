#pragma once

#include <string>

#include "core/result.h"
#include "map/keyframes.h"

namespace hgg {

// What a run writes while it goes on, and what becomes of that when it was killed before it could save.

/// The map as it was some seconds ago (map/page_keeper.h).
inline constexpr char kJournalFile[] = "journal.db";
/// The trajectory while it grows; an earlier run's stays whole until this one ends. A line holds the pose as it was
/// known (t x y z qx qy qz qw) and, behind it, the keyframe it moves with and the pose in its frame.
inline constexpr char kTrajectoryPart[] = "trajectory.tum.part";
/// The poses as they were published.
inline constexpr char kLivePart[] = "live.tum.part";

/// Writes every pose of a growing trajectory where its keyframe is in the end. Lines that end early or name a later
/// keyframe, as the last lines of a killed run do, are left out where `is_cut`, else an error. False where a file
/// fails.
bool correctTrajectory(const std::string& part, const std::string& corrected, const KeyframeGraph& keyframes,
                       bool is_cut);

/// What of an earlier run into the directory is kept and how, as a line to tell; empty when it had ended well.
/// Its journal becomes recovered.hgg (recovered-2.hgg, ... where there is one already) and the way up to it
/// recovered.tum. Where this run goes on from the journal (`is_resumed`), that stays where it is and is
/// written on. Temporary files that the earlier run was writing are removed. The error: too many such files are there.
Result<std::string> keepLeftovers(const std::string& directory, bool is_resumed);

/// The map that the last run into the directory left: its journal where it was killed, else map.hgg; empty: neither.
std::string lastMapIn(const std::string& directory);

}  // namespace hgg
