#pragma once

#include <span>
#include <vector>

#include "traversability/columns.h"

namespace hgg {

/// Which of the sheets say nothing that others do not say better (isObsoleteInAll): a flag
/// for each. `cell`: edge of the columns, m.
std::vector<bool> obsoleteSheets(std::span<const PlacedSheet> sheets, double cell);

}  // namespace hgg
