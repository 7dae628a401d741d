#include "map/import.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "cli/commands.h"
#include "core/text.h"
#include "map/file.h"

namespace hgg {
namespace {

struct ImportOptions {
  std::string graph, out;
};

int import(const ImportOptions& o) {
  const std::optional<std::string> text = readFile(o.graph);
  if (!text) {
    return fail(fmt::format("{}: cannot read the graph", o.graph));
  }
  const Result<Map> map = importJson(*text);
  if (!map) {
    return fail(fmt::format("{}: {}", o.graph, map.error));
  }
  if (const std::string error = saveMap(*map, o.out); !error.empty()) {
    return fail(error);
  }
  fmt::print("{}: {} objects of {} classes\n", o.out, map->nodes().size(), map->classNames().size());
  return kDone;
}

}  // namespace

void addImport(CLI::App& app, Action& action) {
  const auto o = std::make_shared<ImportOptions>();
  CLI::App* command = app.add_subcommand("import", "Make a map out of a graph from elsewhere");
  command->add_option("GRAPH", o->graph, "graph JSON: objects with mean and cov, or center and size")->required();
  command->add_option("-o,--out", o->out, "map.hgg to write")->required();
  command->footer("Example:\n  hggmap import scene.json -o scene.hgg");
  command->callback([o, &action] { action = [o] { return import(*o); }; });
}

}  // namespace hgg
