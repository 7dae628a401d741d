#include "alignment/structure.h"

#include <algorithm>
#include <cmath>

#include "core/spd.h"

namespace hgg {
namespace {

void count(NeighborHistogram& histogram, ClassId label) {
  const auto it = std::lower_bound(histogram.begin(), histogram.end(), label,
                                   [](const auto& bin, ClassId l) { return bin.first < l; });
  if (it != histogram.end() && it->first == label) {
    ++it->second;
  } else {
    histogram.insert(it, {label, 1});
  }
}

}  // namespace

std::vector<NeighborHistogram> neighborHistograms(const std::vector<ClassId>& labels,
                                                  const std::vector<std::pair<int, int>>& edges) {
  std::vector<NeighborHistogram> histograms(labels.size());
  for (const auto& [a, b] : edges) {
    count(histograms[static_cast<std::size_t>(a)], labels[static_cast<std::size_t>(b)]);
    count(histograms[static_cast<std::size_t>(b)], labels[static_cast<std::size_t>(a)]);
  }
  return histograms;
}

NeighborHistogram histogramOf(const std::vector<ClassId>& labels) {
  NeighborHistogram histogram;
  for (const ClassId label : labels) {
    count(histogram, label);
  }
  return histogram;
}

double histogramDistance(const NeighborHistogram& a, const NeighborHistogram& b) {
  double square = 0;
  auto i = a.begin();
  auto j = b.begin();
  while (i != a.end() || j != b.end()) {
    const bool take_a = j == b.end() || (i != a.end() && i->first <= j->first);
    const bool take_b = i == a.end() || (j != b.end() && j->first <= i->first);
    const double difference = (take_a ? i->second : 0) - (take_b ? j->second : 0);
    square += difference * difference;
    i += take_a ? 1 : 0;
    j += take_b ? 1 : 0;
  }
  return std::sqrt(square);
}

Eigen::MatrixXd wlFeatures(const std::vector<Belief>& leaves, const std::vector<std::pair<int, int>>& edges, int rounds,
                           double sigma_floor) {
  const auto n = static_cast<Eigen::Index>(leaves.size());
  Eigen::VectorXd degree = Eigen::VectorXd::Zero(n);
  for (const auto& [a, b] : edges) {
    degree[a] += 1, degree[b] += 1;
  }
  Eigen::MatrixXd features(n, 4);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Mat3 cov = withFloor(leaves[static_cast<std::size_t>(i)].cov, sigma_floor);
    features.row(i) << eigenSymmetric(cov).values.array().log().matrix().transpose(), degree[i];
  }
  for (int round = 0; round < rounds; ++round) {
    Eigen::MatrixXd around = Eigen::MatrixXd::Zero(n, features.cols());
    for (const auto& [a, b] : edges) {
      around.row(a) += features.row(b), around.row(b) += features.row(a);
    }
    around.array().colwise() /= degree.array().max(1);
    features = (Eigen::MatrixXd(n, 2 * features.cols()) << features, around).finished();
  }
  return features;
}

}  // namespace hgg
