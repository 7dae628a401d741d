// Drives a robot along a road that closes, for as many kilometres as asked for, through the mapper itself, and writes
// what it takes: memory against the way, time of the frames, and whether what was mapped first is found again.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "config.h"
#include "endurance/ring.h"
#include "map/file.h"
#include "map/page_keeper.h"
#include "mapper.h"
#include "stats.h"

namespace {

using Clock = std::chrono::steady_clock;
using nlohmann::ordered_json;

constexpr int kBadInput = 2;
constexpr double kWorldReach = 60, kWorldStep = 40;  // m
constexpr double kFound = 1.0;                       // m: a node this near to the middle of a thing is it
constexpr double kChecked = 40;                      // m around the start

struct Options {
  double kilometres = 10, step = 2.5, laps = 1, beyond = 150, budget_mb = 64;
  std::string out = "endurance", config;
};

struct Sample {
  double way = 0, map_mb = 0, rss_mb = 0;
  std::size_t nodes = 0, leaves = 0, keyframes = 0, away = 0;
};

double quantile(std::vector<double> values, double share) {
  if (values.empty()) {
    return 0;
  }
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// How often the things around the start are in the map: "times seen" to number of things.
std::map<int, int> countsAtStart(const hgg::RingRoad& road, const hgg::Map& map) {
  std::map<int, int> counts;
  for (const hgg::RingRoad::Thing& thing : road.thingsAround(0, kChecked)) {
    int found = 0;
    for (const hgg::NodeId id : map.nearAnywhere(thing.p_map, kFound)) {
      const hgg::MapNode& node = *map.find(id);
      found += node.label == thing.label && hgg::isConfirmed(node) ? 1 : 0;
    }
    ++counts[found];
  }
  return counts;
}

struct Run {
  std::vector<Sample> samples;
  std::vector<double> frame_ms;
  std::map<std::string, std::vector<double>> stage_ms;  // sums over each tenth of the way
  std::vector<Sample> laps;                             // at the end of each
  std::map<int, int> at_start_first, at_start_last;
  double seconds = 0, save_s = 0, drift_m = 0;
  int loops = 0;
  std::map<std::string, int> loop_answers;  // to questions about loops, by what was said
};

Sample sampleOf(const hgg::Mapper& mapper, double way) {
  const hgg::Map& map = mapper.map();
  return {way,
          map.megabytes(),
          hgg::residentMegabytes(),
          map.nodes().size(),
          map.leafCount(),
          map.keyframes().poses().size(),
          map.pagedOut().size()};
}

Run drive(const Options& o, const hgg::LoadedConfig& loaded, const std::string& map_path) {
  const hgg::RingRoad road(1000 * o.kilometres, 1);
  const double way = o.laps * road.length() + o.beyond;
  const auto frames = static_cast<std::int64_t>(way / o.step);
  hgg::PageKeeper keeper(o.out + "/pages.db", o.budget_mb, 0, hgg::PageKeeper::Patience::kWaits);
  hgg::Mapper mapper(loaded.config, loaded.classes, {}, hgg::LoopTiming::kPrompt, keeper.store());
  hgg::RingOdometry odometry(2);
  Run run;
  hgg::World world;
  double world_at = -1e9;
  hgg::Pose T_last = road.T_map_body(0);
  const auto begin = Clock::now();
  for (std::int64_t k = 0; k < frames; ++k) {
    const double along = o.step * static_cast<double>(k);
    if (std::abs(along - world_at) > kWorldStep) {
      world = road.worldAround(along, kWorldReach + kWorldStep);
      world_at = along;
    }
    const hgg::Pose T_map_body = road.T_map_body(along);
    hgg::Frame frame;
    frame.utime_us = 1'000'000 + 250'000 * k;
    frame.points = hgg::scanOf(world, T_map_body, static_cast<std::uint64_t>(k));
    frame.T_odom_body = odometry.advance(T_last.inverse() * T_map_body);
    T_last = T_map_body;
    const auto start = Clock::now();
    const hgg::StepReport report = mapper.step(frame);
    run.frame_ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
    for (const auto& [stage, ms] : report.stage_ms) {
      run.stage_ms[stage].resize(10);
      run.stage_ms[stage][static_cast<std::size_t>(10 * k / frames)] += 10 * ms / static_cast<double>(frames);
    }
    run.drift_m = (report.T_map_body.translation() - T_map_body.translation()).norm();
    if (k % std::max<std::int64_t>(frames / 400, 1) == 0) {
      run.samples.push_back(sampleOf(mapper, along));
    }
    const double passed = along + o.step;
    if (std::floor(passed / road.length()) > std::floor(along / road.length())) {
      run.laps.push_back(sampleOf(mapper, passed));
    }
    if (run.at_start_first.empty() && along > std::min(2 * kChecked, road.length() / 2)) {
      run.at_start_first = countsAtStart(road, mapper.map());
    }
  }
  run.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  run.loops = mapper.loops().accepted();
  for (const hgg::LoopRecord& record : mapper.loops().records()) {
    ++run.loop_answers[record.accepted ? "accepted" : record.reason];
  }
  run.at_start_last = countsAtStart(road, mapper.map());
  const auto saving = Clock::now();
  mapper.finish();
  if (const std::string error = hgg::saveMap(mapper.map(), map_path, mapper.pageReader()); !error.empty()) {
    fmt::print(stderr, "hgg-endurance: {}\n", error);
  }
  run.save_s = std::chrono::duration<double>(Clock::now() - saving).count();
  run.samples.push_back(sampleOf(mapper, way));
  return run;
}

ordered_json jsonOf(const std::map<int, int>& counts) {
  ordered_json j = ordered_json::object();
  for (const auto& [found, things] : counts) {
    j[std::to_string(found)] = things;
  }
  return j;
}

/// Of a part of the frames, without the first tenth of it, in which caches and the map around the robot fill.
double p99Of(const std::vector<double>& frame_ms, double from, double to) {
  const auto at = [&](double share) {
    return frame_ms.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(frame_ms.size()));
  };
  return quantile({at(from), at(to)}, 0.99);
}

ordered_json reportOf(const Options& o, const Run& run) {
  double peak_map = 0, peak_rss = 0;
  for (const Sample& s : run.samples) {
    peak_map = std::max(peak_map, s.map_mb), peak_rss = std::max(peak_rss, s.rss_mb);
  }
  const Sample& last = run.samples.back();
  ordered_json j{{"kilometres", o.kilometres * o.laps},
                 {"frames", run.frame_ms.size()},
                 {"seconds", run.seconds},
                 {"budget_mb", o.budget_mb},
                 {"peak_map_mb", peak_map},
                 {"peak_rss_mb", peak_rss},
                 {"keyframes", last.keyframes},
                 {"frame_ms_p50", quantile(run.frame_ms, 0.5)},
                 {"frame_ms_p99_first_tenth", p99Of(run.frame_ms, 0.01, 0.1)},
                 {"frame_ms_p99_last_tenth", p99Of(run.frame_ms, 0.9, 1)},
                 {"frame_ms_max", quantile(run.frame_ms, 1)},
                 {"loops", run.loops},
                 {"loop_answers", run.loop_answers},
                 {"drift_m", run.drift_m},
                 {"save_s", run.save_s},
                 {"start_things_by_nodes_first", jsonOf(run.at_start_first)},
                 {"start_things_by_nodes_last", jsonOf(run.at_start_last)}};
  for (const auto& [stage, ms] : run.stage_ms) {
    j["stage_ms_by_tenth"][stage] = ms;
  }
  for (const Sample& s : run.laps) {
    j["laps"].push_back({{"map_mb", s.map_mb}, {"nodes", s.nodes}, {"leaves", s.leaves}, {"keyframes", s.keyframes}});
  }
  return j;
}

void writeCurve(const std::string& path, const Run& run) {
  std::ofstream out(path);
  out << "way_m,map_mb,rss_mb,nodes,leaves,keyframes,paged_out\n";
  for (const Sample& s : run.samples) {
    out << fmt::format("{},{:.3f},{:.1f},{},{},{},{}\n", s.way, s.map_mb, s.rss_mb, s.nodes, s.leaves, s.keyframes,
                       s.away);
  }
}

}  // namespace

int main(int argc, char** argv) {
  Options o;
  CLI::App app("hgg-endurance: maps a simulated ring road of any length and writes what that takes");
  app.add_option("--kilometres", o.kilometres, "length of the ring")->capture_default_str()->check(CLI::PositiveNumber);
  app.add_option("--laps", o.laps, "how often it is driven")->capture_default_str()->check(CLI::PositiveNumber);
  app.add_option("--beyond", o.beyond, "m driven beyond the last lap")->capture_default_str();
  app.add_option("--step", o.step, "m between two frames")->capture_default_str()->check(CLI::PositiveNumber);
  app.add_option("--budget-mb", o.budget_mb, "memory of the map")->capture_default_str();
  app.add_option("--config", o.config, "TOML config (default: built-in)");
  app.add_option("--out", o.out, "directory for memory.csv, endurance.json, map.hgg")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  std::error_code error;
  std::filesystem::create_directories(o.out, error);
  hgg::Result<hgg::LoadedConfig> loaded = hgg::loadConfig(o.config);
  if (!loaded) {
    fmt::print(stderr, "hgg-endurance: {}\n", loaded.error);
    return kBadInput;
  }
  loaded->config.frame.range_max = 50;
  loaded->config.map.active_radius = 60;
  const Run run = drive(o, *loaded, o.out + "/map.hgg");
  writeCurve(o.out + "/memory.csv", run);
  const std::string report = reportOf(o, run).dump(1);
  std::ofstream(o.out + "/endurance.json") << report << '\n';
  fmt::print("{}\n", report);
  return 0;
}
