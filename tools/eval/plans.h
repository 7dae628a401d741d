#pragma once

#include <filesystem>
#include <vector>

#include "core/result.h"
#include "eval/walk.h"
#include "eval/walk_paths.h"

namespace hgg {

/// Two places to ask hggmap for a plan between.
struct PlanPair {
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();  // map frame, on the ground
  double shortest = 0;                          // m, the truth's way
};

/// What hggmap plan --json answers.
struct PlanAnswer {
  bool found = false;
  std::vector<Vec3> path;  // map frame
};

struct PlanScore {
  std::size_t asked = 0, found = 0;
  std::size_t through_blocked = 0;         // paths over at least one truly blocked cell
  std::size_t off_ground = 0;              // paths with a point where the truth has no surface at that height
  std::size_t longer = 0;                  // paths longer than kLongest times the truth's shortest
  double mean_ratio = 0, worst_ratio = 0;  // of the lengths; NaN without paths
};
inline constexpr double kLongest = 1.1;

/// Pairs of places on seen ground, at least 2 m apart, between which the truth has a way for this robot.
std::vector<PlanPair> drawPlans(const WalkGrid& truth, const Walker& walker, const Laying& laying, int count,
                                std::uint64_t seed);

/// A line {"from":[x,y,z],"to":[x,y,z],"shortest":m} each. Returns an error line, empty when done.
std::string writePlanRequests(const std::vector<PlanPair>& requests, const std::filesystem::path& path);
Result<std::vector<PlanPair>> readPlanRequests(const std::filesystem::path& path);
/// A line of hggmap plan --json each.
Result<std::vector<PlanAnswer>> readPlanAnswers(const std::filesystem::path& path);

/// An answer that does not lead from `from` to `to`, to within 0.5 m, is none. As many answers as requests.
PlanScore scorePlans(const std::vector<PlanPair>& requests, const std::vector<PlanAnswer>& answers,
                     const WalkGrid& truth, const Laying& laying);

}  // namespace hgg
