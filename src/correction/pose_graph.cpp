#include "correction/pose_graph.h"

#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <memory>
#include <numeric>

#include "correction/factors.h"

namespace hgg {
namespace {

/// Square of a loop's whitened error up to which it counts in full: 99 % of true loops lie below (chi-square, 6 degrees
/// of freedom).
constexpr double kTrueLoop = 16.8;
/// Before drift is corrected, true loops are far off too. So the scale starts at this many times the median of the
/// loops' squared errors, where most of them count in full, and is divided by kNarrowing at every stage.
constexpr double kFirstScale = 2, kNarrowing = 16;
constexpr int kMaxStages = 8, kStageIterations = 5, kLastIterations = 15;

struct PoseGraph {
  std::vector<PoseBlock> poses;
  std::vector<std::unique_ptr<ceres::CostFunction>> costs;  // one per constraint
  std::span<const BetweenConstraint> constraints;
};

double* poseOfId(PoseGraph& graph, KeyframeId id) { return graph.poses[static_cast<std::size_t>(id)].data(); }

/// Square of a constraint's whitened error.
double squaredError(PoseGraph& graph, std::size_t k) {
  const BetweenConstraint& e = graph.constraints[k];
  const double* const blocks[2] = {poseOfId(graph, e.a), poseOfId(graph, e.b)};
  Vec6 r;
  graph.costs[k]->Evaluate(blocks, r.data(), nullptr);
  return r.squaredNorm();
}

std::vector<double> squaredLoopErrors(PoseGraph& graph) {
  std::vector<double> errors;
  for (std::size_t k = 0; k < graph.constraints.size(); ++k) {
    if (graph.constraints[k].is_loop) {
      errors.push_back(squaredError(graph, k));
    }
  }
  return errors;
}

double median(std::vector<double> values) {
  if (values.empty()) {
    return 0;
  }
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Half the sum of the squared errors, those of loops as the loss counts them.
double costOf(PoseGraph& graph, const ScalingLoss& loss) {
  double cost = 0;
  for (std::size_t k = 0; k < graph.constraints.size(); ++k) {
    double rho[3] = {squaredError(graph, k), 1, 0};
    if (graph.constraints[k].is_loop) {
      loss.Evaluate(rho[0], rho);
    }
    cost += 0.5 * rho[0];
  }
  return cost;
}

/// Which poses the constraints connect to the first.
std::vector<bool> connectedToFirst(std::size_t pose_count, std::span<const BetweenConstraint> constraints) {
  std::vector<std::size_t> root(pose_count);
  std::iota(root.begin(), root.end(), std::size_t{0});
  const auto find = [&root](std::size_t i) {
    while (root[i] != i) {
      i = root[i] = root[root[i]];
    }
    return i;
  };
  for (const BetweenConstraint& e : constraints) {
    // The lower index leads, so the first pose leads its own component.
    const auto [low, high] = std::minmax({find(static_cast<std::size_t>(e.a)), find(static_cast<std::size_t>(e.b))});
    root[high] = low;
  }
  std::vector<bool> connected(pose_count);
  for (std::size_t i = 0; i < pose_count; ++i) {
    connected[i] = find(i) == 0;
  }
  return connected;
}

void addConstraints(PoseGraph& graph, PoseManifold& manifold, ScalingLoss& loss, ceres::Problem& problem) {
  const std::vector<bool> connected = connectedToFirst(graph.poses.size(), graph.constraints);
  for (std::size_t i = 0; i < graph.poses.size(); ++i) {
    if (connected[i]) {
      problem.AddParameterBlock(graph.poses[i].data(), kPoseSize, &manifold);
    }
  }
  problem.SetParameterBlockConstant(graph.poses[0].data());
  for (std::size_t k = 0; k < graph.constraints.size(); ++k) {
    const BetweenConstraint& e = graph.constraints[k];
    if (connected[static_cast<std::size_t>(e.a)]) {
      problem.AddResidualBlock(graph.costs[k].get(), e.is_loop ? &loss : nullptr, poseOfId(graph, e.a),
                               poseOfId(graph, e.b));
    }
  }
}

struct Progress {
  int iterations = 0;
  bool converged = false;
};

/// Solves in place, narrowing the loss down to kTrueLoop.
Progress minimize(PoseGraph& graph, ScalingLoss& loss) {
  PoseManifold manifold;
  ceres::Problem problem(borrowing());
  addConstraints(graph, manifold, loss, problem);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  options.initial_trust_region_radius = 1e8;
  Progress progress;
  double scale = kFirstScale * kNarrowing * median(squaredLoopErrors(graph));
  for (int stage = 0; stage <= kMaxStages; ++stage) {
    scale /= kNarrowing;
    const bool last = scale <= kTrueLoop || stage == kMaxStages;
    loss.setScale(last ? kTrueLoop : scale);
    options.max_num_iterations = last ? kLastIterations : kStageIterations;
    options.function_tolerance = last ? 1e-8 : 1e-3;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    progress.iterations += static_cast<int>(summary.iterations.size());
    progress.converged = last && summary.termination_type == ceres::CONVERGENCE;
    if (last || !summary.IsSolutionUsable()) {
      break;
    }
  }
  return progress;
}

}  // namespace

PoseGraphSolution solvePoseGraph(const std::vector<Pose>& poses, std::span<const BetweenConstraint> constraints) {
  PoseGraphSolution solution;
  solution.poses = poses;
  PoseGraph graph{{}, {}, constraints};
  std::transform(poses.begin(), poses.end(), std::back_inserter(graph.poses), poseBlock);
  for (const BetweenConstraint& e : constraints) {
    graph.costs.push_back(betweenFactor(e.T_a_b, informationOf(e)));
  }
  const std::vector<PoseBlock> start = graph.poses;
  ScalingLoss loss(kTrueLoop);
  solution.cost_before = solution.cost_after = costOf(graph, loss);
  const Progress progress = constraints.empty() ? Progress{0, true} : minimize(graph, loss);
  solution.iterations = progress.iterations;
  loss.setScale(kTrueLoop);
  const double cost = costOf(graph, loss);
  if (cost <= solution.cost_before) {
    solution.cost_after = cost;
    solution.converged = progress.converged;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      if (graph.poses[i] != start[i]) {
        solution.poses[i] = poseOf(graph.poses[i].data());
      }
    }
  } else {
    graph.poses = start;
  }
  for (const double error : squaredLoopErrors(graph)) {
    double rho[3];
    loss.Evaluate(error, rho);
    solution.loop_weights.push_back(rho[1]);
  }
  return solution;
}

}  // namespace hgg
