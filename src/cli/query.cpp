#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "core/text.h"
#include "map/file.h"
#include "query/answer.h"
#include "query/goal.h"

namespace hgg {
namespace {

using Json = nlohmann::ordered_json;

// How near and closest are judged (NearnessRule), as the command line has it.
constexpr const char *kSurfaces = "surfaces", *kEdges = "edges", *kCentroids = "centroids";

struct QueryOptions {
  std::string map, text, batch, aliases, config, nearness = kSurfaces;
  std::vector<double> from;
  std::size_t top = 5;
  bool json = false, no_goal = false;
};

/// What one map is asked with, made once.
struct Session {
  Map map;
  QueryScene scene;
  Lexicon lexicon;
  TraversabilityConfig limits;
  std::optional<CostGrid> grid;  // of the whole map, laid for many questions; else each has ground laid for it
};

/// Where who asks stands: as said, or where the map's robot was last.
std::optional<GoalStart> startOf(const Session& session, const std::optional<Standpoint>& from) {
  const std::vector<TimedPose>& poses = session.map.keyframes().poses();
  if (from) {
    return GoalStart{from->x, from->y, std::nullopt, std::nullopt};
  }
  if (poses.empty()) {
    return std::nullopt;
  }
  const Vec3 p = poses.back().T_map_body.translation();
  return GoalStart{p.x(), p.y(), std::nullopt, p.z()};
}

/// Where to go for the first answer.
std::optional<Goal> goalOf(const Session& session, const Answer& answer, const std::optional<Standpoint>& from) {
  if (answer.things.empty()) {
    return std::nullopt;
  }
  const std::optional<GoalStart> start = startOf(session, from);
  if (!start) {
    Goal none;
    none.reason = "the map has no ground that was walked on, and nobody knows where to go from";
    return none;
  }
  const NodeId thing = answer.things.front().id;
  return session.grid ? findGoal(session.map, thing, *session.grid, session.limits, *start)
                      : findGoalInMap(session.map, thing, session.limits, *start, kMaxGridCells);
}

Json jsonOf(const Goal& goal) {
  Json j;
  j["pose"] = {goal.position.x(), goal.position.y(), goal.position.z(), goal.yaw};
  j["path"] = Json::array();
  for (const Vec3& p : goal.path) {
    j["path"].push_back({p.x(), p.y(), p.z()});
  }
  j["distance"] = goal.distance;
  j["reason"] = goal.reason;
  return j;
}

Json jsonOf(const std::string& text, const Answer& answer, const std::optional<Goal>& goal) {
  Json j;
  j["text"] = text;
  j["status"] = nameOf(answer.status);
  j["answers"] = Json::array();
  for (const FoundThing& m : answer.things) {
    j["answers"].push_back({{"id", m.id},
                            {"name", m.name},
                            {"probability", m.probability},
                            {"mean", {m.mean.x(), m.mean.y(), m.mean.z()}},
                            {"reason", m.reason}});
  }
  j["reason"] = answer.reason;
  j["parse"] = Json::parse(parseJson(answer));
  j["goal"] = goal && goal->found ? jsonOf(*goal) : Json(nullptr);
  j["goal_reason"] = goal ? goal->reason : "";
  return j;
}

std::string lineOf(const Json& j) { return j.dump(-1, ' ', false, Json::error_handler_t::replace); }

void print(const Answer& answer, const std::optional<Goal>& goal) {
  if (answer.request) {
    fmt::print("read as: {}\n", describe(*answer.request));
  }
  fmt::print("{}{}{}\n", nameOf(answer.status), answer.reason.empty() ? "" : ": ", answer.reason);
  for (const FoundThing& m : answer.things) {
    fmt::print("  {:>5.1f} %  {:>6}  {:<16} at {:.2f} {:.2f} {:.2f}  {}\n", 100 * m.probability, m.id, m.name,
               m.mean.x(), m.mean.y(), m.mean.z(), m.reason);
  }
  if (goal && goal->found) {
    fmt::print("go to {:.2f} {:.2f} {:.2f}, yaw {:.2f} rad, {:.1f} m from it, by {} points{}{}\n", goal->position.x(),
               goal->position.y(), goal->position.z(), goal->yaw, goal->distance, goal->path.size(),
               goal->reason.empty() ? "" : "; ", goal->reason);
  } else if (goal) {
    fmt::print("no goal: {}\n", goal->reason);
  }
}

std::optional<Standpoint> standpointOf(const std::vector<double>& v) {
  if (v.size() != 3) {
    return std::nullopt;
  }
  const Standpoint from{v[0], v[1], v[2]};
  return isPlace(from) ? std::optional(from) : std::nullopt;
}

Result<Session> openSession(const QueryOptions& o) {
  Aliases aliases;
  if (!o.aliases.empty()) {
    const std::optional<std::string> text = readFile(o.aliases);
    const Result<Aliases> own = text ? parseAliases(*text, o.aliases)
                                     : Result<Aliases>::fail(fmt::format("{}: cannot read the aliases", o.aliases));
    if (!own) {
      return Result<Session>::fail(own.error);
    }
    aliases.add(*own);
  }
  const Result<LoadedConfig> config = loadConfig(o.config);
  if (!config) {
    return Result<Session>::fail(config.error);
  }
  Result<StoredMap> stored = loadMap(o.map);
  if (!stored) {
    return Result<Session>::fail(stored.error);
  }
  QueryScene scene = sceneOf(stored->map);
  if (o.nearness == kEdges) {
    scene.nearness = NearnessRule::kEdges;
    addEdges(stored->map, scene);
  } else if (o.nearness == kCentroids) {
    scene.nearness = NearnessRule::kCentroids;
  }
  LexiconLayers layers;
  layers.more_aliases = &aliases;
  Lexicon lexicon(scene.class_names, layers);
  Session session{std::move(stored->map), std::move(scene), std::move(lexicon), config->config.traversability, {}};
  if (!o.no_goal && !o.batch.empty() && !session.map.keyframes().poses().empty()) {
    if (const Result<GridRegion> region = regionWithin(session.map, std::nullopt)) {
      if (const Result<GridShape> shape = gridShape(*region, session.limits.resolution)) {
        session.grid = buildCostGrid(session.map, *shape, session.limits);
      }
    }
  }
  return Result<Session>::ok(std::move(session));
}

Json answerJson(const QueryOptions& o, const Session& session, const std::string& text,
                const std::optional<Standpoint>& from) {
  const Answer answer = answerText(text, session.scene, session.lexicon, from, o.top);
  return jsonOf(text, answer, o.no_goal ? std::nullopt : goalOf(session, answer, from));
}

int queryBatch(const QueryOptions& o, const Session& session) {
  const auto answer = [&](const nlohmann::json& line) -> std::optional<std::string> {
    std::optional<Standpoint> from = standpointOf(o.from);
    if (line.is_object() && line.contains("from")) {
      const std::optional<std::vector<double>> numbers = numbersOf(line, "from");
      from = numbers ? standpointOf(*numbers) : std::nullopt;
      if (!from) {
        return std::nullopt;
      }
    }
    const bool has_text = line.is_object() && line.contains("text") && line["text"].is_string();
    return has_text ? std::optional(lineOf(answerJson(o, session, line["text"].get<std::string>(), from)))
                    : std::nullopt;
  };
  const auto refuse = [](const std::string& why) {
    Answer none;
    none.reason = why;
    return lineOf(jsonOf("", none, std::nullopt));
  };
  return answerLines(o.batch, R"({"text":"..","from":[x,y,yaw]} in UTF-8, without "from" if need be)", answer, refuse);
}

int query(const QueryOptions& o) {
  if (o.batch.empty() == o.text.empty()) {
    return fail("query needs a text or --batch FILE, and not both (see --help)");
  }
  if (!o.from.empty() && !standpointOf(o.from)) {
    return fail("--from must be x,y,yaw, m within a million and rad");
  }
  const Result<Session> session = openSession(o);
  if (!session) {
    return fail(session.error);
  }
  if (!o.batch.empty()) {
    return queryBatch(o, *session);
  }
  const std::optional<Standpoint> from = standpointOf(o.from);
  const Answer answer = answerText(o.text, session->scene, session->lexicon, from, o.top);
  const std::optional<Goal> goal = o.no_goal ? std::nullopt : goalOf(*session, answer, from);
  if (o.json) {
    fmt::print("{}\n", lineOf(jsonOf(o.text, answer, goal)));
  } else {
    print(answer, goal);
  }
  return answer.things.empty() ? kNo : kDone;
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
  command
      ->add_option("--nearness", o->nearness,
                   "for evaluation: how near and closest are judged: by surfaces (default), by edges of the graph, by "
                   "centroids")
      ->check(CLI::IsMember({kSurfaces, kEdges, kCentroids}));
  command->add_option("--config", o->config, "hggmap.toml with the robot's limits, [traversability]");
  command->add_flag("--json", o->json, "print JSON");
  command->add_flag("--no-goal", o->no_goal, "say what is meant only, not where to go");
  command->footer(
      "Exit status 1: the map has no such thing, or the text was not understood.\nExample:\n"
      "  hggmap query maps/drive/map.hgg \"go to the bench next to the tree\" --from 0,0,0");
  command->callback([o, &action] { action = [o] { return query(*o); }; });
}

}  // namespace hgg
