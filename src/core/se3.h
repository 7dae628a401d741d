#pragma once

#include "core/types.h"

namespace hgg {

/// Rigid poses, their tangents and the beliefs over them.
///
/// A tangent of a pose T_a_b is (v, w): a translation v (m) and a rotation vector w (rad), both in frame a, the turn
/// being about b's origin: retract(T, (v, w)) = (Exp(w) R, t + v).

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

/// A pose with its uncertainty: the inverse covariance of the tangent at T_map_body.
struct PoseBelief {
  Pose T_map_body = Pose::Identity();
  Mat6 information = Mat6::Zero();
};

/// The pose (Exp(w) R, t + v) for a tangent (v, w).
Pose retract(const Pose& T, const Vec6& tangent);

/// The tangent (v, w) that leads from T_0 to T: retract(T_0, localCoordinates(T, T_0)) = T.
Vec6 localCoordinates(const Pose& T, const Pose& T_0);

/// How far a motion turns, rad, 0 .. pi.
double turnOf(const Pose& T);

/// The derivative of the tangent of T_a_c by that of T_a_b, where c is rigidly fixed to b at `arm` = t_ac - t_ab (frame
/// a): a turn about b's origin also swings c's origin.
Mat6 tangentTransport(const Vec3& arm);

/// T with its rotation made orthonormal again. Products of many transforms stray from that by rounding, and as inverses
/// are taken by transposition, the error would grow without bound.
Pose orthonormalized(const Pose& T);

}  // namespace hgg
