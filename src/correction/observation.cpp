#include "correction/observation.h"

#include <Eigen/LU>

#include "core/spd.h"

namespace hgg {
namespace {

/// The ablation's weights: those of a fair view of an object half a metre across, chosen by hand. The ablation only
/// asks what weighing all alike costs.
constexpr double kUniformCount = 10, kUniformSigma = 0.1;  // points, m

}  // namespace

ObjectObservation observationOf(const Belief& belief, double views, double sigma_floor, const ObservationNoise& noise) {
  const Mat3 cov = withFloor(belief.cov, sigma_floor);
  if (noise.uniform_weights) {
    return {belief.mean, cov, Mat3::Identity() / (kUniformSigma * kUniformSigma), 0.5 * kUniformCount};
  }
  const double count = 1 / extentShare(noise.position, belief.kappa, views);
  const Mat3 cov_mean = cov / count + noiseVariance(noise.position, views) * Mat3::Identity();
  const Mat3 information = cov_mean.inverse();
  return {belief.mean, cov, 0.5 * (information + information.transpose()), 0.5 * count};
}

}  // namespace hgg
