#pragma once

#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "creation/cluster.h"

namespace hgg {

/// The oracle: components of areNeighbours by testing all pairs, numbered by first appearance.
inline std::vector<std::int32_t> clusterByBruteForce(std::span<const PackedPoint> points, const RadiusLaw& law) {
  std::vector<std::int32_t> component(points.size(), -1);
  std::int32_t next = 0;
  for (std::size_t seed = 0; seed < points.size(); ++seed) {
    if (component[seed] >= 0) {
      continue;
    }
    std::vector<std::size_t> frontier{seed};
    component[seed] = next;
    while (!frontier.empty()) {
      const std::size_t i = frontier.back();
      frontier.pop_back();
      for (std::size_t j = 0; j < points.size(); ++j) {
        if (component[j] < 0 && areNeighbours(points[i], points[j], law)) {
          component[j] = next;
          frontier.push_back(j);
        }
      }
    }
    ++next;
  }
  return component;
}

}  // namespace hgg
