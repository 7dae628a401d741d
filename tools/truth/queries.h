#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/result.h"

namespace hgg {

/// A phrase that names exactly one object of the world.
struct TruthQuery {
  std::string text;
  std::int64_t target = 0;  // id in gt_objects.json
  std::string class_name;   // of the target
};

/// queries.jsonl: a line {"text","target","class"} each. Returns an error line, empty when done.
std::string writeQueries(const std::vector<TruthQuery>& queries, const std::filesystem::path& path);
Result<std::vector<TruthQuery>> readQueries(const std::filesystem::path& path);

}  // namespace hgg
