#include "correction/window.h"

#include <ceres/problem.h>
#include <ceres/solver.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <span>

#include "core/spd.h"
#include "correction/factors.h"

namespace hgg {
namespace {

using Mat9 = Eigen::Matrix<double, 9, 9>;
template <int Rows, int Columns>
using RowMajor = Eigen::Matrix<double, Rows, Columns, Eigen::RowMajor>;

/// A belief with less evidence than a trace of one point, or wider than 10 km (no map is), is left out.
constexpr double kLeastEvidence = 1e-3, kWidestVariance = 1e8;  // points, m^2
/// The solver's steps are Newton-like: after one that changes the cost by less than this share, the next would change
/// it by far less.
constexpr double kCostTolerance = 1e-5;
/// Information that keeps the marginals finite where no factor constrains a pose: a kilometre, a thousand radians.
constexpr double kHardlyKnown = 1e-6;

/// A residual block: on a pose alone, on two poses, or on a pose and an object.
struct Factor {
  std::unique_ptr<ceres::CostFunction> cost;
  int pose = 0, other_pose = -1, object = -1;
};

struct FactorGraph {
  std::vector<PoseBlock> poses;      // the window's and, last, the map's origin, from which objects' priors are seen
  std::vector<ObjectBlock> objects;  // the problem's; only those with factors are solved for
  std::vector<Belief> gathered;      // prior and observed; kappa is final, the rest a start
  std::vector<Factor> factors;
  std::vector<bool> observed;  // per object

  int poseCount() const { return static_cast<int>(poses.size()) - 1; }
  double* block(const Factor& f) { return poses[static_cast<std::size_t>(f.pose)].data(); }
  double* otherBlock(const Factor& f) {
    return f.object >= 0 ? objects[static_cast<std::size_t>(f.object)].data()
                         : poses[static_cast<std::size_t>(f.other_pose)].data();
  }
};

bool finite(const Pose& T) { return T.matrix().allFinite(); }

/// Whether a belief has a mean, and an extent with a logarithm.
bool meaningful(const Belief& b, double sigma_floor) {
  if (!(b.kappa >= kLeastEvidence && std::isfinite(b.kappa) && b.mean.allFinite() && b.cov.allFinite())) {
    return false;
  }
  const Vec3 variances = eigenSymmetric(withFloor(b.cov, sigma_floor)).values;
  return variances[0] > 0 && variances[2] < kWidestVariance;
}

bool within(int index, std::size_t size) { return index >= 0 && static_cast<std::size_t>(index) < size; }

std::vector<WindowObservation> meaningfulObservations(const WindowProblem& problem, double sigma_floor) {
  std::vector<WindowObservation> kept;
  std::copy_if(problem.observations.begin(), problem.observations.end(), std::back_inserter(kept), [&](const auto& o) {
    return within(o.pose, problem.poses.size()) && within(o.object, problem.objects.size()) &&
           meaningful(o.belief_body, sigma_floor);
  });
  return kept;
}

/// Poses and objects where the solver starts: the problem's poses, and all that is known of an object merged there.
void addVariables(const WindowProblem& problem, std::span<const WindowObservation> observations, double sigma_floor,
                  FactorGraph& graph) {
  for (const Pose& T : problem.poses) {
    graph.poses.push_back(poseBlock(T));
  }
  graph.poses.push_back(poseBlock(Pose::Identity()));
  graph.observed.resize(problem.objects.size());
  for (const Belief& prior : problem.objects) {
    graph.gathered.push_back(meaningful(prior, sigma_floor) ? prior : Belief{});
  }
  for (const WindowObservation& o : observations) {
    Belief& belief = graph.gathered[static_cast<std::size_t>(o.object)];
    belief = merge(belief, transform(problem.poses[static_cast<std::size_t>(o.pose)], o.belief_body));
    graph.observed[static_cast<std::size_t>(o.object)] = true;
  }
  graph.objects.resize(problem.objects.size());
  for (std::size_t i = 0; i < graph.objects.size(); ++i) {
    if (graph.observed[i]) {
      graph.objects[i] = objectBlock(graph.gathered[i].mean, spdLog(withFloor(graph.gathered[i].cov, sigma_floor)));
    }
  }
}

void addObjectFactors(const WindowProblem& problem, std::span<const WindowObservation> observations,
                      const WindowConfig& config, FactorGraph& graph) {
  std::vector<double> seen(problem.objects.size()), views(problem.objects.size());
  for (const WindowObservation& o : observations) {
    seen[static_cast<std::size_t>(o.object)] += o.belief_body.kappa;
    views[static_cast<std::size_t>(o.object)] += 1;
    const ObjectObservation view = observationOf(o.belief_body, 1, config.sigma_floor, config.noise);
    graph.factors.push_back({objectFactor(view), o.pose, -1, o.object});
  }
  for (std::size_t i = 0; i < problem.objects.size(); ++i) {
    const Belief& prior = problem.objects[i];
    if (!graph.observed[i] || !meaningful(prior, config.sigma_floor)) {
      continue;
    }
    // How often an object was seen before is not recorded. It is taken to have been seen in views like the window's, as
    // many as make up its evidence.
    const double before = std::clamp(prior.kappa * views[i] / seen[i], 1.0, std::max(1.0, config.noise.most_views));
    const ObjectObservation known = observationOf(prior, before, config.sigma_floor, config.noise);
    graph.factors.push_back({objectFactor(known), graph.poseCount(), -1, static_cast<int>(i)});
  }
}

FactorGraph buildGraph(const WindowProblem& problem, const WindowConfig& config) {
  FactorGraph graph;
  const std::vector<WindowObservation> observations = meaningfulObservations(problem, config.sigma_floor);
  addVariables(problem, observations, config.sigma_floor, graph);
  if (problem.oldest.information.allFinite() && finite(problem.oldest.T_map_body)) {
    graph.factors.push_back({posePriorFactor(problem.oldest)});
  }
  for (const BetweenConstraint& e : problem.constraints) {
    const bool valid = within(e.a, problem.poses.size()) && within(e.b, problem.poses.size()) && e.a != e.b;
    const Mat6 information = informationOf(e);
    if (valid && finite(e.T_a_b) && information.allFinite()) {
      graph.factors.push_back({betweenFactor(e.T_a_b, information), e.a, e.b});
    }
  }
  addObjectFactors(problem, observations, config, graph);
  return graph;
}

void addToProblem(FactorGraph& graph, PoseManifold& manifold, ScalingLoss& loss, ceres::Problem& problem,
                  ceres::ParameterBlockOrdering& elimination) {
  for (std::size_t i = 0; i < graph.objects.size(); ++i) {
    if (graph.observed[i]) {
      problem.AddParameterBlock(graph.objects[i].data(), kObjectSize);
      elimination.AddElementToGroup(graph.objects[i].data(), 0);
    }
  }
  for (PoseBlock& pose : graph.poses) {
    problem.AddParameterBlock(pose.data(), kPoseSize, &manifold);
    elimination.AddElementToGroup(pose.data(), 1);
  }
  problem.SetParameterBlockConstant(graph.poses.back().data());
  for (const Factor& f : graph.factors) {
    if (f.object >= 0) {
      problem.AddResidualBlock(f.cost.get(), &loss, graph.block(f), graph.otherBlock(f));
    } else if (f.other_pose >= 0) {
      problem.AddResidualBlock(f.cost.get(), nullptr, graph.block(f), graph.otherBlock(f));
    } else {
      problem.AddResidualBlock(f.cost.get(), nullptr, graph.block(f));
    }
  }
}

/// Solves in place.
ceres::Solver::Summary minimize(FactorGraph& graph, const WindowConfig& config) {
  PoseManifold manifold;
  ScalingLoss loss(config.robust_scale * config.robust_scale);
  ceres::Problem problem(borrowing());
  ceres::Solver::Options options;
  options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  addToProblem(graph, manifold, loss, problem, *options.linear_solver_ordering);
  options.linear_solver_type = ceres::DENSE_SCHUR;  // the fastest of three for ten poses and a hundred objects
  options.max_num_iterations = config.max_iterations;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  options.initial_trust_region_radius = 1e8;  // starts are good: Gauss-Newton at first
  options.function_tolerance = kCostTolerance;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return summary;
}

/// Normal equations at the solution, in the poses' tangents (6 each) and the objects' blocks (9 each). Object factors
/// beyond the robust scale count with their weight there.
struct NormalEquations {
  Eigen::MatrixXd poses;      // [6P, 6P]
  Eigen::MatrixXd couplings;  // [9N, 6P]
  std::vector<Mat9> objects;  // [N]
};

RowMajor<kPoseSize, 6> plusJacobian(const double* pose_block) {
  RowMajor<kPoseSize, 6> J;
  PoseManifold().PlusJacobian(pose_block, J.data());
  return J;
}

void addPoseFactor(const Factor& f, FactorGraph& graph, NormalEquations& H) {
  const bool pair = f.other_pose >= 0;
  const double* const blocks[2] = {graph.block(f), pair ? graph.otherBlock(f) : nullptr};
  Vec6 r;
  RowMajor<6, kPoseSize> J_a, J_b;
  double* jacobians[2] = {J_a.data(), J_b.data()};
  f.cost->Evaluate(blocks, r.data(), jacobians);
  const Eigen::Index a = 6 * f.pose, b = 6 * f.other_pose;
  const Mat6 by_a = J_a * plusJacobian(blocks[0]);
  H.poses.block<6, 6>(a, a) += by_a.transpose() * by_a;
  if (pair) {
    const Mat6 by_b = J_b * plusJacobian(blocks[1]);
    H.poses.block<6, 6>(b, b) += by_b.transpose() * by_b;
    H.poses.block<6, 6>(a, b) += by_a.transpose() * by_b;
    H.poses.block<6, 6>(b, a) += by_b.transpose() * by_a;
  }
}

void addObjectFactor(const Factor& f, const ScalingLoss& loss, FactorGraph& graph, NormalEquations& H) {
  const double* const blocks[2] = {graph.block(f), graph.otherBlock(f)};
  Vec9 r;
  RowMajor<9, kPoseSize> J;
  RowMajor<9, kObjectSize> by_object;
  double* jacobians[2] = {J.data(), by_object.data()};
  f.cost->Evaluate(blocks, r.data(), jacobians);
  double rho[3];
  loss.Evaluate(r.squaredNorm(), rho);
  const auto object = static_cast<std::size_t>(f.object);
  H.objects[object] += rho[1] * by_object.transpose() * by_object;
  if (f.pose < graph.poseCount()) {  // the map's origin is no variable
    const Eigen::Matrix<double, 9, 6> by_pose = J * plusJacobian(blocks[0]);
    H.poses.block<6, 6>(6 * f.pose, 6 * f.pose) += rho[1] * by_pose.transpose() * by_pose;
    H.couplings.block<9, 6>(9 * f.object, 6 * f.pose) += rho[1] * by_object.transpose() * by_pose;
  }
}

NormalEquations normalEquations(FactorGraph& graph, double robust_scale) {
  const ScalingLoss loss(robust_scale * robust_scale);
  const Eigen::Index size = 6 * graph.poseCount();
  NormalEquations H{Eigen::MatrixXd::Zero(size, size),
                    Eigen::MatrixXd::Zero(9 * static_cast<Eigen::Index>(graph.objects.size()), size),
                    std::vector<Mat9>(graph.objects.size(), Mat9::Zero())};
  for (const Factor& f : graph.factors) {
    if (f.object >= 0) {
      addObjectFactor(f, loss, graph, H);
    } else {
      addPoseFactor(f, graph, H);
    }
  }
  return H;
}

/// The poses' information with the objects marginalised out, [6P, 6P].
Eigen::MatrixXd marginalOfPoses(const FactorGraph& graph, const NormalEquations& H) {
  Eigen::MatrixXd whitened = H.couplings;
  for (std::size_t i = 0; i < H.objects.size(); ++i) {
    if (graph.observed[i]) {
      auto rows = whitened.middleRows<9>(9 * static_cast<Eigen::Index>(i));
      rows = H.objects[i].llt().matrixL().solve(rows).eval();
    }
  }
  Eigen::MatrixXd S = H.poses;
  if (whitened.rows() > 0) {  // Eigen divides by it
    S.selfadjointView<Eigen::Lower>().rankUpdate(whitened.transpose(), -1);
  }
  return S.selfadjointView<Eigen::Lower>();
}

/// The last pose's share of S with the poses before it marginalised out.
Mat6 marginalOfLast(const Eigen::MatrixXd& S) {
  const Eigen::Index before = S.rows() - 6;
  Mat6 information = S.bottomRightCorner<6, 6>();
  if (before > 0) {
    Eigen::MatrixXd rest = S.topLeftCorner(before, before);
    rest.diagonal().array() += kHardlyKnown;
    const Eigen::MatrixXd coupling = S.topRightCorner(before, 6);
    information -= coupling.transpose() * rest.ldlt().solve(coupling);
  }
  return 0.5 * (information + information.transpose());
}

std::vector<Mat3> positionCovariances(const FactorGraph& graph, const NormalEquations& H, Eigen::MatrixXd S) {
  S.diagonal().array() += kHardlyKnown;
  const Eigen::LDLT<Eigen::MatrixXd> poses(S);
  std::vector<Mat3> covs(H.objects.size(), Mat3::Zero());
  for (std::size_t i = 0; i < covs.size(); ++i) {
    if (graph.observed[i]) {
      const Mat9 alone = H.objects[i].llt().solve(Mat9::Identity());
      const Eigen::MatrixXd by_poses = alone.topRows<3>() * H.couplings.middleRows<9>(9 * static_cast<Eigen::Index>(i));
      const Mat3 cov = alone.topLeftCorner<3, 3>() + by_poses * poses.solve(by_poses.transpose());
      covs[i] = 0.5 * (cov + cov.transpose());
    }
  }
  return covs;
}

/// exp L without the floor that its logarithm needed; otherwise extents would grow by it with every window.
Mat3 extentOf(const double* object_block, double sigma_floor) {
  const Eigen3 e = eigenSymmetric(logExtentOf(object_block));
  const Vec3 values = (e.values.array().exp() - sigma_floor * sigma_floor).max(0.0);
  return e.vectors * values.asDiagonal() * e.vectors.transpose();
}

bool sound(const WindowSolution& solution) {
  return std::isfinite(solution.cost_after) && std::all_of(solution.poses.begin(), solution.poses.end(), finite) &&
         std::all_of(solution.objects.begin(), solution.objects.end(),
                     [](const Belief& b) { return b.mean.allFinite() && b.cov.allFinite(); }) &&
         solution.last_pose_information.allFinite() && solution.last_pose_information.llt().info() == Eigen::Success &&
         std::all_of(solution.position_cov.begin(), solution.position_cov.end(),
                     [](const Mat3& cov) { return cov.allFinite(); });
}

}  // namespace

WindowSolution solveWindow(const WindowProblem& problem, const WindowConfig& config) {
  WindowSolution untouched;
  untouched.poses = problem.poses;
  untouched.objects = problem.objects;
  if (problem.poses.empty() || !std::all_of(problem.poses.begin(), problem.poses.end(), finite)) {
    return untouched;
  }
  FactorGraph graph = buildGraph(problem, config);
  const ceres::Solver::Summary summary = minimize(graph, config);
  if (!summary.IsSolutionUsable()) {
    return untouched;
  }
  WindowSolution solution = untouched;
  for (std::size_t m = 0; m < problem.poses.size(); ++m) {
    solution.poses[m] = poseOf(graph.poses[m].data());
  }
  for (std::size_t i = 0; i < problem.objects.size(); ++i) {
    if (graph.observed[i]) {
      const double* const block = graph.objects[i].data();
      solution.objects[i] = {Eigen::Map<const Vec3>(block), extentOf(block, config.sigma_floor),
                             graph.gathered[i].kappa};
    }
  }
  const NormalEquations H = normalEquations(graph, config.robust_scale);
  const Eigen::MatrixXd S = marginalOfPoses(graph, H);
  solution.last_pose_information = marginalOfLast(S);
  if (config.position_covariances) {
    solution.position_cov = positionCovariances(graph, H, S);
  }
  solution.cost_before = summary.initial_cost;
  solution.cost_after = summary.final_cost;
  solution.iterations = static_cast<int>(summary.iterations.size());
  solution.usable = true;
  return sound(solution) ? solution : untouched;
}

}  // namespace hgg
