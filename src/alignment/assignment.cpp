#include "alignment/assignment.h"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>

namespace hgg {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Rows <= columns. Each row in turn is matched along the shortest augmenting path under the potentials u, v.
std::vector<int> assignWide(const Eigen::MatrixXd& cost) {
  const Eigen::Index rows = cost.rows(), columns = cost.cols();
  Eigen::VectorXd u = Eigen::VectorXd::Zero(rows), v = Eigen::VectorXd::Zero(columns + 1);
  std::vector<Eigen::Index> row_of(static_cast<std::size_t>(columns) + 1, -1);  // the last column is the path's root
  std::vector<Eigen::Index> previous(row_of.size());
  for (Eigen::Index r = 0; r < rows; ++r) {
    std::vector<double> slack(row_of.size(), kInfinity);
    std::vector<bool> done(row_of.size(), false);
    Eigen::Index column = columns;
    row_of[static_cast<std::size_t>(column)] = r;
    do {
      done[static_cast<std::size_t>(column)] = true;
      const Eigen::Index i = row_of[static_cast<std::size_t>(column)];
      double delta = kInfinity;
      Eigen::Index next = columns;
      for (Eigen::Index j = 0; j < columns; ++j) {
        const auto c = static_cast<std::size_t>(j);
        if (done[c]) {
          continue;
        }
        const double reduced = cost(i, j) - u[i] - v[j];
        if (reduced < slack[c]) {
          slack[c] = reduced;
          previous[c] = column;
        }
        if (slack[c] < delta) {
          delta = slack[c];
          next = j;
        }
      }
      for (Eigen::Index j = 0; j <= columns; ++j) {
        const auto c = static_cast<std::size_t>(j);
        if (done[c]) {
          u[row_of[c]] += delta;
          v[j] -= delta;
        } else {
          slack[c] -= delta;
        }
      }
      column = next;
    } while (row_of[static_cast<std::size_t>(column)] >= 0);
    while (column != columns) {
      const Eigen::Index from = previous[static_cast<std::size_t>(column)];
      row_of[static_cast<std::size_t>(column)] = row_of[static_cast<std::size_t>(from)];
      column = from;
    }
  }
  std::vector<int> column_of(static_cast<std::size_t>(rows), -1);
  for (Eigen::Index j = 0; j < columns; ++j) {
    if (row_of[static_cast<std::size_t>(j)] >= 0) {
      column_of[static_cast<std::size_t>(row_of[static_cast<std::size_t>(j)])] = static_cast<int>(j);
    }
  }
  return column_of;
}

/// Candidates below the gate grouped into connected blocks, each in input order.
std::vector<std::vector<Candidate>> connectedBlocks(const std::vector<Candidate>& candidates, double unmatched) {
  std::map<int, std::size_t> block_of_row, block_of_column;
  std::vector<std::size_t> parent;
  const auto root = [&](std::size_t b) {
    while (parent[b] != b) {
      b = parent[b] = parent[parent[b]];
    }
    return b;
  };
  const auto blockOf = [&](std::map<int, std::size_t>& blocks, int key) {
    const auto [it, fresh] = blocks.try_emplace(key, parent.size());
    if (fresh) {
      parent.push_back(parent.size());
    }
    return root(it->second);
  };
  std::vector<Candidate> kept;
  for (const Candidate& c : candidates) {
    if (c.cost < unmatched) {
      kept.push_back(c);
      const std::size_t row = blockOf(block_of_row, c.row), column = blockOf(block_of_column, c.column);
      parent[std::max(row, column)] = std::min(row, column);
    }
  }
  std::map<std::size_t, std::vector<Candidate>> blocks;
  for (const Candidate& c : kept) {
    blocks[root(block_of_row[c.row])].push_back(c);
  }
  std::vector<std::vector<Candidate>> out;
  for (auto& [key, block] : blocks) {
    out.push_back(std::move(block));
  }
  return out;
}

std::vector<int> distinct(const std::vector<Candidate>& block, int Candidate::*side) {
  std::vector<int> keys;
  for (const Candidate& c : block) {
    keys.push_back(c.*side);
  }
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  return keys;
}

void solveBlock(const std::vector<Candidate>& block, double unmatched, std::vector<Candidate>& chosen) {
  const std::vector<int> rows = distinct(block, &Candidate::row), columns = distinct(block, &Candidate::column);
  const auto position = [](const std::vector<int>& keys, int key) {
    return std::lower_bound(keys.begin(), keys.end(), key) - keys.begin();
  };
  // A cell without a candidate costs as much as no match at all, so choosing it means staying unmatched.
  Eigen::MatrixXd cost =
      Eigen::MatrixXd::Constant(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(columns.size()), unmatched);
  for (const Candidate& c : block) {
    double& cell = cost(position(rows, c.row), position(columns, c.column));
    cell = std::min(cell, c.cost);
  }
  const std::vector<int> column_of = assignDense(cost);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const int c = column_of[r];
    if (c >= 0 && cost(static_cast<Eigen::Index>(r), c) < unmatched) {
      chosen.push_back({rows[r], columns[static_cast<std::size_t>(c)], cost(static_cast<Eigen::Index>(r), c)});
    }
  }
}

}  // namespace

std::vector<int> assignDense(const Eigen::MatrixXd& cost) {
  if (cost.rows() <= cost.cols()) {
    return assignWide(cost);
  }
  const std::vector<int> row_of = assignWide(cost.transpose());
  std::vector<int> column_of(static_cast<std::size_t>(cost.rows()), -1);
  for (std::size_t c = 0; c < row_of.size(); ++c) {
    column_of[static_cast<std::size_t>(row_of[c])] = static_cast<int>(c);
  }
  return column_of;
}

std::vector<Candidate> assignBlocks(const std::vector<Candidate>& candidates, double unmatched) {
  std::vector<Candidate> chosen;
  for (const std::vector<Candidate>& block : connectedBlocks(candidates, unmatched)) {
    solveBlock(block, unmatched, chosen);
  }
  std::sort(chosen.begin(), chosen.end(), [](const Candidate& a, const Candidate& b) { return a.row < b.row; });
  return chosen;
}

}  // namespace hgg
