#pragma once

#include <cmath>

#include "core/types.h"
#include "core/units.h"

namespace hgg {

/// How far the mean of an object can be trusted. The points of one view are not independent: a partial view or an
/// uneven segment moves the mean by a share of the object's extent however many points there are, and whatever all
/// views have in common (the side they saw, the sensor's bias) does not average out over them. The one model of it:
///
///   Cov[mean] = (1 / kappa + view_share^2 / views + common_share^2) cov + (view_noise^2 / views + common_noise^2) I
///
/// with the extent cov (m^2) of kappa points gathered over `views` views.
struct PositionModel {
  double view_share = 0;    // of the extent: error of one view's mean, independent from view to view
  double view_noise = 0;    // m, the same for an object without extent
  double common_share = 0;  // of the extent: error that all views share
  double common_noise = 0;  // m, the same for an object without extent
};

/// A mean within one drive, against the truth. The four constants are a joint fit (a grid search) to the position
/// errors of eight drives; docs/experiments.md, "How well a position is known", has the table, and three more drives
/// that were not part of the fit.
inline constexpr PositionModel kPositionWithinDrive{
    .view_share = 0.7, .view_noise = 0.05, .common_share = 0.06, .common_noise = 0.02};

/// One view against others of the same drive: what all of them share does not move one against another.
inline constexpr PositionModel kPositionOfView{.view_share = kPositionWithinDrive.view_share,
                                               .view_noise = kPositionWithinDrive.view_noise};

/// A mean of one drive against that of another. The other drive saw other sides of the object, which moves the mean by
/// far more than a single drive can tell, and both maps have many views of it, so that only the common terms are left.
/// Chosen by hand, not fitted; the table of docs/experiments.md, "Simulated submaps", was measured with these values.
inline constexpr PositionModel kPositionBetweenDrives{.common_share = 0.3, .common_noise = 0.08};

/// The factor of the extent in the model: 1 / kappa + view_share^2 / views + common_share^2. Its inverse is the number
/// of independent points that the evidence is worth.
constexpr double extentShare(const PositionModel& model, double kappa, double views) {
  return 1 / kappa + square(model.view_share) / views + square(model.common_share);
}

/// The factor of the identity in the model, m^2: view_noise^2 / views + common_noise^2.
constexpr double noiseVariance(const PositionModel& model, double views) {
  return square(model.view_noise) / views + square(model.common_noise);
}

/// Covariance of a mean by the model, m^2, of an extent `cov` (m^2). Needs kappa > 0 and views > 0.
inline Mat3 positionCovariance(const PositionModel& model, const Mat3& cov, double kappa, double views) {
  return extentShare(model, kappa, views) * cov + noiseVariance(model, views) * Mat3::Identity();
}

/// Standard deviation of a mean per axis, m, in the limit of many points and many views: what the common terms leave.
/// `extent` is the standard deviation of the object's extent along the axis, m.
inline double commonDeviation(const PositionModel& model, double extent) {
  return std::hypot(model.common_noise, model.common_share * extent);
}

}  // namespace hgg
