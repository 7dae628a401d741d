#include "alignment/assignment.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <queue>

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

/// A column that a path has come to, and the length of the path.
struct PathEnd {
  double distance;
  int column;
  bool operator>(const PathEnd& o) const { return distance != o.distance ? distance > o.distance : column > o.column; }
};

/// Shortest augmenting paths over adjacency lists. Besides its candidates every row has a slot of its own that costs
/// `unmatched`, so a path ends at a free column or where a row on it gives up its column. Paths stay inside the
/// connected block of candidates they start in.
class SparseAssignment {
 public:
  SparseAssignment(std::vector<std::vector<Candidate>> candidates_of_row, std::size_t columns, double unmatched)
      : candidates_(std::move(candidates_of_row)),
        unmatched_(unmatched),
        u_(candidates_.size(), 0),
        v_(columns, 0),
        row_of_(columns, -1),
        distance_(columns, kInfinity),
        from_(columns, -1),
        done_(columns, false) {
    for (std::size_t r = 0; r < candidates_.size(); ++r) {
      augment(static_cast<int>(r));
    }
  }
  const std::vector<int>& rowOf() const { return row_of_; }

 private:
  /// Offers the columns of a row at distance `base` from the start of the path.
  void relax(int row, double base) {
    const auto r = static_cast<std::size_t>(row);
    for (const Candidate& c : candidates_[r]) {
      const auto column = static_cast<std::size_t>(c.column);
      const double distance = base + c.cost - u_[r] - v_[column];
      if (!done_[column] && distance < distance_[column]) {
        if (distance_[column] == kInfinity) {
          touched_.push_back(column);
        }
        distance_[column] = distance;
        from_[column] = row;
        heap_.push({distance, c.column});
      }
    }
    if (const double slot = base + unmatched_ - u_[r]; slot < slot_distance_) {
      slot_distance_ = slot;
      slot_row_ = row;
    }
  }

  /// Next nearest column that is not done; -1 when a slot is nearer.
  int nextColumn() {
    while (!heap_.empty()) {
      const PathEnd end = heap_.top();
      if (end.distance >= slot_distance_) {
        return -1;
      }
      heap_.pop();
      if (!done_[static_cast<std::size_t>(end.column)]) {
        return end.column;
      }
    }
    return -1;
  }

  void augment(int row) {
    heap_ = {};
    slot_distance_ = kInfinity;
    relax(row, 0);
    int end = nextColumn();
    while (end >= 0 && row_of_[static_cast<std::size_t>(end)] >= 0) {
      const auto column = static_cast<std::size_t>(end);
      done_[column] = true;
      relax(row_of_[column], distance_[column]);
      end = nextColumn();
    }
    const double length = end >= 0 ? distance_[static_cast<std::size_t>(end)] : slot_distance_;
    u_[static_cast<std::size_t>(row)] += length;
    for (const std::size_t column : touched_) {
      if (done_[column]) {
        u_[static_cast<std::size_t>(row_of_[column])] += length - distance_[column];
        v_[column] += distance_[column] - length;
      }
    }
    shift(row, end >= 0 ? end : columnOf(slot_row_));
    for (const std::size_t column : touched_) {
      distance_[column] = kInfinity;
      done_[column] = false;
    }
    touched_.clear();
  }

  /// The matched column of a row on the current path; -1 for the path's first row.
  int columnOf(int row) const {
    const auto it =
        std::find_if(touched_.begin(), touched_.end(), [&](std::size_t c) { return done_[c] && row_of_[c] == row; });
    return it == touched_.end() ? -1 : static_cast<int>(*it);
  }

  /// Hands the columns along the path that ends in `column` to their predecessors, back to the row that started it.
  void shift(int start, int column) {
    while (column >= 0) {
      const auto c = static_cast<std::size_t>(column);
      const int row = from_[c];
      const int given_up = row == start ? -1 : columnOf(row);
      row_of_[c] = row;
      column = given_up;
    }
  }

  std::vector<std::vector<Candidate>> candidates_;
  double unmatched_;
  std::vector<double> u_, v_;  // potentials of rows and columns
  std::vector<int> row_of_;
  std::vector<double> distance_;
  std::vector<int> from_;
  std::vector<bool> done_;
  std::vector<std::size_t> touched_;
  std::priority_queue<PathEnd, std::vector<PathEnd>, std::greater<>> heap_;
  double slot_distance_ = kInfinity;
  int slot_row_ = -1;
};

/// Ascending distinct values of one side of the candidates.
std::vector<int> distinct(const std::vector<Candidate>& candidates, int Candidate::*side) {
  std::vector<int> keys;
  keys.reserve(candidates.size());
  for (const Candidate& c : candidates) {
    keys.push_back(c.*side);
  }
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  return keys;
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

std::vector<Candidate> assignSparse(const std::vector<Candidate>& candidates, double unmatched) {
  const std::vector<int> rows = distinct(candidates, &Candidate::row),
                         columns = distinct(candidates, &Candidate::column);
  const auto position = [](const std::vector<int>& keys, int key) {
    return static_cast<int>(std::lower_bound(keys.begin(), keys.end(), key) - keys.begin());
  };
  std::vector<std::vector<Candidate>> candidates_of_row(rows.size());
  for (const Candidate& c : candidates) {
    if (c.cost < unmatched) {
      const int row = position(rows, c.row);
      candidates_of_row[static_cast<std::size_t>(row)].push_back({row, position(columns, c.column), c.cost});
    }
  }
  const SparseAssignment assignment(candidates_of_row, columns.size(), unmatched);
  std::vector<Candidate> chosen;
  for (std::size_t column = 0; column < columns.size(); ++column) {
    const int row = assignment.rowOf()[column];
    if (row >= 0) {
      double cost = unmatched;
      for (const Candidate& c : candidates_of_row[static_cast<std::size_t>(row)]) {
        cost = c.column == static_cast<int>(column) ? std::min(cost, c.cost) : cost;
      }
      chosen.push_back({rows[static_cast<std::size_t>(row)], columns[column], cost});
    }
  }
  std::sort(chosen.begin(), chosen.end(), [](const Candidate& a, const Candidate& b) { return a.row < b.row; });
  return chosen;
}

}  // namespace hgg
