#include "map/export.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <fstream>
#include <memory>

#include "cli/commands.h"
#include "map/file.h"

namespace hgg {
namespace {

struct ExportOptions {
  std::string map, format, out;
};

int exportMap(const ExportOptions& o) {
  const Result<StoredMap> stored = loadMap(o.map);
  if (!stored) {
    return fail(stored.error);
  }
  std::ofstream file(o.out, std::ios::binary | std::ios::trunc);
  if (!(file << (o.format == "ply" ? exportPly(*stored) : exportJson(*stored))) || !file.flush()) {
    return fail(fmt::format("{}: cannot write the export", o.out));
  }
  return kDone;
}

}  // namespace

void addExport(CLI::App& app, Action& action) {
  const auto o = std::make_shared<ExportOptions>();
  CLI::App* command = app.add_subcommand("export", "Write a map in another format");
  command->add_option("MAP", o->map, "map.hgg")->required();
  command->add_option("--format", o->format, "json: graph with geometry; ply: one vertex a leaf Gaussian")
      ->required()
      ->check(CLI::IsMember({"json", "ply"}));
  command->add_option("-o,--output", o->out, "file to write")->required();
  command->footer("Example:\n  hggmap export maps/drive/map.hgg --format json -o drive.json");
  command->callback([o, &action] { action = [o] { return exportMap(*o); }; });
}

}  // namespace hgg
