// Independent values for the closed-form formulas of the method (numpy/scipy in double precision; the geodesics at 60
// digits, since double-precision matrix powers lose up to 3e-9 on the flattest pair). tests/data/vectors.json carries
// the numbers.
#include "reference_vectors.h"

#include <gtest/gtest.h>

#include "alignment/assignment.h"
#include "core/belief.h"
#include "core/neighborhood.h"
#include "core/spd.h"

namespace hgg::reference_vectors_test {
namespace {

using Json = nlohmann::json;

Belief belief(const Json& j) { return {vec3(j["mean"]), mat3(j["cov"]), j["kappa"]}; }

std::vector<Vec3> points(const Json& j) {
  std::vector<Vec3> out;
  for (const Json& p : j) {
    out.push_back(vec3(p));
  }
  return out;
}

constexpr double kTolerance = 1e-9;

void expectClose(double actual, double expected) {
  EXPECT_NEAR(actual, expected, kTolerance * std::max(std::abs(expected), 1e-3));
}

/// Relative to the size of the whole vector or matrix.
template <typename A, typename B>
void expectClose(const Eigen::MatrixBase<A>& actual, const Eigen::MatrixBase<B>& expected) {
  EXPECT_LE((actual - expected).norm(), kTolerance * std::max(expected.norm(), 1e-3)) << actual << "\nexpected\n"
                                                                                      << expected;
}

void expectClose(const Belief& actual, const Belief& expected) {
  expectClose(actual.mean, expected.mean);
  expectClose(actual.cov, expected.cov);
  EXPECT_EQ(actual.kappa, expected.kappa);
}

TEST(ReferenceVectors, BeliefFromPoints) {
  for (const Json& c : section("belief_from_points")) {
    expectClose(beliefFromPoints(points(c["points"])), belief(c));
  }
}

TEST(ReferenceVectors, ConjugateMerge) {
  for (const Json& c : section("merge")) {
    expectClose(merge(belief(c["a"]), belief(c["b"])), belief(c["merged"]));
    expectClose(merge(belief(c["b"]), belief(c["a"])), belief(c["merged"]));
  }
}

TEST(ReferenceVectors, EdgeDistanceS1) {
  for (const Json& c : section("edge_distance_S1")) {
    const Mat3 cov_i = mat3(c["cov_i"]), cov_j = mat3(c["cov_j"]);
    const Vec3 mean_i = vec3(c["mean_i"]), mean_j = vec3(c["mean_j"]);
    expectClose(mahalanobis(mean_i - mean_j, 0.5 * (cov_i + cov_j)), c["mahalanobis"].get<double>());
    expectClose(affineInvariantDistance(cov_i, cov_j), c["airm"].get<double>());
    expectClose(edgeDistance({mean_i, cov_i, 1}, {mean_j, cov_j, 1}, 0), c["S1"].get<double>());
  }
}

TEST(ReferenceVectors, Wasserstein2) {
  for (const Json& c : section("wasserstein2")) {
    const Belief a{vec3(c["mean_i"]), mat3(c["cov_i"]), 1}, b{vec3(c["mean_j"]), mat3(c["cov_j"]), 1};
    expectClose(wasserstein2(a, b), c["w2"].get<double>());
    expectClose(wasserstein2(b, a), c["w2"].get<double>());
  }
}

TEST(ReferenceVectors, SpdGeodesic) {
  for (const Json& c : section("spd_geodesic")) {
    expectClose(spdGeodesic(mat3(c["cov_u"]), mat3(c["cov_v"]), c["gamma"]), mat3(c["cov"]));
  }
}

TEST(ReferenceVectors, RelativeNeighborhoodGraph) {
  for (const Json& c : section("relative_neighborhood_graph")) {
    EXPECT_EQ(relativeNeighborhood(points(c["points"])), (c["edges"].get<std::vector<std::pair<int, int>>>()));
  }
}

TEST(ReferenceVectors, Assignment) {
  for (const Json& c : section("assignment")) {
    const auto rows = c["cost"].get<std::vector<std::vector<double>>>();
    Eigen::MatrixXd cost(rows.size(), rows[0].size());
    for (Eigen::Index i = 0; i < cost.rows(); ++i) {
      for (Eigen::Index j = 0; j < cost.cols(); ++j) {
        cost(i, j) = rows[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
      }
    }
    const std::vector<int> column_of = assignDense(cost);
    double total = 0;
    std::vector<int> matched_rows, matched_columns;
    for (Eigen::Index i = 0; i < cost.rows(); ++i) {
      if (column_of[static_cast<std::size_t>(i)] >= 0) {
        total += cost(i, column_of[static_cast<std::size_t>(i)]);
        matched_rows.push_back(static_cast<int>(i));
        matched_columns.push_back(column_of[static_cast<std::size_t>(i)]);
      }
    }
    expectClose(total, c["total"].get<double>());
    EXPECT_EQ(matched_rows, c["rows"].get<std::vector<int>>());
    EXPECT_EQ(matched_columns, c["cols"].get<std::vector<int>>());
  }
}

}  // namespace
}  // namespace hgg::reference_vectors_test
