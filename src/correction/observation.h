#pragma once

#include "core/belief.h"
#include "core/position_uncertainty.h"

namespace hgg {

/// How far the window trusts what a frame saw of an object.
struct ObservationNoise {
  PositionModel position = kPositionOfView;
  double most_views = 10;        // what a belief from before the window is worth at most; chosen by hand, not measured
  bool uniform_weights = false;  // ablation: every observation weighs the same, whatever was seen
};

/// An observed Gaussian with the information of eq. fgo: kappa Sigma^-1 for the mean and kappa / 2 I_6 for the
/// logarithm of the extent, where kappa is the effective count of observationOf(). In the frame of the belief it was
/// made from.
struct ObjectObservation {
  Vec3 mean = Vec3::Zero();                  // m
  Mat3 cov = Mat3::Identity();               // floored, m^2
  Mat3 mean_information = Mat3::Identity();  // 1/m^2
  double extent_information = 1;             // of each entry of r_Sigma
};

/// The mean's information is the inverse of positionCovariance (core/position_uncertainty.h) by `noise.position`; the
/// extent's is n_eff / 2, n_eff = 1 / extentShare being the independent points that the view is worth. cov is floored
/// by sigma_floor (m). `views` is 1 for what one frame saw and more for a belief gathered over several. Needs kappa > 0
/// and a floored cov that is positive-definite.
ObjectObservation observationOf(const Belief& belief, double views, double sigma_floor, const ObservationNoise& noise);

}  // namespace hgg
