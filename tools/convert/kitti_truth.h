#pragma once

#include "convert/semantickitti.h"
#include "truth/objects.h"

namespace hgg {

/// True objects of a sequence whose labels carry instance ids: per class and instance the mean and covariance of its
/// points over all frames, placed with the frames' poses. Labels are folded as SemanticKITTI does (moving-car -> car);
/// the object's id is label * 100000 + instance. An object is dynamic when its label says moving, or when
/// - with `boxes` (csv with columns track_id = instance, cx_world, cy_world): its box centre moves by more than 1 m;
/// - without: its points of all frames spread more than 1 m further than those of its best-seen frame. Means of single
///   frames would not do: that of a parked car wanders by over a metre as the viewpoint changes.
Result<std::vector<TruthObject>> kittiTruth(const std::vector<KittiFrame>& frames,
                                            const std::optional<std::filesystem::path>& boxes,
                                            const Progress& progress);

}  // namespace hgg
