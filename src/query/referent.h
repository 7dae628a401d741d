#pragma once

#include <vector>

namespace hgg {

/// A thing that a phrase may mean.
struct Referent {
  int thing = 0;           // index in the scene
  double probability = 0;  // of those of its phrase
};

using Referents = std::vector<Referent>;

}  // namespace hgg
