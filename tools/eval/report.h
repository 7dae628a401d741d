#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "eval/evaluate.h"

namespace hgg {

/// The tables for people.
std::string formatTable(const Evaluation& evaluation);
/// The same for programs; ratios without a meaning (0 / 0) are null.
nlohmann::json toJson(const Evaluation& evaluation);

}  // namespace hgg
