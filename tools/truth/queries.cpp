#include "truth/queries.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

namespace hgg {

using nlohmann::json;

std::string writeQueries(const std::vector<TruthQuery>& queries, const std::filesystem::path& path) {
  std::ofstream out(path);
  for (const TruthQuery& query : queries) {
    out << json{{"text", query.text}, {"target", query.target}, {"class", query.class_name}}.dump() << "\n";
  }
  out.close();
  return out ? "" : "cannot write " + path.string();
}

Result<std::vector<TruthQuery>> readQueries(const std::filesystem::path& path) {
  using Queries = Result<std::vector<TruthQuery>>;
  std::ifstream in(path);
  if (!in) {
    return Queries::fail("cannot read " + path.string() + ": " + std::strerror(errno));
  }
  std::vector<TruthQuery> queries;
  std::string line;
  for (std::size_t number = 1; std::getline(in, line); ++number) {
    try {
      const json entry = json::parse(line);
      queries.push_back({entry.at("text").get<std::string>(), entry.at("target").get<std::int64_t>(),
                         entry.at("class").get<std::string>()});
    } catch (const json::exception&) {
      return Queries::fail(path.string() + " line " + std::to_string(number) +
                           ": expected {\"text\":..,\"target\":id,\"class\":..}");
    }
  }
  return Queries::ok(std::move(queries));
}

}  // namespace hgg
