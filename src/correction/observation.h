#pragma once

#include "core/belief.h"

namespace hgg {

/// How far one frame's view of an object is believed. The points of one scan are not independent, and a partial view or
/// an uneven segment moves the centroid by more than Sigma / kappa.
struct ObservationNoise {
  double view_share = 0.7;       // a centroid's error per view, as a share of the object's own spread
  double view_noise = 0.05;      // m, a centroid's error per view whatever the object's size
  double most_views = 10;        // what a belief from before the window is worth at most
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

/// n_eff = 1 / (1/kappa + view_share^2 / views), Cov[mu_obs] = cov / n_eff + view_noise^2 / views I and n_eff / 2 for
/// the extent, cov being floored by sigma_floor (m). `views` is 1 for what one frame saw and more for a belief gathered
/// over several. Needs kappa > 0 and a floored cov that is positive-definite.
ObjectObservation observationOf(const Belief& belief, double views, double sigma_floor, const ObservationNoise& noise);

}  // namespace hgg
