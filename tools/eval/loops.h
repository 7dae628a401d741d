#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <vector>

#include "core/result.h"
#include "eval/trajectory.h"

namespace hgg {

/// A question about a loop and its answer, as stats.json tells it.
struct LoopRun {
  Micros before_us = 0, now_us = 0;  // of the two keyframes
  bool accepted = false;
  Pose T_before_now = Pose::Identity();
};

/// What a run says of its loops. The list holds the newest thousand questions only, the counts hold all.
struct LoopRuns {
  std::size_t accepted = 0, rejected = 0;
  std::vector<LoopRun> list;
};

/// An accepted loop farther off than this is a false one.
inline constexpr double kFalseLoop = 1.0, kFalseLoopTurn_deg = 3.0;  // m

/// What counts as coming back to a place, m.
struct RevisitScale {
  double step = 0;  // of the way between the poses that are looked at
  double near = 0;  // to an earlier pose
  double left = 0;  // of way since that pose
  /// Of way before and into a revisit in which its loop may come: a place is seen before it is reached.
  double around = 0;
};

/// Out of doors (`radius`, of object matching, 1 m or more) a place is both sides of one street; indoors it is a room,
/// and the way round is shorter.
RevisitScale revisitScale(double radius);

/// A stretch of the way near something that was left long before, m of way from the start.
struct Revisit {
  double first = 0, last = 0;
};

struct LoopScore {
  std::size_t asked = 0, accepted = 0;  // of the whole run
  std::size_t checked = 0;              // accepted ones with a true pose at both ends
  std::size_t wrong = 0;                // of those checked: more than kFalseLoop or kFalseLoopTurn_deg off
  double worst = 0, worst_deg = 0;      // m; of those checked, each for itself; NaN without any
  std::size_t revisits = 0;             // in truth
  std::size_t revisits_asked = 0;       // with a question in time
  std::size_t revisits_closed = 0;      // with an accepted loop in time that is not false
};

/// Reads "loops", "loops_accepted" and "loops_rejected" of a stats.json. Errors say what is wrong with them.
Result<LoopRuns> readLoops(const nlohmann::json& stats);

/// Revisits of the true way, in its order.
std::vector<Revisit> findRevisits(std::span<const PosePair> pairs, const RevisitScale& scale);

/// Every accepted loop against the true motion between its two keyframes, which are found by their times among `pairs`;
/// and the true revisits against the loops. A revisit may need no loop: where alignment never lost the old part of the
/// map there is nothing to ask.
LoopScore scoreLoops(const LoopRuns& runs, std::span<const PosePair> pairs, const RevisitScale& scale);

}  // namespace hgg
