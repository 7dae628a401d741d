#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <map>
#include <memory>

#include "cli/commands.h"
#include "map/file.h"
#include "region/regions.h"

namespace hgg {
namespace {

struct InfoOptions {
  std::string map;
};

/// What a map holds of one class.
struct ClassSummary {
  std::size_t nodes = 0, leaves = 0;
  double kappa = 0;
  bool stuff = false;
};

void printClasses(const Map& map) {
  std::map<ClassId, ClassSummary> rows;
  for (const auto& [id, node] : map.nodes()) {
    if (isConfirmed(node)) {
      ClassSummary& row = rows[node.label];
      ++row.nodes, row.leaves += leavesOf(node).size(), row.kappa += node.belief.kappa, row.stuff = node.stuff;
    }
  }
  fmt::print("{:>6}  {:<20} {:<6} {:>8} {:>8} {:>12}\n", "label", "class", "kind", "nodes", "leaves", "points");
  for (const auto& [label, row] : rows) {
    const auto name = map.classNames().find(label);
    fmt::print("{:>6}  {:<20} {:<6} {:>8} {:>8} {:>12.0f}\n", label,
               name != map.classNames().end() ? name->second : "?", row.stuff ? "stuff" : "thing", row.nodes,
               row.leaves, row.kappa);
  }
}

void printExtent(const Map& map) {
  if (const auto& poses = map.keyframes().poses(); !poses.empty()) {
    fmt::print("time  {:.3f} .. {:.3f} s\n", static_cast<double>(poses.front().utime_us) * 1e-6,
               static_cast<double>(poses.back().utime_us) * 1e-6);
  }
  Eigen::AlignedBox3d box;
  for (const auto& [id, node] : map.nodes()) {
    if (isConfirmed(node)) {
      box.extend(node.belief.mean);
    }
  }
  if (!box.isEmpty()) {
    fmt::print("means x {:.1f} .. {:.1f}, y {:.1f} .. {:.1f}, z {:.1f} .. {:.1f} m\n", box.min().x(), box.max().x(),
               box.min().y(), box.max().y(), box.min().z(), box.max().z());
  }
}

void printRegions(const Map& map) {
  const Regions found = findRegions(map);
  fmt::print("{} regions\n", found.regions.size());
  for (const Region& region : found.regions) {
    std::map<std::string, int> counts;
    for (const NodeId id : region.objects) {
      const auto name = map.classNames().find(map.find(id)->label);
      ++counts[name != map.classNames().end() ? name->second : "?"];
    }
    std::string things;
    for (const auto& [name, count] : counts) {
      things += fmt::format("{}{} {}", things.empty() ? "" : ", ", count, name);
    }
    fmt::print("{:>6}  {:<20} at {:7.1f} {:7.1f} {:6.1f}: {}\n", region.id, region.name, region.belief.mean.x(),
               region.belief.mean.y(), region.belief.mean.z(), things);
  }
}

int info(const InfoOptions& o) {
  const Result<StoredMap> stored = loadMap(o.map);
  if (!stored) {
    return fail(stored.error);
  }
  const Map& map = stored->map;
  fmt::print(
      "{}: {} objects (and {} candidates), {} leaves, {} edges, {} keyframes, revision {}, {:.1f} MB in memory\n",
      o.map, map.confirmedCount(), map.nodes().size() - map.confirmedCount(), map.leafCount(), stored->edges.size(),
      map.keyframes().poses().size(), map.revision(), map.megabytes());
  printExtent(map);
  printClasses(map);
  printRegions(map);
  return kDone;
}

}  // namespace

void addInfo(CLI::App& app, Action& action) {
  const auto o = std::make_shared<InfoOptions>();
  CLI::App* command = app.add_subcommand("info", "Say what is in a map");
  command->add_option("MAP", o->map, "map.hgg")->required();
  command->footer("Example:\n  hggmap info maps/drive/map.hgg");
  command->callback([o, &action] { action = [o] { return info(*o); }; });
}

}  // namespace hgg
