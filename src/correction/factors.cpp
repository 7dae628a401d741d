#include "correction/factors.h"

#include <ceres/sized_cost_function.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/so3.h"
#include "core/spd.h"

namespace hgg {
namespace {

template <int Rows, int Columns>
using RowMajor = Eigen::Matrix<double, Rows, Columns, Eigen::RowMajor>;
using Mat6x3 = Eigen::Matrix<double, 6, 3>;
using Mat4x3 = Eigen::Matrix<double, 4, 3>;

/// Entries of a symmetric 3x3 matrix in the order of the blocks and residuals.
constexpr std::array<std::array<Eigen::Index, 2>, 6> kEntries{{{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}}};

Eigen::Map<const Vec3> position(const double* pose_block) { return Eigen::Map<const Vec3>(pose_block); }

Mat3 rotation(const double* pose_block) {
  return Eigen::Map<const Eigen::Quaterniond>(pose_block + 3).toRotationMatrix();
}

/// Derivative of Exp(w) q by w at 0, rows x y z w. Its columns are orthogonal and of length 1/2.
Mat4x3 quaternionByTurn(const double* pose_block) {
  const Eigen::Map<const Eigen::Quaterniond> q(pose_block + 3);
  Mat4x3 J;
  J.topRows<3>() = 0.5 * (q.w() * Mat3::Identity() - skew(q.vec()));
  J.bottomRows<1>() = -0.5 * q.vec().transpose();
  return J;
}

/// Stores the derivatives by a pose's tangent (v, w) as derivatives by its seven numbers, which Ceres asks for.
template <int Rows, typename ByMove, typename ByTurn>
void storePoseJacobian(const double* pose_block, const Eigen::MatrixBase<ByMove>& by_move,
                       const Eigen::MatrixBase<ByTurn>& by_turn, double* jacobian) {
  Eigen::Map<RowMajor<Rows, kPoseSize>> J(jacobian);
  J.template leftCols<3>() = by_move;
  J.template rightCols<4>() = 4 * by_turn * quaternionByTurn(pose_block).transpose();
}

/// W with W^T W = information. Eigenvalues that rounding has made negative count as zero.
template <typename Matrix>
Matrix rootOf(const Matrix& information) {
  const Eigen::SelfAdjointEigenSolver<Matrix> e(information);
  return e.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() * e.eigenvectors().transpose();
}

class BetweenFactor : public ceres::SizedCostFunction<6, kPoseSize, kPoseSize> {
 public:
  BetweenFactor(const Pose& T_a_b, const Mat6& information) : T_a_b_(T_a_b), root_(rootOf(information)) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const Mat3 R_a_map = rotation(parameters[0]).transpose();
    const Vec3 way_map = position(parameters[1]) - position(parameters[0]);
    const Vec3 turn = logRotation(R_a_map * rotation(parameters[1]) * T_a_b_.linear().transpose());
    Vec6 difference;
    difference << R_a_map * way_map - T_a_b_.translation(), turn;
    Eigen::Map<Vec6>(residuals, 6) = root_ * difference;
    if (jacobians == nullptr) {
      return true;
    }
    const Mat6x3 by_move_b = root_.leftCols<3>() * R_a_map;
    const Mat6x3 by_turn_b = root_.rightCols<3>() * inverseLeftJacobian(turn) * R_a_map;
    if (jacobians[0] != nullptr) {
      // When a turns by w, b as seen from a moves by -w x (b - a).
      const Mat6x3 by_turn_a = by_move_b * skew(way_map) - by_turn_b;
      storePoseJacobian<6>(parameters[0], -by_move_b, by_turn_a, jacobians[0]);
    }
    if (jacobians[1] != nullptr) {
      storePoseJacobian<6>(parameters[1], by_move_b, by_turn_b, jacobians[1]);
    }
    return true;
  }

 private:
  Pose T_a_b_;
  Mat6 root_;
};

class PosePriorFactor : public ceres::SizedCostFunction<6, kPoseSize> {
 public:
  explicit PosePriorFactor(const PoseBelief& prior) : T_(prior.T_map_body), root_(rootOf(prior.information)) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const Vec6 difference = localCoordinates(poseOf(parameters[0]), T_);
    Eigen::Map<Vec6>(residuals, 6) = root_ * difference;
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      const Mat6x3 by_turn = root_.rightCols<3>() * inverseLeftJacobian(difference.tail<3>());
      storePoseJacobian<6>(parameters[0], root_.leftCols<3>(), by_turn, jacobians[0]);
    }
    return true;
  }

 private:
  Pose T_;
  Mat6 root_;
};

/// w_ab of eq. obj_res by the gap of two log eigenvalues.
double axisWeight(double gap) {
  const double x = 0.5 * std::abs(gap);
  return std::numbers::sqrt2 * (x < 1e-4 ? 1 + x * x / 6 : std::sinh(x) / x);
}

/// What eq. obj_res needs of the observed covariance, computed once per factor.
struct ObservedExtent {
  Mat3 axes;        // U
  Vec3 log_values;  // ln lambda
  Vec6 weights;     // w_ab in the order of kEntries

  explicit ObservedExtent(const Mat3& cov) {
    const Eigen3 e = eigenSymmetric(cov);
    axes = e.vectors;
    log_values = e.values.array().log();
    for (std::size_t k = 0; k < kEntries.size(); ++k) {
      const auto [a, b] = kEntries[k];
      weights[static_cast<Eigen::Index>(k)] = a == b ? 1.0 : axisWeight(log_values[a] - log_values[b]);
    }
  }

  /// vech_W of a symmetric matrix given on the axes.
  Vec6 weighted(const Mat3& on_axes) const {
    Vec6 v;
    v << on_axes.diagonal(), on_axes(0, 1), on_axes(0, 2), on_axes(1, 2);
    return v.cwiseProduct(weights);
  }
};

class ObjectFactor : public ceres::SizedCostFunction<9, kPoseSize, kObjectSize> {
 public:
  explicit ObjectFactor(const ObjectObservation& seen)
      : mean_(seen.mean),
        extent_(seen.cov),
        root_mean_(rootOf(seen.mean_information)),
        root_extent_(std::sqrt(std::max(seen.extent_information, 0.0))) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const Mat3 R_body_map = rotation(parameters[0]).transpose();
    const Vec3 way_map = Eigen::Map<const Vec3>(parameters[1]) - position(parameters[0]);
    const Mat3 axes_map = R_body_map.transpose() * extent_.axes;
    const Mat3 seen = axes_map.transpose() * logExtentOf(parameters[1]) * axes_map;
    Eigen::Map<Vec9> r(residuals);
    r.head<3>() = root_mean_ * (R_body_map * way_map - mean_);
    r.tail<6>() = root_extent_ * extent_.weighted(seen - extent_.log_values.asDiagonal().toDenseMatrix());
    if (jacobians == nullptr) {
      return true;
    }
    const Mat3 by_mean = root_mean_ * R_body_map;
    if (jacobians[0] != nullptr) {
      Eigen::Matrix<double, 9, 3> by_move = Eigen::Matrix<double, 9, 3>::Zero(), by_turn;
      by_move.topRows<3>() = -by_mean;
      by_turn << by_mean * skew(way_map), extentByTurn(seen) * axes_map.transpose();
      storePoseJacobian<9>(parameters[0], by_move, by_turn, jacobians[0]);
    }
    if (jacobians[1] != nullptr) {
      Eigen::Map<RowMajor<9, kObjectSize>> J(jacobians[1]);
      J.setZero();
      J.topLeftCorner<3, 3>() = by_mean;
      J.bottomRightCorner<6, 6>() = extentByLogExtent(axes_map);
    }
    return true;
  }

 private:
  /// Of r_Sigma by the body's turn along the observation's axes: [M, [e_k]x], M being L on those axes.
  Mat6x3 extentByTurn(const Mat3& seen) const {
    Mat6x3 J;
    for (Eigen::Index k = 0; k < 3; ++k) {
      const Mat3 turn = skew(Vec3::Unit(k));
      J.col(k) = root_extent_ * extent_.weighted(seen * turn - turn * seen);
    }
    return J;
  }

  Mat6 extentByLogExtent(const Mat3& axes_map) const {
    Mat6 J;
    for (std::size_t k = 0; k < kEntries.size(); ++k) {
      const auto [i, j] = kEntries[k];
      const Mat3 half = axes_map.row(i).transpose() * axes_map.row(j);
      J.col(static_cast<Eigen::Index>(k)) =
          root_extent_ * extent_.weighted(i == j ? half : Mat3(half + half.transpose()));
    }
    return J;
  }

  Vec3 mean_;
  ObservedExtent extent_;
  Mat3 root_mean_;
  double root_extent_;
};

}  // namespace

PoseBlock poseBlock(const Pose& T_map_body) {
  PoseBlock block;
  Eigen::Map<Vec3>(block.data()) = T_map_body.translation();
  Eigen::Map<Eigen::Quaterniond>(block.data() + 3) = Eigen::Quaterniond(Mat3(T_map_body.linear())).normalized();
  return block;
}

Pose poseOf(const double* pose_block) {
  Pose T = Pose::Identity();
  T.linear() = rotation(pose_block);
  T.translation() = position(pose_block);
  return T;
}

ObjectBlock objectBlock(const Vec3& mean_map, const Mat3& log_cov_map) {
  ObjectBlock block;
  Eigen::Map<Vec3>(block.data()) = mean_map;
  for (std::size_t k = 0; k < kEntries.size(); ++k) {
    block[3 + k] = log_cov_map(kEntries[k][0], kEntries[k][1]);
  }
  return block;
}

Mat3 logExtentOf(const double* object_block) {
  const double* l = object_block + 3;
  Mat3 L;
  L << l[0], l[3], l[4], l[3], l[1], l[5], l[4], l[5], l[2];
  return L;
}

bool PoseManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  const Eigen::Quaterniond turn(expRotation(Eigen::Map<const Vec3>(delta + 3)));
  const Eigen::Quaterniond q = (turn * Eigen::Map<const Eigen::Quaterniond>(x + 3)).normalized();
  Eigen::Map<Vec3>(x_plus_delta, 3) = position(x) + Eigen::Map<const Vec3>(delta);
  Eigen::Map<Eigen::Quaterniond>(x_plus_delta + 3) = q;
  return true;
}

bool PoseManifold::PlusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<RowMajor<kPoseSize, 6>> J(jacobian);
  J.setZero();
  J.topLeftCorner<3, 3>().setIdentity();
  J.bottomRightCorner<4, 3>() = quaternionByTurn(x);
  return true;
}

bool PoseManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  Eigen::Map<Vec6>(y_minus_x, 6) = localCoordinates(poseOf(y), poseOf(x));
  return true;
}

bool PoseManifold::MinusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<RowMajor<6, kPoseSize>> J(jacobian);
  J.setZero();
  J.topLeftCorner<3, 3>().setIdentity();
  J.bottomRightCorner<3, 4>() = 4 * quaternionByTurn(x).transpose();
  return true;
}

ceres::Problem::Options borrowing() {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.disable_all_safety_checks = true;
  return options;
}

void ScalingLoss::Evaluate(double s, double rho[3]) const {
  if (s <= phi_) {
    rho[0] = s, rho[1] = 1, rho[2] = 0;
    return;
  }
  const double share = 2 * phi_ / (phi_ + s);
  rho[0] = phi_ * (3 - 2 * share);
  rho[1] = share * share;
  rho[2] = -2 * share * share / (phi_ + s);
}

std::unique_ptr<ceres::CostFunction> betweenFactor(const Pose& T_a_b, const Mat6& information) {
  return std::make_unique<BetweenFactor>(T_a_b, information);
}

std::unique_ptr<ceres::CostFunction> posePriorFactor(const PoseBelief& prior) {
  return std::make_unique<PosePriorFactor>(prior);
}

std::unique_ptr<ceres::CostFunction> objectFactor(const ObjectObservation& observation_body) {
  return std::make_unique<ObjectFactor>(observation_body);
}

Vec9 objectResidual(const Pose& T_map_body, const Vec3& mean_map, const Mat3& log_cov_map,
                    const ObjectObservation& observation_body) {
  const ObservedExtent extent(observation_body.cov);
  const Mat3 axes_map = T_map_body.linear() * extent.axes;
  const Mat3 seen = axes_map.transpose() * log_cov_map * axes_map;
  Vec9 r;
  r << T_map_body.linear().transpose() * (mean_map - T_map_body.translation()) - observation_body.mean,
      extent.weighted(seen - extent.log_values.asDiagonal().toDenseMatrix());
  return r;
}

}  // namespace hgg
