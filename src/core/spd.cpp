#include "core/spd.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace hgg {
namespace {

/// Lower Cholesky factor; a pivot that rounding made negative counts as zero, so semi-definite input is fine.
Mat3 choleskyLower(const Mat3& a) {
  Mat3 l = Mat3::Zero();
  for (int j = 0; j < 3; ++j) {
    double pivot = a(j, j);
    for (int k = 0; k < j; ++k) {
      pivot -= l(j, k) * l(j, k);
    }
    l(j, j) = std::sqrt(std::max(pivot, 0.0));
    for (int i = j + 1; i < 3; ++i) {
      double v = a(i, j);
      for (int k = 0; k < j; ++k) {
        v -= l(i, k) * l(j, k);
      }
      l(i, j) = l(j, j) > 0 ? v / l(j, j) : 0.0;
    }
  }
  return l;
}

/// Rotates the columns of m until they are orthogonal (one-sided Jacobi): m V = U diag(sigma). Unlike an
/// eigendecomposition of m m^T it keeps the relative accuracy of small singular values.
Mat3 orthogonaliseColumns(Mat3 m) {
  for (int sweep = 0; sweep < 30; ++sweep) {
    bool rotated = false;
    for (int p = 0; p < 2; ++p) {
      for (int q = p + 1; q < 3; ++q) {
        const double a = m.col(p).squaredNorm(), b = m.col(q).squaredNorm(), c = m.col(p).dot(m.col(q));
        if (std::abs(c) <= 1e-16 * std::sqrt(a * b)) {
          continue;
        }
        rotated = true;
        const double zeta = (b - a) / (2 * c);
        const double t = std::copysign(1.0, zeta) / (std::abs(zeta) + std::sqrt(1.0 + zeta * zeta));
        const double cs = 1 / std::sqrt(1.0 + t * t), sn = cs * t;
        const Vec3 col_p = m.col(p);
        m.col(p) = cs * col_p - sn * m.col(q);
        m.col(q) = sn * col_p + cs * m.col(q);
      }
    }
    if (!rotated) {
      break;
    }
  }
  return m;
}

/// U diag(sigma) of L_a^-1 L_b, whose squared singular values are the generalised eigenvalues of (b, a).
Mat3 whitenedFactor(const Mat3& l_a, const Mat3& b) {
  return orthogonaliseColumns(l_a.triangularView<Eigen::Lower>().solve(choleskyLower(b)));
}

template <typename Function>
Mat3 spectral(const Mat3& a, Function f) {
  const Eigen3 e = eigenSymmetric(a);
  return e.vectors * Vec3(f(e.values[0]), f(e.values[1]), f(e.values[2])).asDiagonal() * e.vectors.transpose();
}

}  // namespace

Eigen3 eigenSymmetric(const Mat3& a) {
  Mat3 d = a, v = Mat3::Identity();
  for (int sweep = 0; sweep < 30; ++sweep) {
    bool rotated = false;
    for (int p = 0; p < 2; ++p) {
      for (int q = p + 1; q < 3; ++q) {
        if (std::abs(d(p, q)) <= 1e-17 * std::sqrt(std::abs(d(p, p) * d(q, q))) || std::abs(d(p, q)) < 1e-300) {
          continue;
        }
        rotated = true;
        const double theta = (d(q, q) - d(p, p)) / (2 * d(p, q));
        const double t = std::copysign(1.0, theta) / (std::abs(theta) + std::sqrt(1.0 + theta * theta));
        const double c = 1 / std::sqrt(1.0 + t * t), s = c * t;
        const int r = 3 - p - q;
        d(p, p) -= t * d(p, q);
        d(q, q) += t * d(p, q);
        d(p, q) = d(q, p) = 0;
        const double d_pr = d(p, r);
        d(p, r) = d(r, p) = c * d_pr - s * d(q, r);
        d(q, r) = d(r, q) = s * d_pr + c * d(q, r);
        const Vec3 v_p = v.col(p);
        v.col(p) = c * v_p - s * v.col(q);
        v.col(q) = s * v_p + c * v.col(q);
      }
    }
    if (!rotated) {
      break;
    }
  }
  std::array<int, 3> order{0, 1, 2};
  std::sort(order.begin(), order.end(), [&](int i, int k) { return d(i, i) < d(k, k); });
  Eigen3 out;
  for (int k = 0; k < 3; ++k) {
    out.values[k] = d(order[static_cast<std::size_t>(k)], order[static_cast<std::size_t>(k)]);
    out.vectors.col(k) = v.col(order[static_cast<std::size_t>(k)]);
  }
  if (out.vectors.determinant() < 0) {
    out.vectors.col(0) *= -1;
  }
  return out;
}

Mat3 spdSqrt(const Mat3& a) {
  return spectral(a, [](double x) { return std::sqrt(std::max(x, 0.0)); });
}

Mat3 spdLog(const Mat3& a) {
  return spectral(a, [](double x) { return std::log(x); });
}

Mat3 symExp(const Mat3& a) {
  return spectral(a, [](double x) { return std::exp(x); });
}

Mat3 spdPower(const Mat3& a, double exponent) {
  return spectral(a, [exponent](double x) { return std::pow(x, exponent); });
}

Mat3 spdGeodesic(const Mat3& a, const Mat3& b, double gamma) {
  // The geodesic is equivariant under congruence, so the Cholesky factor serves where the formula has a^(1/2).
  const Mat3 l = choleskyLower(a);
  Mat3 factor = whitenedFactor(l, b);
  for (int k = 0; k < 3; ++k) {
    factor.col(k) *= std::pow(factor.col(k).norm(), gamma - 1);
  }
  const Mat3 root = l * factor;
  return root * root.transpose();
}

double affineInvariantDistance(const Mat3& a, const Mat3& b) {
  const Mat3 factor = whitenedFactor(choleskyLower(a), b);
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    const double ln = std::log(factor.col(k).squaredNorm());
    sum += ln * ln;
  }
  return std::sqrt(sum);
}

double mahalanobis(const Vec3& d, const Mat3& s) {
  return choleskyLower(s).triangularView<Eigen::Lower>().solve(d).norm();
}

Mat3 withFloor(const Mat3& cov, double sigma_floor) { return cov + sigma_floor * sigma_floor * Mat3::Identity(); }

double nuclearNormOfRoots(const Mat3& a, const Mat3& b) {
  const Mat3 factor = orthogonaliseColumns(choleskyLower(a).transpose() * choleskyLower(b));
  return factor.colwise().norm().sum();
}

}  // namespace hgg
