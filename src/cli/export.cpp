#include "map/export.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "core/text.h"
#include "map/file.h"

namespace hgg {
namespace {

/// A format: its name for --format, what --help says of it, and what writes it.
struct Format {
  const char* name;
  const char* help;
  std::string (*write)(const StoredMap& stored);
};

/// The one list of formats: what --format takes, explains and does.
constexpr Format kFormats[] = {{"json", "graph with geometry", exportJson},
                               {"ply", "one vertex a leaf Gaussian", exportPly}};

struct ExportOptions {
  std::string map, format, out;
};

int exportMap(const ExportOptions& o) {
  const Result<StoredMap> stored = loadMap(o.map);
  if (!stored) {
    return fail(stored.error);
  }
  // --format takes the names in kFormats only, so that there is one.
  const Format& format = *std::ranges::find(kFormats, o.format, &Format::name);
  std::ofstream file(o.out, std::ios::binary | std::ios::trunc);
  if (!(file << format.write(*stored)) || !file.flush()) {
    return fail(fmt::format("{}: cannot write the export", o.out));
  }
  return kDone;
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
  command->footer("Example:\n  hggmap export maps/drive/map.hgg --format json -o drive.json");
  command->callback([o, &action] { action = [o] { return exportMap(*o); }; });
}

}  // namespace hgg
