#pragma once

#include "core/types.h"

namespace hgg {

/// Rotations and their tangents: a rotation vector w (rad) stands for Exp(w), the turn by |w| about w.

/// [v]x, so that skew(v) u = v x u.
Mat3 skew(const Vec3& v);
Mat3 expRotation(const Vec3& w);
/// The rotation vector of a rotation, at most pi long.
Vec3 logRotation(const Mat3& R);
/// Derivative of the rotation vector of Exp(w') Exp(w) by w' at 0: the inverse of the left Jacobian of SO(3).
Mat3 inverseLeftJacobian(const Vec3& w);

}  // namespace hgg
