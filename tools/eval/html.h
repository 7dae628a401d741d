#pragma once

#include <string>

#include "eval/evaluate.h"

namespace hgg {

/// The evaluation as one self-contained page (styles, scripts and data inside, nothing from the network): the map from
/// above, bars, curves. Bounded in size: long paths are thinned, walls are drawn on a grid.
std::string htmlReport(const Evaluation& evaluation, const std::string& title);

}  // namespace hgg
