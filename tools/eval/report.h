#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "eval/evaluate.h"

namespace hgg {

/// The name of a class of the map, "class N" where it has none.
std::string className(const Evaluation& evaluation, ClassId label);
/// The tables for people. What was not scored says "not yet" and what it takes.
std::string formatTable(const Evaluation& evaluation);
/// The same for programs; ratios without a meaning (0 / 0) and what was not scored are null.
nlohmann::json toJson(const Evaluation& evaluation);

}  // namespace hgg
