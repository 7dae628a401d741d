#pragma once

#include <cstddef>
#include <vector>

namespace hgg {

/// The largest of many numbers (not negative) of which a few change at a time, in the logarithm of how many there are.
class MaxTree {
 public:
  double largest() const { return tree_.empty() ? 0 : tree_[1]; }
  /// Number k is 0 until it is set.
  void set(std::size_t k, double value);

 private:
  std::vector<double> tree_;  // entry 1 is the root, the children of n are 2n and 2n + 1, the second half the numbers
};

}  // namespace hgg
