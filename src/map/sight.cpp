#include "map/sight.h"

#include <algorithm>
#include <cmath>

#include "core/position_uncertainty.h"
#include "core/spd.h"
#include "core/units.h"

namespace hgg {

PlaceSight lookAt(const std::vector<Belief>& leaves, const FreeSpace& look, double variance, double variance_turn,
                  double sigma_floor) {
  PlaceSight sight;
  const double share = 1 / static_cast<double>(std::max<std::size_t>(leaves.size(), 1));
  const Pose T_sensor_map = look.T_map_sensor.inverse();
  const Mat3 R = T_sensor_map.linear();
  for (const Belief& leaf : leaves) {
    const Vec3 p = T_sensor_map * leaf.mean;
    const double sigma = std::sqrt(square(kPositionOfView.view_noise) + variance + look.variance +
                                   (variance_turn + look.variance_turn) * p.squaredNorm());
    const BeamCount beams = look.image.beamsAt(p, R * withFloor(leaf.cov, sigma_floor) * R.transpose(), sigma);
    sight.taken += takenBy(beams) * share;
    sight.through += seenThroughBy(beams) * share;
  }
  return sight;
}

}  // namespace hgg
