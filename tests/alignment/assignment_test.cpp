#include "alignment/assignment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

#include "random_geometry.h"

namespace hgg::assignment_test {
namespace {

constexpr double kUnmatched = 3;

/// Cheapest total over every way to match rows from `row` on, an unmatched row costing kUnmatched.
double exhaustive(const std::vector<std::map<int, double>>& cost, std::size_t row, std::set<int>& taken) {
  if (row == cost.size()) {
    return 0;
  }
  double best = kUnmatched + exhaustive(cost, row + 1, taken);
  for (const auto& [column, c] : cost[row]) {
    if (taken.insert(column).second) {
      best = std::min(best, c + exhaustive(cost, row + 1, taken));
      taken.erase(column);
    }
  }
  return best;
}

double exhaustive(const std::vector<Candidate>& candidates, int rows) {
  std::vector<std::map<int, double>> cost(static_cast<std::size_t>(rows));
  for (const Candidate& c : candidates) {
    const auto [it, fresh] = cost[static_cast<std::size_t>(c.row)].try_emplace(c.column, c.cost);
    it->second = std::min(it->second, c.cost);
  }
  std::set<int> taken;
  return exhaustive(cost, 0, taken);
}

double totalOf(const std::vector<Candidate>& chosen, int rows) {
  double total = kUnmatched * (rows - static_cast<int>(chosen.size()));
  for (const Candidate& c : chosen) {
    total += c.cost;
  }
  return total;
}

/// One-to-one, by row, below the gate, and made of candidates that exist.
void expectValid(const std::vector<Candidate>& chosen, const std::vector<Candidate>& candidates) {
  std::set<int> rows, columns;
  for (const Candidate& c : chosen) {
    EXPECT_TRUE(rows.insert(c.row).second) << "row " << c.row << " twice";
    EXPECT_TRUE(columns.insert(c.column).second) << "column " << c.column << " twice";
    EXPECT_LT(c.cost, kUnmatched);
    EXPECT_TRUE(std::any_of(candidates.begin(), candidates.end(), [&](const Candidate& k) {
      return k.row == c.row && k.column == c.column && k.cost == c.cost;
    })) << "invented pair";
  }
  EXPECT_TRUE(std::is_sorted(chosen.begin(), chosen.end(),
                             [](const Candidate& a, const Candidate& b) { return a.row < b.row; }));
}

std::vector<Candidate> randomCandidates(std::mt19937& random, int rows, int columns, double density) {
  std::vector<Candidate> candidates;
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      if (uniform(random, 0, 1) < density) {
        candidates.push_back({r, c, uniform(random, 0, 1.5 * kUnmatched)});
      }
    }
  }
  std::shuffle(candidates.begin(), candidates.end(), random);
  return candidates;
}

TEST(AssignSparse, CostsWhatExhaustiveSearchCostsOnSparseProblemsOfAnyShape) {
  std::mt19937 random(1);
  for (const auto& [rows, columns] : {std::pair{1, 1}, {4, 4}, {6, 3}, {7, 2}, {3, 7}, {5, 6}, {1, 6}, {6, 1}}) {
    for (const double density : {0.2, 0.4, 0.7, 1.0}) {
      for (int k = 0; k < 60; ++k) {
        const std::vector<Candidate> candidates = randomCandidates(random, rows, columns, density);
        const std::vector<Candidate> chosen = assignSparse(candidates, kUnmatched);
        expectValid(chosen, candidates);
        EXPECT_NEAR(totalOf(chosen, rows), exhaustive(candidates, rows), 1e-9)
            << rows << "x" << columns << " at " << density;
      }
    }
  }
}

TEST(AssignSparse, CostsWhatExhaustiveSearchCostsWhereCostsTie) {
  std::mt19937 random(2);
  for (int k = 0; k < 500; ++k) {
    std::vector<Candidate> candidates = randomCandidates(random, 6, 5, 0.5);
    for (Candidate& c : candidates) {
      c.cost = std::floor(c.cost);
    }
    const std::vector<Candidate> chosen = assignSparse(candidates, kUnmatched);
    expectValid(chosen, candidates);
    EXPECT_EQ(totalOf(chosen, 6), exhaustive(candidates, 6));
  }
}

TEST(AssignSparse, PreferTheSumOverTheNearest) {
  // Greedy would take (0, 1) at 0.1 and pay 1.9 for the other.
  const std::vector<Candidate> chosen = assignSparse({{0, 0, 0.9}, {0, 1, 0.1}, {1, 0, 1.9}, {1, 1, 0.9}}, kUnmatched);
  ASSERT_EQ(chosen.size(), 2U);
  EXPECT_EQ(chosen[0].column, 0);
  EXPECT_EQ(chosen[1].column, 1);
}

TEST(AssignSparse, APairAtOrAboveTheGateStaysUnmatched) {
  EXPECT_TRUE(assignSparse({{0, 0, kUnmatched}, {1, 1, 9}}, kUnmatched).empty());
  EXPECT_EQ(assignSparse({{0, 0, kUnmatched - 1e-9}}, kUnmatched).size(), 1U);
  EXPECT_TRUE(assignSparse({{0, 0, std::nan("")}}, kUnmatched).empty());
  EXPECT_TRUE(assignSparse({}, kUnmatched).empty());
}

TEST(AssignSparse, TwoRowsMatchEvenWhenOneOfThemCouldHaveHadTheBetterColumn) {
  // Row 1 only reaches column 0; giving it up for row 0's sake would cost an unmatched row.
  const std::vector<Candidate> chosen = assignSparse({{0, 0, 0.1}, {0, 1, 1.5}, {1, 0, 1.0}}, kUnmatched);
  ASSERT_EQ(chosen.size(), 2U);
  EXPECT_EQ(chosen[0].column, 1);
  EXPECT_EQ(chosen[1].column, 0);
}

TEST(AssignSparse, TakeTheCheapestOfRepeatedCandidatesAndIndicesFarApart) {
  const std::vector<Candidate> chosen =
      assignSparse({{1000000, 7, 2}, {1000000, 7, 1}, {-3, 2000000000, 0.5}}, kUnmatched);
  ASSERT_EQ(chosen.size(), 2U);
  EXPECT_EQ(chosen[0].row, -3);
  EXPECT_EQ(chosen[1].cost, 1);
}

TEST(AssignSparse, DoNotDependOnTheOrderOfCandidates) {
  std::mt19937 random(3);
  std::vector<Candidate> candidates = randomCandidates(random, 40, 40, 0.1);
  const std::vector<Candidate> first = assignSparse(candidates, kUnmatched);
  for (int k = 0; k < 20; ++k) {
    std::shuffle(candidates.begin(), candidates.end(), random);
    const std::vector<Candidate> again = assignSparse(candidates, kUnmatched);
    ASSERT_EQ(again.size(), first.size());
    for (std::size_t i = 0; i < first.size(); ++i) {
      EXPECT_EQ(again[i].row, first[i].row);
      EXPECT_EQ(again[i].column, first[i].column);
    }
  }
}

TEST(AssignSparse, CostWhatOneDenseProblemCosts) {
  std::mt19937 random(4);
  for (const auto& [rows, columns] : {std::pair{120, 90}, {60, 150}}) {
    const std::vector<Candidate> candidates = randomCandidates(random, rows, columns, 0.03);
    // Every row gets a dummy column of its own that stands for staying unmatched.
    Eigen::MatrixXd dense = Eigen::MatrixXd::Constant(rows, columns + rows, kUnmatched);
    for (const Candidate& c : candidates) {
      dense(c.row, c.column) = std::min(c.cost, kUnmatched);
    }
    const std::vector<int> column_of = assignDense(dense);
    double total = 0;
    for (int r = 0; r < rows; ++r) {
      total += dense(r, column_of[static_cast<std::size_t>(r)]);
    }
    EXPECT_NEAR(totalOf(assignSparse(candidates, kUnmatched), rows), total, 1e-9);
  }
}

double cheapestByPermutation(const Eigen::MatrixXd& cost) {
  const Eigen::MatrixXd wide = cost.rows() <= cost.cols() ? cost : Eigen::MatrixXd(cost.transpose());
  std::vector<Eigen::Index> columns(static_cast<std::size_t>(wide.cols()));
  std::iota(columns.begin(), columns.end(), 0);
  double best = std::numeric_limits<double>::infinity();
  do {
    double total = 0;
    for (Eigen::Index r = 0; r < wide.rows(); ++r) {
      total += wide(r, columns[static_cast<std::size_t>(r)]);
    }
    best = std::min(best, total);
  } while (std::next_permutation(columns.begin(), columns.end()));
  return best;
}

TEST(AssignDense, CostsWhatTryingEveryPermutationCosts) {
  std::mt19937 random(5);
  for (const auto& [rows, columns] : {std::pair{1, 1}, {2, 5}, {5, 2}, {6, 6}, {4, 6}, {6, 4}}) {
    for (int k = 0; k < 30; ++k) {
      const Eigen::MatrixXd cost = Eigen::MatrixXd::NullaryExpr(
          rows, columns, [&](Eigen::Index, Eigen::Index) { return uniform(random, -5, 5); });
      const std::vector<int> column_of = assignDense(cost);
      ASSERT_EQ(column_of.size(), static_cast<std::size_t>(rows));
      double total = 0;
      std::set<int> taken;
      for (int r = 0; r < rows; ++r) {
        if (const int c = column_of[static_cast<std::size_t>(r)]; c >= 0) {
          EXPECT_TRUE(taken.insert(c).second);
          total += cost(r, c);
        }
      }
      EXPECT_EQ(taken.size(), static_cast<std::size_t>(std::min(rows, columns)));
      EXPECT_NEAR(total, cheapestByPermutation(cost), 1e-9);
    }
  }
}

TEST(AssignDense, TakesEmptyMatrices) {
  EXPECT_TRUE(assignDense(Eigen::MatrixXd(0, 0)).empty());
  EXPECT_TRUE(assignDense(Eigen::MatrixXd(0, 3)).empty());
  EXPECT_EQ(assignDense(Eigen::MatrixXd(2, 0)), (std::vector<int>{-1, -1}));
}

}  // namespace
}  // namespace hgg::assignment_test
