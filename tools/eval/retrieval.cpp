#include "eval/retrieval.h"

#include <algorithm>
#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

namespace hgg {
namespace {

using nlohmann::json;

QueryAnswer answerOf(const json& line) {
  QueryAnswer answer{line.at("text").get<std::string>(), {}};
  for (const json& entry : line.at("answers")) {
    answer.nodes.push_back(entry.at("id").get<NodeId>());
  }
  return answer;
}

}  // namespace

Result<std::vector<QueryAnswer>> readAnswers(const std::filesystem::path& path) {
  using Answers = Result<std::vector<QueryAnswer>>;
  std::ifstream in(path);
  if (!in) {
    return Answers::fail("cannot read " + path.string());
  }
  std::vector<QueryAnswer> answers;
  std::string line;
  try {
    while (std::getline(in, line)) {
      answers.push_back(answerOf(json::parse(line)));
    }
  } catch (const json::exception& e) {
    return Answers::fail(path.string() + " line " + std::to_string(answers.size() + 1) +
                         " is not an answer: " + e.what());
  }
  return Answers::ok(std::move(answers));
}

double RetrievalScore::recallAt(std::size_t k) const {
  return queries > 0 ? static_cast<double>(hits.at(k - 1)) / static_cast<double>(queries)
                     : std::numeric_limits<double>::quiet_NaN();
}

Result<RetrievalScore> scoreRetrieval(std::span<const TruthQuery> queries, std::span<const QueryAnswer> answers,
                                      const std::vector<ObjectMatch>& matches) {
  using Score = Result<RetrievalScore>;
  const auto same_text = [](const TruthQuery& q, const QueryAnswer& a) { return q.text == a.text; };
  if (!std::ranges::equal(queries, answers, same_text)) {
    return Score::fail("the answers are not to the truth's queries: make them with hggmap query --batch queries.jsonl");
  }
  std::map<std::int64_t, NodeId> node_of;
  for (const ObjectMatch& match : matches) {
    node_of[match.truth] = match.prediction;
  }
  RetrievalScore score{queries.size(), 0, {}};
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const auto node = node_of.find(queries[i].target);
    if (node == node_of.end()) {
      continue;
    }
    ++score.mapped;
    const auto& nodes = answers[i].nodes;
    const auto rank = static_cast<std::size_t>(std::ranges::find(nodes, node->second) - nodes.begin());
    for (std::size_t k = 0; k < score.hits.size(); ++k) {
      score.hits[k] += rank < nodes.size() && rank <= k ? 1 : 0;
    }
  }
  return Score::ok(score);
}

}  // namespace hgg
