#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <vector>

#include "eval/objects.h"
#include "truth/queries.h"

namespace hgg {

/// What `hggmap query --batch` answered to one text: nodes of the map, best first.
struct QueryAnswer {
  std::string text;
  std::vector<NodeId> nodes;
};

/// One JSON a line, {"text":..,"answers":[{"id":..},...],...}.
Result<std::vector<QueryAnswer>> readAnswers(const std::filesystem::path& path);

struct RetrievalScore {
  std::size_t queries = 0;
  std::size_t mapped = 0;                // whose target was found by the mapper: no answer can be right otherwise
  std::array<std::size_t, 3> hits{};     // with the target among the first 1, 2, 3 answers
  double recallAt(std::size_t k) const;  // k = 1..3; NaN without queries
};

/// A query is answered when the node that was matched to its target is returned. Error: answers that are not to these
/// queries, in this order.
Result<RetrievalScore> scoreRetrieval(std::span<const TruthQuery> queries, std::span<const QueryAnswer> answers,
                                      const std::vector<ObjectMatch>& matches);

}  // namespace hgg
