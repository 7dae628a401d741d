#pragma once

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>

#include <array>
#include <memory>

#include "core/se3.h"
#include "correction/observation.h"

namespace hgg {

/// Factors of the correction (eqs fgo, odom_res, obj_res) for Ceres, with analytic derivatives.
///
/// A pose block is t (3, m) and the unit quaternion x y z w (4) of T_map_body; its tangent is the (v, w) of retract()
/// and localCoordinates(): T = (Exp(w) R, t + v), both in the map frame. Derivatives by the tangent are exact. Ceres
/// asks for those by the seven numbers: the factors give it the tangent's times the manifold's minus Jacobian, and
/// Ceres gets the tangent's back when it multiplies by the plus Jacobian.
///
/// An object block is mu (3, m) and L = log Sigma (6: entries 00 11 22 01 02 12), both in the map frame. The two are
/// one block because the Schur complement can only eliminate blocks that share no factor.

constexpr int kPoseSize = 7, kObjectSize = 9;
using PoseBlock = std::array<double, kPoseSize>;
using ObjectBlock = std::array<double, kObjectSize>;
using Vec9 = Eigen::Matrix<double, 9, 1>;

PoseBlock poseBlock(const Pose& T_map_body);
Pose poseOf(const double* pose_block);
ObjectBlock objectBlock(const Vec3& mean_map, const Mat3& log_cov_map);
/// L of the block.
Mat3 logExtentOf(const double* object_block);

class PoseManifold : public ceres::Manifold {
 public:
  int AmbientSize() const override { return kPoseSize; }
  int TangentSize() const override { return 6; }
  /// retract()
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;  // 7x6, row-major
  /// localCoordinates()
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;  // 6x7, row-major
};

/// Options of a problem that owns neither its factors nor its loss nor its manifold.
ceres::Problem::Options borrowing();

/// Dynamic covariance scaling (Agarwal et al., 2013) as a loss: a squared error s counts in full up to phi, and beyond
/// it with the weight rho' = (2 phi / (phi + s))^2. True measurements keep their weight and false ones lose theirs.
class ScalingLoss : public ceres::LossFunction {
 public:
  explicit ScalingLoss(double phi) : phi_(phi) {}
  void setScale(double phi) { phi_ = phi; }
  void Evaluate(double s, double rho[3]) const override;

 private:
  double phi_;
};

/// eq. odom_res on pose blocks (a, b): information^(1/2) localCoordinates(T_a^-1 T_b, measured), 6 residuals. The
/// tangent of the residuals and of the information is (translation, rotation vector) in frame a about b's origin.
std::unique_ptr<ceres::CostFunction> betweenFactor(const Pose& T_a_b, const Mat6& information);

/// information^(1/2) localCoordinates(T, prior) on a pose block, 6 residuals in the map frame.
std::unique_ptr<ceres::CostFunction> posePriorFactor(const PoseBelief& prior);

/// eq. obj_res on (pose block, object block): 9 residuals, r_mu times the root of the mean's information and r_Sigma
/// times that of the extent's. With the identity as a constant pose it is the object's prior in the map frame.
std::unique_ptr<ceres::CostFunction> objectFactor(const ObjectObservation& observation_body);

/// eq. obj_res itself, unweighted: r_mu = R^T (mu - t) - mu_obs (3, m, body frame) and r_Sigma = vech_W(U^T (R^T L R -
/// log Sigma_obs) U) (6, entries 00 11 22 01 02 12 by ascending axes of the observation), L = log Sigma in the map
/// frame.
Vec9 objectResidual(const Pose& T_map_body, const Vec3& mean_map, const Mat3& log_cov_map,
                    const ObjectObservation& observation_body);

}  // namespace hgg
