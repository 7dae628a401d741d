#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <regex>

#include "eval/html.h"

namespace hgg::html_report_test {
namespace {

MappedObject predictionAt(NodeId id, const Vec3& mean) {
  return {id, 10, false, {mean, Mat3::Identity(), 50}, 0.01 * Mat3::Identity(), {}};
}

TruthObject truthAt(std::int64_t id, const Vec3& mean, bool dynamic = false) {
  return {id, 10, dynamic, false, 3, {mean, Mat3::Identity(), 120}};
}

/// Found: node 11 for object 1; missed: 2; ghost: 12; moving: object 3.
Evaluation smallEvaluation() {
  Evaluation e;
  e.radius = 1;
  e.class_names = {{10, "car </script>"}};
  e.scenery.truth = {truthAt(1, Vec3(0, 0, 0)), truthAt(2, Vec3(9, 0, 0)), truthAt(3, Vec3(20, 0, 0), true)};
  e.scenery.predictions = {predictionAt(11, Vec3(0.1, 0, 0)), predictionAt(12, Vec3(5, 5, 0))};
  e.objects = evaluateObjects(e.scenery.predictions, e.scenery.truth, e.radius, {});
  e.ghosts = {{12, GhostCause::kMover, 3}};
  e.twins = {{11, 12, 1, 0.25}};
  Path path;
  for (int i = 0; i < 5000; ++i) {
    PosePair pair;
    pair.T_truth_body.translation().x() = 0.1 * i;
    pair.T_map_body.translation().x() = 0.1 * i;
    path.pairs.push_back(pair);
  }
  e.scenery.corrected = path;
  e.trajectory = TrajectoryScore{5000, 0.0, Pose::Identity(), relativeError(path.pairs)};
  e.cost = nlohmann::json::parse(R"({"frames":3,"frame_ms":{"p50":1,"p99":2},"stage_ms":{"creation":{"p50":1,"p99":2}},
    "map_mb":1.5,"peak_rss_mb":20,"memory":[{"frame":1,"map_mb":1,"rss_mb":20}],"time":[{"frame":1,"mean_ms":1,"max_ms":2}]})");
  return e;
}

/// The data the page draws from.
nlohmann::json dataOf(const std::string& page) {
  const std::string start = "<script id=\"data\" type=\"application/json\">";
  const auto from = page.find(start) + start.size();
  return nlohmann::json::parse(page.substr(from, page.find("</script>", from) - from));
}

nlohmann::json find(const nlohmann::json& list, int id) {
  for (const auto& entry : list) {
    if (entry["id"] == id) {
      return entry;
    }
  }
  return {};
}

TEST(HtmlReport, IsOneFileThatAsksNothingOfTheNetwork) {
  const std::string page = htmlReport(smallEvaluation(), "yard");
  EXPECT_FALSE(std::regex_search(
      page, std::regex("https?:|//[a-z]+\\.[a-z]|@import|<link|src=|url\\(|fetch\\(|XMLHttp|import ")));
  EXPECT_EQ(page.rfind("<!DOCTYPE html>", 0), 0u);
  for (const char* placeholder : {"/*STYLE*/", "/*SCRIPT*/", "/*DATA*/"}) {
    EXPECT_EQ(page.find(placeholder), std::string::npos) << placeholder;
  }
}

TEST(HtmlReport, HoldsEveryPlotTheReaderIsPromised) {
  const std::string page = htmlReport(smallEvaluation(), "yard");
  for (const char* part : {"mapCard()", "classCard()", "calibrationCard()", "timeCard()", "memoryCards()",
                           "trajectoryCard()", "geometryCard()", "retrievalCard()", "data-theme=\"dark\""}) {
    EXPECT_NE(page.find(part), std::string::npos) << part;
  }
}

TEST(HtmlReport, ObjectsCarryWhatBecameOfThem) {
  const auto data = dataOf(htmlReport(smallEvaluation(), "yard"));
  EXPECT_EQ(data["title"], "yard");
  const auto& scenery = data["scenery"];
  EXPECT_EQ(find(scenery["truth"], 1)["state"], "found");
  EXPECT_EQ(find(scenery["truth"], 2)["state"], "missed");
  EXPECT_EQ(find(scenery["truth"], 3)["state"], "moving");
  EXPECT_EQ(find(scenery["predictions"], 11)["state"], "found");
  EXPECT_EQ(find(scenery["predictions"], 11)["truth"], 1);
  EXPECT_EQ(find(scenery["predictions"], 12)["state"], "ghost");
  EXPECT_EQ(find(scenery["predictions"], 12)["cause"], "mover");
  EXPECT_EQ(data["overall"]["ghost_causes"]["mover"], 1);
  EXPECT_EQ(data["overall"]["ghost_causes"]["second"], 0);
  EXPECT_EQ(data["overall"]["twins"], 1);
  EXPECT_EQ(data["twins"][0]["ids"], nlohmann::json::parse("[11,12]"));
  EXPECT_EQ(data["overall"]["missed"], nlohmann::json::parse("[2]"));
  EXPECT_EQ(data["cost"]["map_mb"], 1.5);
}

TEST(HtmlReport, LongPathsAreThinnedToTheirEnd) {
  const auto data = dataOf(htmlReport(smallEvaluation(), "yard"));
  const auto& path = data["scenery"]["paths"]["corrected"];
  EXPECT_LE(path.size(), 1502u);
  EXPECT_EQ(path.front()[0], 0.0);
  EXPECT_EQ(path.back()[0], 499.9);
  EXPECT_EQ(data["scenery"]["errors"]["corrected"].back()[0], 4999);
}

TEST(HtmlReport, NamesCannotBreakOutOfTheData) {
  const auto data = dataOf(htmlReport(smallEvaluation(), "a </script> title"));
  EXPECT_EQ(data["title"], "a </script> title");
  EXPECT_EQ(data["classes"][0]["name"], "car </script>");
}

TEST(HtmlReport, WallsStayFewHoweverLargeTheMap) {
  Evaluation e = smallEvaluation();
  MappedObject wall = predictionAt(13, Vec3::Zero());
  wall.stuff = true;
  for (int i = 0; i < 40'000; ++i) {
    wall.geometry.push_back({Vec3(i, 0, 0), Vec3(1, 0.0001, 1).asDiagonal(), 5});
  }
  wall.geometry.push_back({Vec3(0, 500, 0), Vec3(1, 1, 0.0001).asDiagonal(), 5});  // floor: not drawn
  e.scenery.predictions.push_back(wall);
  const auto data = dataOf(htmlReport(e, "yard"));
  const auto& walls = data["scenery"]["walls"]["xy"];
  EXPECT_GT(walls.size(), 1000u);
  EXPECT_LE(walls.size(), 18'000u);
  for (std::size_t i = 1; i < walls.size(); i += 2) {
    ASSERT_EQ(walls[i], 0);
  }
}

TEST(HtmlReport, ATitleThatIsNoTextIsMended) {
  EXPECT_EQ(dataOf(htmlReport(smallEvaluation(), "a \xff b"))["title"], "a \xef\xbf\xbd b");
}

TEST(HtmlReport, ShowsShareSharpnessAndCoverage) {
  const std::string page = htmlReport(smallEvaluation(), "yard");
  for (const char* part :
       {"percent(t.share)", "show(c.mean_sigma)", "percent(geometry.coverage)", "percent(geometry.left_out)"}) {
    EXPECT_NE(page.find(part), std::string::npos) << part;
  }
}

TEST(HtmlReport, OfNothingIsStillAPage) {
  const auto data = dataOf(htmlReport({}, "nothing"));
  EXPECT_TRUE(data["cost"].is_null());
  EXPECT_TRUE(data["scenery"]["truth"].empty());
}

}  // namespace
}  // namespace hgg::html_report_test
