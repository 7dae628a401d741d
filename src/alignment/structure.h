#pragma once

#include <utility>
#include <vector>

#include "core/belief.h"
#include "core/types.h"
#include "map/local_graph.h"

namespace hgg {

/// Sparse histogram of the classes of a node's graph neighbours (eq. st_hist), ascending by class.
using NeighborHistogram = std::vector<std::pair<ClassId, int>>;

/// One histogram per node of a graph.
std::vector<NeighborHistogram> neighborHistograms(const std::vector<ClassId>& labels,
                                                  const std::vector<std::pair<int, int>>& edges);

/// The histogram of a node with neighbours of these classes.
NeighborHistogram histogramOf(const std::vector<ClassId>& labels);

/// L2 norm of the difference (E_st).
double histogramDistance(const NeighborHistogram& a, const NeighborHistogram& b);

/// Real-valued Weisfeiler-Lehman features of a geometry graph, a row a leaf: log eigenvalues of its covariance
/// (floored, ascending) and its degree, then `rounds` times what is there beside the mean of it over the neighbours
/// (zero without any). 4 * 2^rounds columns; the same however the graph is turned, moved or numbered.
Eigen::MatrixXd wlFeatures(const std::vector<Belief>& leaves, const std::vector<std::pair<int, int>>& edges, int rounds,
                           double sigma_floor);

}  // namespace hgg
