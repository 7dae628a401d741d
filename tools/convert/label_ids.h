#pragma once

#include <span>
#include <string>
#include <vector>

#include "convert/semantickitti.h"

namespace hgg {

/// Whether the labels of a sequence are SemanticKITTI's training ids (0..19 of `learning_map`) and not its raw ids:
/// none is above 19, and some are such as no raw id is. Looks at up to 50 frames, spread evenly. False where a file
/// cannot be read: reading it properly tells.
bool hasLearningIds(std::span<const KittiFrame> frames);

/// The raw id of a training id (SemanticKITTI's `learning_map_inv`); others stay.
ClassId rawOfLearningId(ClassId learning_id);

}  // namespace hgg
