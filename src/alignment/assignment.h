#pragma once

#include <Eigen/Core>
#include <vector>

namespace hgg {

/// Minimum-cost assignment of a rectangular cost matrix (Hungarian method by shortest augmenting paths, O(n^2 m)). Returns the
/// column of each row, -1 for rows without one (more rows than columns). Costs must be finite.
std::vector<int> assignDense(const Eigen::MatrixXd& cost);

struct Candidate {
  int row = 0, column = 0;
  double cost = 0;
};

/// The one-to-one choice of candidates that minimises the summed cost where an unmatched row costs `unmatched`. Solves each
/// connected block of the sparse candidate graph on its own; candidates costing `unmatched` or more are never chosen.
/// Returned by row.
std::vector<Candidate> assignBlocks(const std::vector<Candidate>& candidates, double unmatched);

}  // namespace hgg
