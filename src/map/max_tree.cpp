#include "map/max_tree.h"

#include <algorithm>
#include <bit>

namespace hgg {

void MaxTree::set(std::size_t k, double value) {
  std::size_t count = tree_.size() / 2;
  if (k >= count) {
    std::vector<double> wider(2 * std::bit_ceil(k + 1), 0.0);
    std::copy(tree_.begin() + static_cast<std::ptrdiff_t>(count), tree_.end(),
              wider.begin() + static_cast<std::ptrdiff_t>(wider.size() / 2));
    count = wider.size() / 2;
    for (std::size_t n = count - 1; n > 0; --n) {
      wider[n] = std::max(wider[2 * n], wider[2 * n + 1]);
    }
    tree_ = std::move(wider);
  }
  std::size_t n = count + k;
  tree_[n] = value;
  for (n /= 2; n > 0; n /= 2) {
    const double larger = std::max(tree_[2 * n], tree_[2 * n + 1]);
    if (tree_[n] == larger) {
      return;
    }
    tree_[n] = larger;
  }
}

}  // namespace hgg
