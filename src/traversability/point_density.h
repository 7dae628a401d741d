#pragma once

#include <span>
#include <unordered_map>
#include <vector>

#include "map/map.h"
#include "traversability/sample.h"

namespace hgg {

/// How densely the surfaces of a place were measured. Tells sheets that were seen from sheets that span what was not:
/// a few points with a wrong label, scattered over a street, end up in one leaf that stands across it. Beams that met
/// everything around would have met that sheet just as often, had it been there.
class PointDensity {
 public:
  void add(const LeafSheet& sheet);
  /// False when the sheet has too few points for its area, by what the surfaces around and under it have.
  bool believes(const LeafSheet& sheet) const;

 private:
  /// Sums over the leaves whose means lie in a square of the map.
  struct Square {
    double kappa = 0, kappa_density = 0;
  };
  std::unordered_map<std::int64_t, Square> squares_;
};

/// The area a foot of a dog-sized robot stands on, m^2: densities are points on it.
inline constexpr double kFootArea = 0.01;

/// Points of the sheet on the area of a foot.
double densityOf(const LeafSheet& sheet);

}  // namespace hgg
