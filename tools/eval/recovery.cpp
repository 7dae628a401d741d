#include "eval/recovery.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

namespace hgg {
namespace {

constexpr double kMicro = 1e-6;  // s

double secondsBetween(Micros from_us, Micros to_us) { return kMicro * static_cast<double>(to_us - from_us); }

/// s of the longest stretch of poses that are `bad`, up to the next pose that is not.
template <typename Bad>
double longestStretch(std::span<const TrackedPose> poses, Bad&& bad) {
  double longest = 0;
  std::optional<Micros> since;
  for (const TrackedPose& pose : poses) {
    if (bad(pose) && !since) {
      since = pose.utime_us;
    }
    if (since) {
      longest = std::max(longest, secondsBetween(*since, pose.utime_us));
    }
    if (!bad(pose)) {
      since.reset();
    }
  }
  return longest;
}

std::optional<double> backAfter(std::span<const TrackedPose> poses, Micros fault_us) {
  std::optional<Micros> right_since;
  for (const TrackedPose& pose : poses) {
    if (pose.utime_us < fault_us) {
      continue;
    }
    if (pose.error > kRightPlace) {
      right_since.reset();
      continue;
    }
    right_since = right_since.value_or(pose.utime_us);
    if (secondsBetween(*right_since, pose.utime_us) >= kStays) {
      break;
    }
  }
  return right_since ? std::optional(secondsBetween(fault_us, *right_since)) : std::nullopt;
}

std::optional<double> saidAfter(std::span<const TrackedPose> poses, Micros fault_us) {
  const auto said = std::ranges::find_if(
      poses, [&](const TrackedPose& p) { return p.utime_us >= fault_us && p.has_status && !p.is_sure; });
  return said != poses.end() ? std::optional(secondsBetween(fault_us, said->utime_us)) : std::nullopt;
}

Result<LivePose> liveRow(const std::string& line) {
  std::istringstream words(line);
  double t = 0;
  Vec3 p;
  Eigen::Quaterniond q;
  LivePose live;
  words >> t >> p.x() >> p.y() >> p.z() >> q.x() >> q.y() >> q.z() >> q.w();
  if (!words || !(q.norm() > 0) || !p.allFinite()) {
    return Result<LivePose>::fail("not a row of t x y z qx qy qz qw [status]");
  }
  words >> live.status;
  live.pose.utime_us = std::llround(t / kMicro);
  live.pose.T_map_body.translation() = p;
  live.pose.T_map_body.linear() = q.normalized().toRotationMatrix();
  return Result<LivePose>::ok(live);
}

}  // namespace

Result<std::vector<LivePose>> readLive(const std::filesystem::path& path) {
  using Rows = Result<std::vector<LivePose>>;
  std::ifstream in(path);
  if (!in) {
    return Rows::fail("cannot read " + path.string());
  }
  std::vector<LivePose> rows;
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    if (line.empty() || line.front() == '#') {
      continue;
    }
    const auto row = liveRow(line);
    if (!row) {
      return Rows::fail(path.string() + " line " + std::to_string(number) + ": " + row.error);
    }
    rows.push_back(*row);
  }
  return Rows::ok(std::move(rows));
}

Result<std::vector<TrackedPose>> trackPoses(const std::vector<LivePose>& live, const std::vector<Pose>& truth,
                                            const std::optional<std::vector<Micros>>& truth_times_us) {
  using Tracked = Result<std::vector<TrackedPose>>;
  std::vector<TimedPose> poses;
  std::ranges::transform(live, std::back_inserter(poses), &LivePose::pose);
  const auto pairs = pairPoses(poses, truth, truth_times_us);
  if (!pairs) {
    return Tracked::fail(pairs.error);
  }
  const Pose T_truth_map = pairs->front().T_truth_body * pairs->front().T_map_body.inverse();
  std::vector<TrackedPose> tracked;
  for (const PosePair& pair : *pairs) {
    const auto at = std::ranges::find_if(live, [&](const LivePose& l) { return l.pose.utime_us == pair.utime_us; });
    const double error = (pair.T_truth_body.translation() - T_truth_map * pair.T_map_body.translation()).norm();
    tracked.push_back({pair.utime_us, error, !at->status.empty(), at->status == "aligned"});
  }
  return Tracked::ok(std::move(tracked));
}

RecoveryScore scoreRecovery(std::span<const TrackedPose> poses, Micros fault_us) {
  RecoveryScore score;
  score.end_error = poses.back().error;
  score.worst_error = std::ranges::max(poses, {}, &TrackedPose::error).error;
  score.longest_off = longestStretch(poses, [](const TrackedPose& p) { return p.error > kRightPlace; });
  score.longest_wrong = longestStretch(poses, [](const TrackedPose& p) { return p.error > kWrongPlace && p.is_sure; });
  score.said_after = saidAfter(poses, fault_us);
  score.back_after = backAfter(poses, fault_us);
  return score;
}

}  // namespace hgg
