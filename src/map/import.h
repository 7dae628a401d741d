#pragma once

#include <string>

#include "core/result.h"
#include "map/map.h"

namespace hgg {

/// A map out of graph JSON from elsewhere (docs/file-format.md, "Import"): objects given by mean and covariance, with
/// their geometry, or by a box. Ids are kept. An error names the object and what is wrong with it.
Result<Map> importJson(const std::string& text);

}  // namespace hgg
