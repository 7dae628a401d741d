#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "map/file.h"
#include "mapper.h"
#include "merge_maps.h"

namespace hgg {
namespace {

struct MergeOptions {
  std::vector<std::string> maps;
  std::string out, config;
  bool json = false;
};

std::string mergeJson(const MergedMaps& merged) {
  nlohmann::ordered_json pairs = nlohmann::ordered_json::array();
  for (const MapPair& p : merged.pairs) {
    pairs.push_back({{"a", p.a + 1},
                     {"b", p.b + 1},
                     {"accepted", p.found.accepted},
                     {"score", p.found.score},
                     {"threshold", p.found.threshold},
                     {"reason", p.found.reason}});
  }
  nlohmann::ordered_json poses = nlohmann::ordered_json::array();
  for (const Pose& T : merged.T_first_map) {
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (Eigen::Index k = 0; k < 12; ++k) {
      rows.push_back(T.matrix()(k / 4, k % 4));
    }
    poses.push_back(rows);
  }
  const nlohmann::ordered_json answer{{"accepted", merged.accepted}, {"reason", merged.reason}, {"T_first_map", poses},
                                      {"places", merged.places},     {"joined", merged.joined}, {"pairs", pairs}};
  return answer.dump();
}

std::string describe(const MergedMaps& merged, const std::string& out) {
  if (!merged.accepted) {
    return fmt::format("refused: {}; nothing was written (hggmap align says more of two maps)", merged.reason);
  }
  return fmt::format("{}: {} objects; {}, laid onto each other at {} places, {} nodes joined with another", out,
                     merged.map.confirmedCount(), merged.reason, merged.places, merged.joined);
}

/// Why a map cannot be joined with others at all; empty: it may be.
std::string whyNotMerged(const Map& map, const std::vector<Map>& others) {
  const auto is_stuff = [](const auto& entry) { return entry.second.stuff; };
  if (map.tileSize() == 0 && std::ranges::any_of(map.nodes(), is_stuff)) {
    return ": its ground and walls are not cut into tiles, as those of an imported graph: it cannot be joined";
  }
  const auto has_same_keyframes = [&](const Map& other) {
    return std::ranges::equal(map.keyframes().poses(), other.keyframes().poses(), {}, &TimedPose::utime_us,
                              &TimedPose::utime_us);
  };
  return !map.keyframes().poses().empty() && std::ranges::any_of(others, has_same_keyframes)
             ? " is one of the maps before, with the same keyframes: what it saw would count twice"
             : "";
}

int merge(const MergeOptions& o) {
  const Result<LoadedConfig> loaded = loadConfig(o.config);
  if (!loaded) {
    return fail(loaded.error);
  }
  std::vector<Map> maps;
  for (const std::string& path : o.maps) {
    Result<StoredMap> stored = loadMap(path);
    if (!stored) {
      return fail(stored.error);
    }
    if (const std::string why = whyNotMerged(stored->map, maps); !why.empty()) {
      return fail(path + why);
    }
    if (const std::string why = explainMismatch(stored->map, loaded->config, loaded->classes); !why.empty()) {
      return fail(fmt::format("{}: {}", path, why));
    }
    if (!maps.empty() && stored->map.tileSize() != maps.front().tileSize()) {
      return fail(fmt::format("{}: tiles of {} m, those of {} have {} m: they cannot be one map", path,
                              stored->map.tileSize(), o.maps.front(), maps.front().tileSize()));
    }
    maps.push_back(std::move(stored->map));
  }
  const MergedMaps merged = mergeMaps(maps, loaded->classes, loaded->config);
  if (merged.accepted) {
    if (const std::string error = saveMap(merged.map, o.out); !error.empty()) {
      return fail(error);
    }
  }
  const std::string answer = (o.json ? mergeJson(merged) : describe(merged, o.out)) + "\n";
  if (std::fputs(answer.c_str(), stdout) < 0 || std::fflush(stdout) != 0) {
    return fail("stdout: cannot write the answer");
  }
  return merged.accepted ? kDone : kNo;
}

}  // namespace

void addMerge(CLI::App& app, Action& action) {
  const auto o = std::make_shared<MergeOptions>();
  CLI::App* command = app.add_subcommand("merge", "Join maps of one place, without any initial pose");
  command->add_option("MAP", o->maps, "map.hgg, two or more; the frame of the first is kept")
      ->required()
      ->expected(2, 1000);
  command->add_option("-o,--out", o->out, "map.hgg to write")->required();
  command->add_option("--config", o->config, "TOML config the maps were made with (default: built-in)");
  command->add_flag("--json", o->json, "one line of JSON: accepted, reason, T_first_map, places, joined, pairs");
  command->footer(
      "Exit status: 0 joined, 1 refused (a map is recognised nowhere, or recognitions contradict), 2 bad input.\n"
      "Example:\n  hggmap merge monday/map.hgg friday/map.hgg -o both.hgg");
  command->callback([o, &action] { action = [o] { return merge(*o); }; });
}

}  // namespace hgg
