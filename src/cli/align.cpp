#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "core/units.h"
#include "map/file.h"
#include "place/zero_shot.h"

namespace hgg {
namespace {

struct AlignOptions {
  std::string map_a, map_b, classes;
  bool json = false;
};

/// The answer of align as one line of JSON; `ms` is the only thing in it that is not the same every time.
std::string alignmentJson(const ZeroShot& z, double ms) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (Eigen::Index k = 0; k < 12; ++k) {
    rows.push_back(z.T_a_b.matrix()(k / 4, k % 4));
  }
  const PlaceEvidence& e = z.evidence;
  const nlohmann::ordered_json evidence{{"things_matched", e.things_matched},
                                        {"things_missed", e.things_missed},
                                        {"thing_share", e.thing_share},
                                        {"thing_odds", e.thing_odds},
                                        {"overlap", e.overlap},
                                        {"surface_share", e.surface_share},
                                        {"chance_share", e.chance_share},
                                        {"surface_odds", e.surface_odds},
                                        {"runner_up", z.runner_up}};
  const nlohmann::ordered_json answer{
      {"accepted", z.accepted}, {"T_a_b", rows},      {"score", z.score},     {"threshold", z.threshold},
      {"pairs", z.pairs},       {"reason", z.reason}, {"evidence", evidence}, {"ms", std::round(10 * ms) / 10}};
  return answer.dump();
}

std::string describe(const ZeroShot& z) {
  const Vec3 t = z.T_a_b.translation();
  const double yaw = std::atan2(z.T_a_b.linear()(1, 0), z.T_a_b.linear()(0, 0));
  const double tilt = std::acos(std::clamp(z.T_a_b.linear()(2, 2), -1.0, 1.0));
  return fmt::format(
      "{}: {}\nscore {:.1f}, threshold {:.1f}, best place elsewhere {:.1f}\n"
      "T_a_b: x {:.3f} y {:.3f} z {:.3f} m, yaw {:.2f} deg, tilt {:.2f} deg; {} pairs of things (--json lists them)",
      z.accepted ? "accepted" : "refused", z.reason, z.score, z.threshold, z.runner_up, t.x(), t.y(), t.z(),
      yaw / kDegree, tilt / kDegree, z.pairs.size());
}

int alignStored(const AlignOptions& o) {
  const Result<StoredMap> a = loadMap(o.map_a), b = loadMap(o.map_b);
  if (!a || !b) {
    return fail(!a ? a.error : b.error);
  }
  std::vector<SimilarClasses> similar;
  if (!o.classes.empty()) {
    const Result<ClassTable> classes = ClassTable::load(o.classes);
    if (!classes) {
      return fail(classes.error);
    }
    similar = classes->similar();
  }
  const auto begin = std::chrono::steady_clock::now();
  const ZeroShot found = alignMaps(a->map, b->map, similar);
  const double ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  const std::string answer = (o.json ? alignmentJson(found, ms) : describe(found)) + "\n";
  if (std::fputs(answer.c_str(), stdout) < 0 || std::fflush(stdout) != 0) {
    return fail("stdout: cannot write the answer");
  }
  return found.accepted ? kDone : kNo;
}

}  // namespace

void addAlign(CLI::App& app, Action& action) {
  const auto o = std::make_shared<AlignOptions>();
  CLI::App* command = app.add_subcommand("align", "Lay one map over another, without any initial pose");
  command->add_option("A", o->map_a, "map.hgg whose frame is kept")->required();
  command->add_option("B", o->map_b, "map.hgg to lay over it")->required();
  command->add_flag("--json", o->json, "one line of JSON: accepted, T_a_b, score, threshold, pairs, reason");
  command->add_option("--classes", o->classes, "class table whose [[similar]] entries say which classes may be one");
  command->footer(
      "Exit status: 0 accepted, 1 refused, 2 bad input. T_a_b takes coordinates of B to those of A.\n"
      "Example:\n  hggmap align maps/monday/map.hgg maps/friday/map.hgg --json");
  command->callback([o, &action] { action = [o] { return alignStored(*o); }; });
}

}  // namespace hgg
