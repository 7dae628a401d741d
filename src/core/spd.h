#pragma once

#include "core/types.h"

namespace hgg {

/// Operations on 3x3 symmetric positive-definite matrices by Jacobi rotations and Cholesky factors; nothing here
/// iterates on a general-purpose solver. All hold for eigenvalue ratios down to 1e-6 and below.

struct Eigen3 {
  Vec3 values;   // ascending
  Mat3 vectors;  // columns, right-handed
};
/// Eigendecomposition of a symmetric matrix by cyclic Jacobi.
Eigen3 eigenSymmetric(const Mat3& a);

Mat3 spdSqrt(const Mat3& a);
Mat3 spdLog(const Mat3& a);
/// Matrix exponential of any symmetric matrix.
Mat3 symExp(const Mat3& a);
Mat3 spdPower(const Mat3& a, double exponent);

/// Point at gamma on the affine-invariant geodesic from a (gamma 0) to b (gamma 1).
Mat3 spdGeodesic(const Mat3& a, const Mat3& b, double gamma);

/// Affine-invariant Riemannian distance sqrt(sum ln^2 lambda_k), lambda_k the generalised eigenvalues of (a, b).
double affineInvariantDistance(const Mat3& a, const Mat3& b);

/// tr (a^(1/2) b a^(1/2))^(1/2): the sum of the singular values of a^(1/2) b^(1/2). Semi-definite input is fine.
double nuclearNormOfRoots(const Mat3& a, const Mat3& b);

/// sqrt(d^T s^-1 d) for positive-definite s.
double mahalanobis(const Vec3& d, const Mat3& s);

/// cov + sigma_floor^2 I: what every inverse and logarithm of an extent works on, since extents can be flat.
Mat3 withFloor(const Mat3& cov, double sigma_floor);

}  // namespace hgg
