#pragma once

#include <Eigen/Core>
#include <vector>

namespace hgg {

/// Minimum-cost assignment of a rectangular cost matrix (Hungarian method by shortest augmenting paths, O(n^2 m)).
/// Returns the column of each row, -1 for rows without one (more rows than columns). Costs must be finite.
std::vector<int> assignDense(const Eigen::MatrixXd& cost);

struct Candidate {
  int row = 0, column = 0;
  double cost = 0;
};

/// The one-to-one choice of candidates that minimises the summed cost where an unmatched row costs `unmatched`. Costs
/// are not negative; candidates costing `unmatched` or more are never chosen. Works block by block of the sparse
/// candidate graph: time grows with the candidates, not with rows times columns. Returned by row.
std::vector<Candidate> assignSparse(const std::vector<Candidate>& candidates, double unmatched);

}  // namespace hgg
