#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "cli/commands.h"
#include "core/text.h"
#include "map/file.h"
#include "query/answer.h"

namespace hgg {
namespace {

using Json = nlohmann::ordered_json;

struct QueryOptions {
  std::string map, text, batch, aliases;
  std::vector<double> from;
  std::size_t top = 5;
  bool json = false, no_goal = false;
};

Json jsonOf(const std::string& text, const Answer& answer) {
  Json j;
  j["text"] = text;
  j["status"] = nameOf(answer.status);
  j["answers"] = Json::array();
  for (const FoundThing& m : answer.matches) {
    j["answers"].push_back({{"id", m.id},
                            {"name", m.name},
                            {"probability", m.probability},
                            {"mean", {m.mean.x(), m.mean.y(), m.mean.z()}},
                            {"reason", m.reason}});
  }
  j["reason"] = answer.reason;
  j["parse"] = Json::object();
  if (answer.request) {
    j["parse"] = {{"reading", describe(*answer.request)}, {"unread", answer.request->unread}};
  }
  j["goal"] = nullptr;
  return j;
}

std::string lineOf(const Json& j) { return j.dump(-1, ' ', false, Json::error_handler_t::replace); }

void print(const Answer& answer) {
  if (answer.request) {
    fmt::print("read as: {}\n", describe(*answer.request));
  }
  fmt::print("{}{}{}\n", nameOf(answer.status), answer.reason.empty() ? "" : ": ", answer.reason);
  for (const FoundThing& m : answer.matches) {
    fmt::print("  {:>5.1f} %  {:>6}  {:<16} at {:.2f} {:.2f} {:.2f}  {}\n", 100 * m.probability, m.id, m.name,
               m.mean.x(), m.mean.y(), m.mean.z(), m.reason);
  }
}

std::optional<Standpoint> standpointOf(const std::vector<double>& v) {
  if (v.size() != 3 || !std::ranges::all_of(v, [](double x) { return std::isfinite(x); })) {
    return std::nullopt;
  }
  return Standpoint{v[0], v[1], v[2]};
}

int queryBatch(const QueryOptions& o, const QueryScene& scene, const Lexicon& lexicon) {
  const std::optional<std::string> text = readFile(o.batch);
  if (!text) {
    return fail(fmt::format("{}: cannot read the batch", o.batch));
  }
  std::istringstream lines(*text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (line.find_first_not_of(" \t\r") == std::string::npos) {
      continue;
    }
    const Json j = Json::parse(line, nullptr, false);
    std::optional<Standpoint> from = standpointOf(o.from);
    bool is_fine = j.is_object() && j.contains("text") && j["text"].is_string();
    if (is_fine && j.contains("from")) {
      const bool numbers =
          j["from"].is_array() && std::ranges::all_of(j["from"], [](const auto& v) { return v.is_number(); });
      from = numbers ? standpointOf(j["from"].get<std::vector<double>>()) : std::nullopt;
      is_fine = from.has_value();
    }
    if (!is_fine) {
      return fail(fmt::format("{}:{}: a line is {{\"text\":\"..\",\"from\":[x,y,yaw]}}, without \"from\" if need be",
                              o.batch, number));
    }
    const auto query = j["text"].get<std::string>();
    fmt::print("{}\n", lineOf(jsonOf(query, answerText(query, scene, lexicon, from, o.top))));
  }
  return kDone;
}

int query(const QueryOptions& o) {
  if (o.batch.empty() == o.text.empty()) {
    return fail("query needs a text or --batch FILE, and not both (see --help)");
  }
  if (!o.from.empty() && !standpointOf(o.from)) {
    return fail("--from must be x,y,yaw");
  }
  Aliases aliases = builtinAliases();
  if (!o.aliases.empty()) {
    const std::optional<std::string> text = readFile(o.aliases);
    const Result<Aliases> own = text ? parseAliases(*text, o.aliases)
                                     : Result<Aliases>::fail(fmt::format("{}: cannot read the aliases", o.aliases));
    if (!own) {
      return fail(own.error);
    }
    aliases.add(*own);
  }
  const Result<StoredMap> stored = loadMap(o.map);
  if (!stored) {
    return fail(stored.error);
  }
  const QueryScene scene = sceneOf(stored->map);
  LexiconLayers layers;
  layers.aliases = &aliases;
  const Lexicon lexicon(scene.class_names, layers);
  if (!o.batch.empty()) {
    return queryBatch(o, scene, lexicon);
  }
  const Answer answer = answerText(o.text, scene, lexicon, standpointOf(o.from), o.top);
  if (o.json) {
    fmt::print("{}\n", lineOf(jsonOf(o.text, answer)));
  } else {
    print(answer);
  }
  return answer.matches.empty() ? kNo : kDone;
}

}  // namespace

void addQuery(CLI::App& app, Action& action) {
  const auto o = std::make_shared<QueryOptions>();
  CLI::App* command = app.add_subcommand("query", "Find what a sentence means in a map");
  command->add_option("MAP", o->map, "map.hgg")->required();
  command->add_option("TEXT", o->text, "what to find, in English");
  command->add_option("--from", o->from, "x,y,yaw of who asks, map frame [m, rad]")->delimiter(',')->expected(3);
  command->add_option("--top", o->top, "most answers to give")->check(CLI::Range(1, 1000));
  command->add_option("--batch", o->batch, R"(file of lines {"text":"..","from":[x,y,yaw]}: one JSON answer a line)");
  command->add_option("--aliases", o->aliases, "more words for classes, beside those of the shipped label sets");
  command->add_flag("--json", o->json, "print JSON");
  command->add_flag("--no-goal", o->no_goal, "say what is meant only, not where to go");
  command->footer(
      "Exit status 1: the map has no such thing, or the text was not understood.\nExample:\n"
      "  hggmap query maps/drive/map.hgg \"go to the bench next to the tree\" --from 0,0,0");
  command->callback([o, &action] { action = [o] { return query(*o); }; });
}

}  // namespace hgg
