#include "alignment/align.h"

namespace hgg {

Alignment align(const LocalGraph& local, const Map& map, const Pose& T_map_body_predicted, const Config& config) {
  return {T_map_body_predicted, coarseCorrespondence(local, map, T_map_body_predicted, config), "odometry"};
}

}  // namespace hgg
