#include "eval/report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numbers>

namespace hgg {
namespace {

using nlohmann::json;

constexpr double kWholeShare = 0.95;  // of the true poses: below, the trajectory scores are of a part

template <typename... Args>
std::string format(const char* pattern, Args... args) {
  char line[512];
  std::snprintf(line, sizeof line, pattern, args...);
  return line;
}

std::string number(double value) { return std::isnan(value) ? "-" : format("%.3f", value); }

std::string formatRow(const std::string& name, const ObjectScore& s) {
  const Spread position = s.positionError();
  return format("%-16s %6zu %6zu %6zu %6zu %10s %8s %8s %8s %8s %8s %8s\n", name.c_str(), s.truth, s.matches.size(),
                s.missed.size(), s.ghosts.size(), number(s.precision()).c_str(), number(s.recall()).c_str(),
                number(s.f1()).c_str(), number(position.mean).c_str(), number(position.median).c_str(),
                number(position.max).c_str(), number(s.extentError().mean).c_str());
}

std::string formatObjects(const Evaluation& evaluation) {
  std::string text = format("objects: things of the same class within %g m; errors in m, extent by 2-Wasserstein\n",
                            evaluation.radius);
  text += format("%-16s %6s %6s %6s %6s %10s %8s %8s %8s %8s %8s %8s\n", "class", "true", "found", "missed", "ghosts",
                 "precision", "recall", "F1", "mean", "median", "max", "extent");
  for (const auto& [label, score] : evaluation.objects.classes) {
    text += formatRow(className(evaluation, label), score);
  }
  text += formatRow("all", evaluation.objects.overall);
  return evaluation.objects.dynamic.empty() ? text
                                            : text + format("%zu predictions of moving or removed objects set aside\n",
                                                            evaluation.objects.dynamic.size());
}

std::size_t countOf(const Evaluation& evaluation, GhostCause cause) {
  return static_cast<std::size_t>(std::ranges::count(evaluation.ghosts, cause, &Ghost::cause));
}

/// In words, for the table.
std::string wordsOf(GhostCause cause) {
  switch (cause) {
    case GhostCause::kSecond:
      return "second nodes or pieces of a thing that is found";
    case GhostCause::kMover:
      return "left by something that moves";
    case GhostCause::kGone:
      return "of a thing that was taken away";
    case GhostCause::kSurface:
      return "on a surface of another class";
    case GhostCause::kNothing:
      break;
  }
  return "at nothing";
}

std::string formatGhosts(const Evaluation& evaluation) {
  std::string text = evaluation.ghosts.empty() ? "" : "ghosts:";
  for (const GhostCause cause : kGhostCauses) {
    const std::size_t count = countOf(evaluation, cause);
    text += count == 0 ? "" : format("%s %zu %s", text == "ghosts:" ? "" : ",", count, wordsOf(cause).c_str());
  }
  text += text.empty() ? "" : "\n";
  if (!evaluation.twins.empty()) {
    text +=
        format("twins: %zu pairs of one class within %g m are one true thing:", evaluation.twins.size(), kTwinReach);
    constexpr std::size_t kShown = 10;
    for (std::size_t i = 0; i < std::min(kShown, evaluation.twins.size()); ++i) {
      text += format(" %lld and %lld", static_cast<long long>(evaluation.twins[i].a),
                     static_cast<long long>(evaluation.twins[i].b)) +
              (i + 1 < evaluation.twins.size() ? "," : "");
    }
    text += evaluation.twins.size() > kShown ? " ...\n" : "\n";
  }
  const MovingScore& m = evaluation.moving;
  return m.truth + m.parked.size() + m.elsewhere.size() == 0
             ? text
             : text + format(
                          "moving: %zu of %zu seen in %lld frames or more are called dynamic%s; so are %zu that stay "
                          "and %zu at nothing that moves\n",
                          m.said, m.truth, static_cast<long long>(kSeenFrames),
                          m.soon ? format(", %zu of them by the last of these", *m.soon).c_str() : "", m.parked.size(),
                          m.elsewhere.size());
}

std::string formatCalibration(const char* name, const Calibration& c, const char* what) {
  return format(
      "%s: mean normalised square / 3 = %s (honest: 1), median / 3 = %s (0.789), inside the 90 %% "
      "region: %s (0.9), mean sigma %s m, %zu %s\n",
      name, number(c.mean_over_3).c_str(), number(c.median_over_3).c_str(), number(c.inside_90).c_str(),
      number(c.mean_sigma).c_str(), c.count, what);
}

std::string formatRecovery(const Evaluation& e) {
  if (!e.recovery) {
    return "";
  }
  const RecoveryScore& r = *e.recovery;
  return format(
             "live poses: %s m off in the end, %s m at worst; longest beyond %g m: %s s, beyond %g m while sure: %s "
             "s; ",
             number(r.end_error).c_str(), number(r.worst_error).c_str(), kRightPlace, number(r.longest_off).c_str(),
             kWrongPlace, number(r.longest_wrong).c_str()) +
         (r.back_after ? format("right %s s after the fault\n", number(*r.back_after).c_str())
                       : std::string("never right again\n"));
}

std::string formatTrajectory(const char* name, const TrajectoryScore& t) {
  const std::string line =
      format("%-11s ATE %.3f m over %zu poses (share %.3f of the true ones), height %.3f m off at worst; ", name, t.ate,
             t.pairs, t.share, t.height) +
      format("%s m and %s deg per 100 m (%zu stretches of %.0f m)\n", number(t.relative.translation).c_str(),
             number(t.relative.rotation_deg).c_str(), t.relative.count, t.relative.stretch);
  return t.share >= kWholeShare
             ? line
             : line + format("warning: %s only %.1f %% of the true poses are scored, the rest has no pose to compare\n",
                             name, 100 * t.share);
}

std::string formatTrajectories(const Evaluation& e) {
  if (!e.trajectory) {
    return "trajectory: not scored (--trajectory)\n";
  }
  const Pose& T = e.trajectory->T_truth_map;
  const double degrees = Eigen::AngleAxisd(T.linear()).angle() * 180.0 / std::numbers::pi;
  return formatTrajectory("trajectory:", *e.trajectory) +
         (e.odometry ? formatTrajectory("odometry:", *e.odometry) : "odometry: not scored (--log)\n") +
         format("the map was moved by %.3f %.3f %.3f m and turned by %.3f deg before matching\n", T.translation().x(),
                T.translation().y(), T.translation().z(), degrees);
}

std::string formatGeometry(const Evaluation& e) {
  if (!e.geometry) {
    return "geometry: not yet (the truth has no cloud.ply)\n";
  }
  const GeometryScore& g = *e.geometry;
  return format(
      "geometry: Chamfer %s m, map accuracy %s m, completeness %s m (%zu points against %zu)\n"
      "          covers %s of the reference along the path; %s of the leaves are too far from it and left out\n",
      number(g.chamfer).c_str(), number(g.accuracy).c_str(), number(g.completeness).c_str(), g.estimate_points,
      g.reference_points, number(g.coverage).c_str(), number(g.left_out).c_str());
}

std::string formatRetrieval(const Evaluation& e) {
  if (!e.retrieval) {
    return "retrieval: not yet (--answers, from hggmap query --batch)\n";
  }
  const RetrievalScore& r = *e.retrieval;
  return format("retrieval: R@1 %s, R@2 %s, R@3 %s over %zu queries (%zu targets in the map)\n",
                number(r.recallAt(1)).c_str(), number(r.recallAt(2)).c_str(), number(r.recallAt(3)).c_str(), r.queries,
                r.mapped);
}

std::string formatLoops(const Evaluation& e) {
  if (!e.loops) {
    return "loops: not scored (--trajectory, and a stats.json that tells of them)\n";
  }
  const LoopScore& l = *e.loops;
  const std::string worst = l.checked == 0 ? "" : format(", worst %.3f m and %.3f deg", l.worst, l.worst_deg);
  return format("loops: %zu asked, %zu accepted, %zu of %zu checked are false", l.asked, l.accepted, l.wrong,
                l.checked) +
         worst +
         format("; %zu true revisits, %zu asked about, %zu closed\n", l.revisits, l.revisits_asked, l.revisits_closed);
}

std::string formatRooms(const Evaluation& e) {
  if (!e.rooms) {
    return "";
  }
  const RoomScore& r = *e.rooms;
  const auto names = [](const char* what, const std::vector<std::string>& rooms) {
    std::string text = rooms.empty() ? "" : what;
    for (const std::string& room : rooms) {
      text += (&room == rooms.data() ? " " : ", ") + room;
    }
    return text;
  };
  return format(
             "rooms: %zu things of %zu rooms are in %zu regions, %zu rooms are one region each; normalised mutual "
             "information %.3f",
             r.things, r.rooms, r.regions, r.alike, r.mutual_information) +
         names("; cut:", r.cut) + names("; joined:", r.joined) + "\n";
}

std::string formatShares(const char* name, const WalkShares& s) {
  return format("  %-34s %8s %8s %8s\n", name, number(100 * s.blocked_called_walkable).c_str(),
                number(s.precision).c_str(), number(s.recall).c_str());
}

std::string formatGrid(const Evaluation& e) {
  if (!e.grid) {
    return "grid: not scored (--grid, from hggmap export --format grid)\n";
  }
  const WalkScore& w = e.grid->whole;
  std::string text = format("grid: %zu truly blocked and %zu truly free cells that a beam touched\n", w.blocked_touched,
                            w.confusion[0][0] + w.confusion[0][1] + w.confusion[0][2]);
  text += format("  %-34s %8s %8s %8s\n", "truly", "walkable", "blocked", "unknown");
  for (const std::size_t row : {std::size_t{0}, std::size_t{1}}) {
    text += format("  %-34s %8zu %8zu %8zu\n", row == 0 ? "free" : "blocked", w.confusion[row][0], w.confusion[row][1],
                   w.confusion[row][2]);
  }
  text +=
      format("  the map's walkable cells: %zu free, %zu blocked, %zu near a limit, %zu islands, %zu nothing there\n",
             w.free, w.blocked, w.close, w.islands, w.nothing);
  for (const auto& [cause, cells] : w.causes) {
    text += format("  blocked by %-23s %8zu of %zu called walkable\n", e.grid->names.at(cause).c_str(), cells.walkable,
                   cells.cells);
  }
  text += format("  %-34s %8s %8s %8s\n", "", "blocked %", "precision", "recall");
  text += formatShares("cell for cell", w.strict) + formatShares("one cell off allowed", w.tolerant);
  return e.grid->local ? text + formatShares("laid by the nearest pose", e.grid->local->strict) +
                             formatShares("the same, one cell off allowed", e.grid->local->tolerant)
                       : text;
}

std::string formatPlans(const Evaluation& e) {
  if (!e.plans) {
    return "";
  }
  const PlanScore& p = *e.plans;
  return format(
      "plans: %zu of %zu found; %zu over blocked ground, %zu off the ground; length %s of the shortest on average, %s "
      "at worst, %zu beyond %g\n",
      p.found, p.asked, p.through_blocked, p.off_ground, number(p.mean_ratio).c_str(), number(p.worst_ratio).c_str(),
      p.longer, kLongest);
}

double value(const json& object, const char* key) {
  return object.is_object() && object.contains(key) && object[key].is_number() ? object[key].get<double>() : NAN;
}

std::string formatTimes(const std::string& name, const json& ms) {
  return format("  %-14s %8s %8s %8s\n", name.c_str(), number(value(ms, "p50")).c_str(),
                number(value(ms, "p99")).c_str(), number(value(ms, "max")).c_str());
}

std::string formatCost(const json& cost) {
  if (!cost.is_object()) {
    return "cost: not scored (--stats)\n";
  }
  std::string text = format("cost in ms:      %8s %8s %8s\n", "median", "99 %", "max");
  const json stages = cost.value("stage_ms", json::object());
  for (const auto& [name, ms] : stages.items()) {
    text += formatTimes(name, ms);
  }
  return text + formatTimes("whole frame", cost.value("frame_ms", json())) +
         format("memory: map %s MB, process %s MB at most\n", number(value(cost, "map_mb")).c_str(),
                number(value(cost, "peak_rss_mb")).c_str());
}

json toJson(const std::vector<ObjectMatch>& matches) {
  json list = json::array();
  for (const ObjectMatch& m : matches) {
    list.push_back({{"id", m.prediction},
                    {"truth", m.truth},
                    {"distance", m.distance},
                    {"extent_error", m.extent_error},
                    {"normalised_square", m.normalised_square}});
  }
  return list;
}

json causesOf(const std::vector<Ghost>& ghosts) {
  json list = json::array();
  for (const Ghost& g : ghosts) {
    list.push_back({{"id", g.prediction}, {"cause", nameOf(g.cause)}, {"of", g.of == 0 ? json() : json(g.of)}});
  }
  return list;
}

json toJson(const std::vector<Twins>& twins) {
  json list = json::array();
  for (const Twins& t : twins) {
    list.push_back({{"ids", {t.a, t.b}}, {"truth", t.truth}, {"distance", t.distance}});
  }
  return list;
}

json toJson(const MovingScore& m) {
  return {{"truth", m.truth},
          {"said", m.said},
          {"soon", m.soon ? json(*m.soon) : json()},
          {"parked", m.parked},
          {"elsewhere", m.elsewhere}};
}

json toJson(const Spread& s) { return {{"mean", s.mean}, {"median", s.median}, {"max", s.max}}; }

json toJson(const Calibration& c) {
  return {{"count", c.count},         {"mean_over_3", c.mean_over_3}, {"median_over_3", c.median_over_3},
          {"inside_90", c.inside_90}, {"inside", c.inside},           {"mean_sigma", c.mean_sigma}};
}

json toJson(const RecoveryScore& r) {
  return {{"end_error", r.end_error},
          {"worst_error", r.worst_error},
          {"longest_off_s", r.longest_off},
          {"longest_wrong_s", r.longest_wrong},
          {"said_after_s", r.said_after ? json(*r.said_after) : json()},
          {"back_after_s", r.back_after ? json(*r.back_after) : json()}};
}

json toJson(const ObjectScore& s) {
  return {{"truth", s.truth},
          {"predicted", s.predicted},
          {"true_positives", s.matches.size()},
          {"precision", s.precision()},
          {"recall", s.recall()},
          {"f1", s.f1()},
          {"position_error", toJson(s.positionError())},
          {"extent_error", toJson(s.extentError())},
          {"calibration", toJson(s.calibration())},
          {"calibration_by_points", toJson(s.calibrationByPoints())},
          {"matches", toJson(s.matches)},
          {"missed", s.missed},
          {"ghosts", s.ghosts}};
}

json toJson(const Pose& T) {
  json rows = json::array();
  for (int i = 0; i < 12; ++i) {
    rows.push_back(T.matrix()(i / 4, i % 4));
  }
  return rows;
}

json toJson(const TrajectoryScore& t) {
  return {{"pairs", t.pairs},
          {"share", t.share},
          {"ate_rmse", t.ate},
          {"height_worst", t.height},
          {"T_truth_map", toJson(t.T_truth_map)},
          {"relative",
           {{"stretch_m", t.relative.stretch},
            {"stretches", t.relative.count},
            {"translation_m_per_100m", t.relative.translation},
            {"rotation_deg_per_100m", t.relative.rotation_deg}}}};
}

json toJson(const GeometryScore& g) {
  return {{"chamfer", g.chamfer},
          {"accuracy", g.accuracy},
          {"completeness", g.completeness},
          {"estimate_points", g.estimate_points},
          {"reference_points", g.reference_points},
          {"left_out", g.left_out},
          {"coverage", g.coverage},
          {"T_reference_estimate", toJson(g.T_reference_estimate)}};
}

json toJson(const LoopScore& l) {
  return {{"asked", l.asked},
          {"accepted", l.accepted},
          {"checked", l.checked},
          {"false", l.wrong},
          {"worst_m", l.worst},
          {"worst_deg", l.worst_deg},
          {"revisits", l.revisits},
          {"revisits_asked", l.revisits_asked},
          {"revisits_closed", l.revisits_closed}};
}

json toJson(const RoomScore& r) {
  return {{"things", r.things},
          {"rooms", r.rooms},
          {"regions", r.regions},
          {"alike", r.alike},
          {"normalised_mutual_information", r.mutual_information},
          {"cut", r.cut},
          {"joined", r.joined}};
}

json toJson(const RetrievalScore& r) {
  return {{"queries", r.queries},
          {"mapped", r.mapped},
          {"r1", r.recallAt(1)},
          {"r2", r.recallAt(2)},
          {"r3", r.recallAt(3)}};
}

json toJson(const WalkShares& s) {
  return {{"blocked_called_walkable", s.blocked_called_walkable}, {"precision", s.precision}, {"recall", s.recall}};
}

json toJson(const WalkScore& w) {
  const auto row = [&](std::size_t i) {
    return json{{"walkable", w.confusion[i][0]}, {"blocked", w.confusion[i][1]}, {"unknown", w.confusion[i][2]}};
  };
  return {
      {"free", row(0)},
      {"blocked", row(1)},
      {"walkable",
       {{"free", w.free}, {"blocked", w.blocked}, {"close", w.close}, {"islands", w.islands}, {"nothing", w.nothing}}},
      {"strict", toJson(w.strict)},
      {"tolerant", toJson(w.tolerant)}};
}

json toJson(const GridScore& g) {
  json score = toJson(g.whole);
  score["local"] = g.local ? toJson(*g.local) : json();
  score["causes"] = json::array();
  for (const auto& [cause, cells] : g.whole.causes) {
    score["causes"].push_back({{"name", g.names.at(cause)}, {"cells", cells.cells}, {"walkable", cells.walkable}});
  }
  return score;
}

json toJson(const PlanScore& p) {
  const double share = p.asked > 0 ? static_cast<double>(p.found) / static_cast<double>(p.asked) : NAN;
  return {{"asked", p.asked},
          {"found", p.found},
          {"share", share},
          {"through_blocked", p.through_blocked},
          {"off_ground", p.off_ground},
          {"longer", p.longer},
          {"mean_ratio", p.mean_ratio},
          {"worst_ratio", p.worst_ratio}};
}

template <typename Score>
json toJson(const std::optional<Score>& score) {
  return score ? toJson(*score) : json();
}

}  // namespace

std::string className(const Evaluation& evaluation, ClassId label) {
  const auto name = evaluation.class_names.find(label);
  return name == evaluation.class_names.end() ? "class " + std::to_string(label) : name->second;
}

std::string formatTable(const Evaluation& evaluation) {
  return formatObjects(evaluation) + formatGhosts(evaluation) +
         formatCalibration("calibration", evaluation.objects.overall.calibration(), "objects") +
         (evaluation.neighbours ? formatCalibration("neighbours", *evaluation.neighbours, "pairs") : "") +
         formatTrajectories(evaluation) + formatRecovery(evaluation) + formatGeometry(evaluation) +
         formatRetrieval(evaluation) + formatLoops(evaluation) + formatRooms(evaluation) + formatGrid(evaluation) +
         formatPlans(evaluation) + formatCost(evaluation.cost);
}

json toJson(const Evaluation& evaluation) {
  json classes = json::array();
  for (const auto& [label, score] : evaluation.objects.classes) {
    json entry = toJson(score);
    entry["label"] = label;
    entry["name"] = className(evaluation, label);
    classes.push_back(std::move(entry));
  }
  json overall = toJson(evaluation.objects.overall);
  overall["set_aside"] = evaluation.objects.dynamic.size();
  overall["twins"] = evaluation.twins.size();
  for (const GhostCause cause : kGhostCauses) {
    overall["ghost_causes"][nameOf(cause)] = countOf(evaluation, cause);
  }
  return {{"radius", evaluation.radius},
          {"classes", std::move(classes)},
          {"overall", std::move(overall)},
          {"dynamic", toJson(evaluation.objects.dynamic)},
          {"ghosts", causesOf(evaluation.ghosts)},
          {"twins", toJson(evaluation.twins)},
          {"moving", toJson(evaluation.moving)},
          {"trajectory", toJson(evaluation.trajectory)},
          {"positions",
           {{"from_start", toJson(evaluation.objects.overall.calibration())},
            {"neighbours", toJson(evaluation.neighbours)}}},
          {"recovery", toJson(evaluation.recovery)},
          {"odometry", toJson(evaluation.odometry)},
          {"geometry", toJson(evaluation.geometry)},
          {"retrieval", toJson(evaluation.retrieval)},
          {"loops", toJson(evaluation.loops)},
          {"rooms", toJson(evaluation.rooms)},
          {"grid", toJson(evaluation.grid)},
          {"plans", toJson(evaluation.plans)},
          {"cost", evaluation.cost}};
}

}  // namespace hgg
