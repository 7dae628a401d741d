#include "eval/loops.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

namespace hgg {
namespace {

constexpr double kOutdoors = 1.0;  // m, of the radius

using nlohmann::json;

bool isCount(const json& stats, const char* key) { return stats.contains(key) && stats[key].is_number_unsigned(); }

bool isMatrix(const json& rows) {
  return rows.is_array() && rows.size() == 12 && std::ranges::all_of(rows, [](const json& x) { return x.is_number(); });
}

bool hasTime(const json& entry, const char* key) { return entry.contains(key) && entry[key].is_number_integer(); }

std::optional<LoopRun> loopOf(const json& entry) {
  if (!entry.is_object() || !hasTime(entry, "before_us") || !hasTime(entry, "now_us") || !entry.contains("accepted") ||
      !entry["accepted"].is_boolean()) {
    return std::nullopt;
  }
  LoopRun loop{entry["before_us"].get<Micros>(), entry["now_us"].get<Micros>(), entry["accepted"].get<bool>(),
               Pose::Identity()};
  if (!loop.accepted) {
    return loop;  // a refusal has no motion to be wrong
  }
  if (!entry.contains("T_before_now") || !isMatrix(entry["T_before_now"])) {
    return std::nullopt;
  }
  for (Eigen::Index k = 0; k < 12; ++k) {
    loop.T_before_now.matrix()(k / 4, k % 4) = entry["T_before_now"][static_cast<std::size_t>(k)].get<double>();
  }
  return loop;
}

struct LoopError {
  double distance = 0, angle_deg = 0;
};

/// nullopt where an end has no true pose.
std::optional<LoopError> errorOf(const LoopRun& loop, std::span<const PosePair> pairs) {
  const auto before = indexAt(pairs, loop.before_us), now = indexAt(pairs, loop.now_us);
  if (!before || !now) {
    return std::nullopt;
  }
  const Pose T_before_now = pairs[*before].T_truth_body.inverse() * pairs[*now].T_truth_body;
  const Pose E = T_before_now.inverse() * loop.T_before_now;
  return LoopError{E.translation().norm(), Eigen::AngleAxisd(E.linear()).angle() * 180 / std::numbers::pi};
}

bool isFalse(const LoopError& error) {
  return !(error.distance <= kFalseLoop && error.angle_deg <= kFalseLoopTurn_deg);
}

/// One pose every `step` m of way.
std::vector<std::size_t> spacedAlong(std::span<const double> way, double step) {
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < way.size(); ++i) {
    if (kept.empty() || way[i] - way[kept.back()] >= step) {
      kept.push_back(i);
    }
  }
  return kept;
}

bool isInTime(const Revisit& revisit, double way, double around) {
  return way >= revisit.first - around && way <= std::max(revisit.last, revisit.first + around);
}

}  // namespace

RevisitScale revisitScale(double radius) {
  return radius >= kOutdoors ? RevisitScale{2, 10, 100, 30} : RevisitScale{0.5, 3, 15, 5};
}

Result<LoopRuns> readLoops(const json& stats) {
  if (!isCount(stats, "loops_accepted") || !isCount(stats, "loops_rejected") || !stats.contains("loops") ||
      !stats["loops"].is_array()) {
    return Result<LoopRuns>::fail("loops, loops_accepted or loops_rejected is not what a run writes");
  }
  LoopRuns runs{stats["loops_accepted"].get<std::size_t>(), stats["loops_rejected"].get<std::size_t>(), {}};
  for (const json& entry : stats["loops"]) {
    const auto loop = loopOf(entry);
    if (!loop) {
      return Result<LoopRuns>::fail("loop " + std::to_string(runs.list.size() + 1) + " is not what a run writes");
    }
    runs.list.push_back(*loop);
  }
  return Result<LoopRuns>::ok(std::move(runs));
}

std::vector<Revisit> findRevisits(std::span<const PosePair> pairs, const RevisitScale& scale) {
  const std::vector<double> way = distancesAlong(pairs);
  const std::vector<std::size_t> kept = spacedAlong(way, scale.step);
  const auto meets = [&](std::size_t now, std::size_t before) {
    return way[now] - way[before] > scale.left &&
           (pairs[now].T_truth_body.translation() - pairs[before].T_truth_body.translation()).norm() <= scale.near;
  };
  std::vector<Revisit> revisits;
  bool is_going_on = false;
  for (std::size_t k = 0; k < kept.size(); ++k) {
    const auto earlier = std::span(kept).first(k);
    const bool is_back = std::ranges::any_of(earlier, [&](std::size_t before) { return meets(kept[k], before); });
    if (is_back && is_going_on) {
      revisits.back().last = way[kept[k]];
    } else if (is_back) {
      revisits.push_back({way[kept[k]], way[kept[k]]});
    }
    is_going_on = is_back;
  }
  return revisits;
}

LoopScore scoreLoops(const LoopRuns& runs, std::span<const PosePair> pairs, const RevisitScale& scale) {
  constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
  LoopScore score{runs.accepted + runs.rejected, runs.accepted, 0, 0, kNothing, kNothing, 0, 0, 0};
  const std::vector<double> way = distancesAlong(pairs);
  std::vector<double> asked, closed;  // m of way, of the keyframe that asked
  for (const LoopRun& loop : runs.list) {
    const auto now = indexAt(pairs, loop.now_us);
    const auto error = loop.accepted ? errorOf(loop, pairs) : std::nullopt;
    if (now) {
      asked.push_back(way[*now]);
    }
    if (now && error && !isFalse(*error)) {
      closed.push_back(way[*now]);
    }
    if (error) {
      ++score.checked;
      score.wrong += isFalse(*error) ? 1 : 0;
      score.worst = std::fmax(score.worst, error->distance);
      score.worst_deg = std::fmax(score.worst_deg, error->angle_deg);
    }
  }
  for (const Revisit& revisit : findRevisits(pairs, scale)) {
    const auto is_in_time = [&](double at) { return isInTime(revisit, at, scale.around); };
    ++score.revisits;
    score.revisits_asked += std::ranges::any_of(asked, is_in_time) ? 1 : 0;
    score.revisits_closed += std::ranges::any_of(closed, is_in_time) ? 1 : 0;
  }
  return score;
}

}  // namespace hgg
