#include "map/export.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "cli/progress_bar.h"
#include "config.h"
#include "core/text.h"
#include "map/file.h"
#include "region/regions.h"
#include "traversability/grid_layers.h"
#include "traversability/octomap_export.h"

namespace hgg {
namespace {

struct ExportOptions {
  std::string map, format, out, config;
  std::vector<double> region;        // x0, y0, x1, y1; empty: all of the map
  std::optional<double> resolution;  // m
  bool semantic = false;
};

/// The files of an export; what their names end with follows the name that was asked for.
using Files = Result<std::vector<GridFile>>;

Files one(std::string bytes) { return Files::ok({{"", std::move(bytes)}}); }

/// The region that was asked for, or the whole map. An error where there is nothing.
Result<GridRegion> regionFor(const StoredMap& stored, const ExportOptions& o) {
  std::optional<GridRegion> asked;
  if (!o.region.empty()) {
    asked = GridRegion{o.region[0], o.region[1], o.region[2], o.region[3]};
  }
  Result<GridRegion> region = regionWithin(stored.map, asked);
  return region ? region : Result<GridRegion>::fail(fmt::format("{}: {}", o.map, region.error));
}

Files gridOf(const StoredMap& stored, const ExportOptions& o) {
  const Result<LoadedConfig> config = loadConfig(o.config);
  const Result<GridRegion> region = regionFor(stored, o);
  if (!config || !region) {
    return Files::fail(config ? region.error : config.error);
  }
  const TraversabilityConfig& limits = config->config.traversability;
  const Result<GridShape> shape = gridShape(*region, o.resolution.value_or(limits.resolution));
  if (!shape) {
    return Files::fail(shape.error);
  }
  ProgressBar bar("grid");
  const CostGrid grid = buildCostGrid(stored.map, *shape, limits, [&](double share) { bar.show(share, ""); });
  bar.finish();
  return Files::ok(
      gridFiles(layersOf(grid, groundHeight(stored.map, grid)), std::filesystem::path(o.out).filename().string()));
}

template <std::string (*Write)(const VoxelGrid&)>
Files octomapOf(const StoredMap& stored, const ExportOptions& o) {
  const Result<LoadedConfig> config = loadConfig(o.config);
  const Result<GridRegion> region = regionFor(stored, o);
  if (!config || !region) {
    return Files::fail(config ? region.error : config.error);
  }
  VoxelOptions options{o.resolution.value_or(config->config.traversability.resolution), std::nullopt};
  if (!o.region.empty()) {
    options.region = *region;
  }
  ProgressBar bar("octomap");
  options.classes = o.semantic;
  const Result<VoxelGrid> voxels = voxelsOf(stored.map, options, [&](double share) { bar.show(share, ""); });
  bar.finish();
  return voxels ? one(o.semantic ? octomapColoured(*voxels) : Write(*voxels)) : Files::fail(voxels.error);
}

/// A format: its name for --format, what --help says of it, and what makes it.
struct Format {
  const char* name;
  const char* help;
  Files (*make)(const StoredMap& stored, const ExportOptions& o);
};

/// The one list of formats: what --format takes, explains and does.
constexpr Format kFormats[] = {
    {"json", "graph with geometry and regions",
     [](const StoredMap& s, const ExportOptions&) { return one(exportJson(s, findRegions(s.map))); }},
    {"ply", "one vertex a leaf Gaussian", [](const StoredMap& s, const ExportOptions&) { return one(exportPly(s)); }},
    {"bt", "OctoMap, binary", octomapOf<octomapBinary>},
    {"ot", "OctoMap with probabilities", octomapOf<octomapFull>},
    {"grid", "where a robot can walk, for map_server and NumPy: F.yaml, F.pgm, F.layers.json, F.<layer>.npy", gridOf}};

/// Writes all files or, where one fails or the user stops it, none: they get their names when all are there.
int writeAll(const std::vector<GridFile>& files, const std::string& out, const std::atomic<bool>& stop) {
  const auto part = [&](const GridFile& f) {
    const std::string name = out + f.suffix;
    const bool is_device = std::filesystem::exists(name) && !std::filesystem::is_regular_file(name);  // /dev/stdout
    return is_device ? name : name + ".part";
  };
  std::string error;
  for (const GridFile& f : files) {
    std::ofstream file(part(f), std::ios::binary | std::ios::trunc);
    if (!(file << f.bytes) || !file.flush()) {
      error = fmt::format("{}: cannot write the export", out + f.suffix);
      break;
    }
  }
  error = error.empty() && stop ? "stopped: nothing was written" : error;
  for (const GridFile& f : files) {
    const std::string name = out + f.suffix;
    if (part(f) == name) {
      continue;
    }
    if (!error.empty()) {
      std::remove(part(f).c_str());
    } else if (std::rename(part(f).c_str(), name.c_str()) != 0) {
      error = fmt::format("{}: cannot write the export", name);
      std::remove(part(f).c_str());
    }
  }
  return error.empty() ? kDone : fail(error);
}

int exportMap(const ExportOptions& o) {
  if (o.semantic && o.format != "ot") {
    return fail("--semantic goes with --format ot: no other format of OctoMap has colours");
  }
  const Result<StoredMap> stored = loadMap(o.map);
  if (!stored) {
    return fail(stored.error);
  }
  // --format takes the names in kFormats only, so that there is one.
  const Files files = std::ranges::find(kFormats, o.format, &Format::name)->make(*stored, o);
  if (!files) {
    return fail(files.error);
  }
  return writeAll(*files, o.out, stopOnSignals());
}

}  // namespace

void addExport(CLI::App& app, Action& action) {
  const auto o = std::make_shared<ExportOptions>();
  std::vector<std::string> names, help;
  for (const Format& format : kFormats) {
    names.emplace_back(format.name);
    help.push_back(fmt::format("{}: {}", format.name, format.help));
  }
  CLI::App* command = app.add_subcommand("export", "Write a map in another format");
  command->add_option("MAP", o->map, "map.hgg")->required();
  command->add_option("--format", o->format, join(help, "; "))->required()->check(CLI::IsMember(names));
  command->add_option("-o,--output", o->out, "file to write")->required();
  command->add_option("--region", o->region, "x0,y0,x1,y1 [m, map frame]; default: all of the map (bt, ot, grid)")
      ->delimiter(',')
      ->expected(4);
  command->add_option("--resolution", o->resolution, "edge of a cell [m]; default: as configured (bt, ot, grid)");
  command->add_option("--config", o->config, "hggmap.toml with the robot's limits, [traversability] (bt, ot, grid)");
  command->add_flag("--semantic", o->semantic, "occupied voxels in the colour of their class, as a ColorOcTree (ot)");
  command->footer(
      "Examples:\n  hggmap export maps/drive/map.hgg --format json -o drive.json\n"
      "  hggmap export maps/drive/map.hgg --format grid -o drive --region -20,-20,20,20 --resolution 0.1");
  command->callback([o, &action] { action = [o] { return exportMap(*o); }; });
}

}  // namespace hgg
