#include "eval/trajectory.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace hgg {
namespace {

constexpr Micros kTimeTolerance_us = 5000;
constexpr double kRounding = 1e-6;  // m: what a sum of steps may lack

/// The rotation nearest to M in the Frobenius norm.
Mat3 nearestRotation(const Mat3& M) {
  const Eigen::JacobiSVD<Mat3> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = svd.matrixU().determinant() * svd.matrixV().determinant() < 0 ? -1.0 : 1.0;
  return svd.matrixU() * Vec3(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
}

struct Means {
  Vec3 truth = Vec3::Zero(), map = Vec3::Zero();
};

Means meanPositions(const std::vector<PosePair>& pairs) {
  Means means;
  for (const PosePair& pair : pairs) {
    means.truth += pair.T_truth_body.translation() / static_cast<double>(pairs.size());
    means.map += pair.T_map_body.translation() / static_cast<double>(pairs.size());
  }
  return means;
}

Pose alignmentWith(const Mat3& R_truth_map, const Means& means) {
  Pose T_truth_map = Pose::Identity();
  T_truth_map.linear() = R_truth_map;
  T_truth_map.translation() = means.truth - R_truth_map * means.map;
  return T_truth_map;
}

/// Umeyama's alignment without scale.
Pose alignPositions(const std::vector<PosePair>& pairs) {
  const Means means = meanPositions(pairs);
  Mat3 M = Mat3::Zero();
  for (const PosePair& pair : pairs) {
    M += (pair.T_truth_body.translation() - means.truth) * (pair.T_map_body.translation() - means.map).transpose();
  }
  return alignmentWith(nearestRotation(M), means);
}

const TimedPose* nearestInTime(const std::vector<TimedPose>& sorted, Micros time_us) {
  const auto after = std::ranges::lower_bound(sorted, time_us, {}, &TimedPose::utime_us);
  const TimedPose* best = nullptr;
  for (const auto& at : {after, after == sorted.begin() ? after : after - 1}) {
    if (at != sorted.end() &&
        (best == nullptr || std::abs(at->utime_us - time_us) < std::abs(best->utime_us - time_us))) {
      best = &*at;
    }
  }
  return best != nullptr && std::abs(best->utime_us - time_us) <= kTimeTolerance_us ? best : nullptr;
}

std::vector<PosePair> pairByTime(std::vector<TimedPose> estimate, const std::vector<Pose>& truth,
                                 const std::vector<Micros>& times_us) {
  std::ranges::stable_sort(estimate, {}, &TimedPose::utime_us);
  std::vector<PosePair> pairs;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (const TimedPose* match = nearestInTime(estimate, times_us[i])) {
      pairs.push_back({truth[i], match->T_map_body, match->utime_us});
    }
  }
  return pairs;
}

std::vector<PosePair> pairByRow(const std::vector<TimedPose>& estimate, const std::vector<Pose>& truth) {
  std::vector<PosePair> pairs;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    pairs.push_back({truth[i], estimate[i].T_map_body, estimate[i].utime_us});
  }
  return pairs;
}

/// What the estimated motion from one pose to another adds to the true one.
Pose motionError(const PosePair& from, const PosePair& to) {
  const Pose truth = from.T_truth_body.inverse() * to.T_truth_body;
  return truth.inverse() * (from.T_map_body.inverse() * to.T_map_body);
}

std::string countsOf(const std::vector<TimedPose>& estimate, const std::vector<Pose>& truth) {
  return std::to_string(estimate.size()) + " estimated and " + std::to_string(truth.size()) + " true poses";
}

}  // namespace

Result<std::vector<PosePair>> pairPoses(const std::vector<TimedPose>& estimate, const std::vector<Pose>& truth,
                                        const std::optional<std::vector<Micros>>& truth_times_us) {
  using Pairs = Result<std::vector<PosePair>>;
  if (truth_times_us && truth_times_us->size() != truth.size()) {
    return Pairs::fail(std::to_string(truth_times_us->size()) + " times for " + std::to_string(truth.size()) +
                       " true poses");
  }
  if (!truth_times_us && estimate.size() != truth.size()) {
    return Pairs::fail(countsOf(estimate, truth) + ": give the times of the true poses with --times");
  }
  auto pairs = truth_times_us ? pairByTime(estimate, truth, *truth_times_us) : pairByRow(estimate, truth);
  if (pairs.size() < 2) {
    return Pairs::fail(countsOf(estimate, truth) + " make fewer than two pairs: do their times belong together?");
  }
  return Pairs::ok(std::move(pairs));
}

std::optional<std::size_t> indexAt(std::span<const PosePair> pairs, Micros time_us) {
  const auto distance = [&](const PosePair& pair) { return std::abs(pair.utime_us - time_us); };
  const auto nearest = std::ranges::min_element(pairs, {}, distance);
  return nearest != pairs.end() && distance(*nearest) <= kTimeTolerance_us
             ? std::optional(static_cast<std::size_t>(nearest - pairs.begin()))
             : std::nullopt;
}

std::vector<double> distancesAlong(std::span<const PosePair> pairs) {
  std::vector<double> way;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Pose& here = pairs[i].T_truth_body;
    way.push_back(i == 0 ? 0.0 : way.back() + (here.translation() - pairs[i - 1].T_truth_body.translation()).norm());
  }
  return way;
}

Pose alignMap(const std::vector<PosePair>& pairs) {
  Mat3 sum = Mat3::Zero();
  for (const PosePair& pair : pairs) {
    sum += pair.T_truth_body.linear() * pair.T_map_body.linear().transpose();
  }
  return alignmentWith(nearestRotation(sum), meanPositions(pairs));
}

std::vector<double> positionErrors(const std::vector<PosePair>& pairs) {
  const Pose T_truth_map = alignPositions(pairs);
  std::vector<double> errors;
  for (const PosePair& pair : pairs) {
    errors.push_back((pair.T_truth_body.translation() - T_truth_map * pair.T_map_body.translation()).norm());
  }
  return errors;
}

double absoluteTrajectoryError(const std::vector<PosePair>& pairs) {
  double squares = 0;
  for (const double error : positionErrors(pairs)) {
    squares += error * error;
  }
  return std::sqrt(squares / static_cast<double>(pairs.size()));
}

double heightError(const std::vector<PosePair>& pairs) {
  const Pose T_truth_map = alignMap(pairs);
  double worst = 0;
  for (const PosePair& pair : pairs) {
    const Vec3 error = T_truth_map * pair.T_map_body.translation() - pair.T_truth_body.translation();
    worst = std::max(worst, std::abs(error.z()));
  }
  return worst;
}

RelativeError relativeError(const std::vector<PosePair>& pairs) {
  const std::vector<double> way = distancesAlong(pairs);
  RelativeError sum;
  sum.stretch = std::min(100.0, way.empty() ? 0.0 : way.back() / 2);
  for (std::size_t i = 0; sum.stretch > 0 && i < pairs.size(); ++i) {
    const auto end = std::ranges::lower_bound(way, way[i] + sum.stretch - kRounding);
    if (end == way.end()) {
      break;
    }
    const Pose E = motionError(pairs[i], pairs[static_cast<std::size_t>(end - way.begin())]);
    const double per_100_m = 100 / (*end - way[i]);
    sum.translation += per_100_m * E.translation().norm();
    sum.rotation_deg += per_100_m * Eigen::AngleAxisd(E.linear()).angle() * 180 / std::numbers::pi;
    ++sum.count;
  }
  const double n = sum.count > 0 ? static_cast<double>(sum.count) : std::numeric_limits<double>::quiet_NaN();
  return {sum.stretch, sum.count, sum.translation / n, sum.rotation_deg / n};
}

}  // namespace hgg
