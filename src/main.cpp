// hggmap: sets the process up and dispatches; what each command does is in cli/.
#include <glog/logging.h>
#include <malloc.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>

#include "cli/commands.h"

namespace {

void setUpProcess() {
  // Clouds come and go ten times a second: keep their pages instead of giving them back and faulting them in again,
  // which costs 2 ms a frame.
  mallopt(M_TRIM_THRESHOLD, 128 << 20);
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  FLAGS_minloglevel = google::GLOG_FATAL;  // Ceres speaks to users of its own; ours learn what came of it
  spdlog::set_default_logger(spdlog::stderr_color_mt("hggmap"));
  spdlog::set_pattern("%Y-%m-%d %H:%M:%S.%e %^%l%$ %v");
}

}  // namespace

int main(int argc, char** argv) {
  setUpProcess();
  CLI::App app("hggmap: LiDAR and odometry in, a probabilistic scene graph out", "hggmap");
  app.require_subcommand(1);
  app.set_version_flag("--version", "hggmap 0.1.0");
  app.footer("Exit status: 0 done, 1 the answer is no, 2 bad input or usage.");
  hgg::Action action;
  hgg::addCommands(app, action);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return e.get_exit_code() == 0 ? app.exit(e) : hgg::fail(std::string(e.what()) + " (see --help)");
  }
  return action();
}
