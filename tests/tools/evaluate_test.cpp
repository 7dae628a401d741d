#include "eval/evaluate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "eval/report.h"
#include "map/file.h"
#include "tools/scratch.h"
#include "truth/poses.h"

namespace hgg {
namespace {

const char* const kGraph = R"({"format":"hgg-graph","version":1,"classes":{"10":"car","40":"road"},"objects":[
{"id":1,"label":10,"name":"car","mean":[1,2,3],"cov":[1,0,0,0,2,0,0,0,3],"kappa":50},
{"id":2,"label":40,"name":"road","mean":[0,0,0],"cov":[1,0,0,0,1,0,0,0,1],"kappa":9,"stuff":true}],"edges":[]})";

std::vector<TruthObject> oneCar(const Vec3& at) { return {{1000001, 10, false, 3, {at, Mat3::Identity(), 120}}}; }

TEST(ReadGraphJson, ReadsObjectsAndClasses) {
  const Scratch scratch;
  writeText(scratch / "g.json", kGraph);
  const auto graph = readGraphJson(scratch / "g.json");
  ASSERT_TRUE(graph) << graph.error;
  ASSERT_EQ(graph->objects.size(), 2u);
  EXPECT_EQ(graph->objects[0].belief.mean, Vec3(1, 2, 3));
  EXPECT_EQ(graph->objects[0].belief.cov(1, 1), 2.0);
  EXPECT_EQ(graph->objects[0].belief.kappa, 50.0);
  EXPECT_FALSE(graph->objects[0].stuff);
  EXPECT_TRUE(graph->objects[1].stuff);
  EXPECT_EQ(graph->class_names.at(10), "car");
}

TEST(ReadGraphJson, ForeignOrBrokenFilesAreErrors) {
  const Scratch scratch;
  for (const char* text :
       {"", "{", "[]", "{\"objects\":[]}", R"({"format":"hgg-graph","version":2,"objects":[]})",
        R"({"format":"hgg-graph","version":1})", R"({"format":"hgg-graph","version":1,"objects":[{"id":1}]})",
        R"({"format":"hgg-graph","version":1,"classes":{"car":"car"},"objects":[]})",
        R"({"format":"hgg-graph","version":"1","objects":[]})"}) {
    writeText(scratch / "g.json", text);
    const auto graph = readGraphJson(scratch / "g.json");
    EXPECT_FALSE(graph) << text;
    EXPECT_NE(graph.error.find("g.json"), std::string::npos) << graph.error;
  }
  EXPECT_FALSE(readGraphJson(scratch / "missing.json"));
}

TEST(ReadMapObjects, ReadsWhatTheMapperSaves) {
  const Scratch scratch;
  MapNode car;
  car.id = 4;
  car.label = 10;
  car.belief = {Vec3(1, 2, 3), Mat3::Identity(), 77};
  MapNode road = car;
  road.id = 5;
  road.label = 40;
  road.stuff = true;
  const Map map = Map::restore({car, road}, {}, {{10, "car"}, {40, "road"}}, 1);
  ASSERT_EQ(saveMap(map, {}, (scratch / "map.hgg").string()), "");
  const auto graph = readMapObjects(scratch / "map.hgg");
  ASSERT_TRUE(graph) << graph.error;
  ASSERT_EQ(graph->objects.size(), 2u);
  EXPECT_EQ(graph->objects[0].id, 4);
  EXPECT_EQ(graph->objects[0].belief.mean, Vec3(1, 2, 3));
  EXPECT_TRUE(graph->objects[1].stuff);
  EXPECT_EQ(graph->class_names.at(40), "road");
  EXPECT_FALSE(readMapObjects(scratch / "missing.hgg"));
}

TEST(ReadTruth, ComesBackAsWritten) {
  const Scratch scratch;
  auto objects = oneCar(Vec3(0.1, 1e-9, -3.25));
  objects.push_back({7, 80, true, 1, {Vec3(1, 1, 1), 0.5 * Mat3::Identity(), 3}});
  objects[0].belief.cov(0, 1) = objects[0].belief.cov(1, 0) = 1.0 / 3.0;
  ASSERT_EQ(writeTruth(objects, {Pose::Identity()}, scratch / "truth"), "");
  const auto read = readTruthObjects(scratch / "truth/gt_objects.json");
  ASSERT_TRUE(read) << read.error;
  ASSERT_EQ(read->size(), 2u);
  EXPECT_EQ((*read)[0].belief.mean, objects[0].belief.mean);
  EXPECT_EQ((*read)[0].belief.cov, objects[0].belief.cov);
  EXPECT_EQ((*read)[1].belief.kappa, 3.0);
  EXPECT_TRUE((*read)[1].dynamic);
  writeText(scratch / "truth/gt_objects.json", "[{\"id\":1}]");
  EXPECT_FALSE(readTruthObjects(scratch / "truth/gt_objects.json"));
}

TEST(Evaluate, MapIsLaidOverTheTruthByTheTrajectory) {
  const Scratch scratch;
  // The truth's world is the map's, turned by 90 degrees about z and shifted by (5, 0, 0).
  writeText(scratch / "g.json", kGraph);
  ASSERT_EQ(writeTruth(oneCar(Vec3(3, 1, 3)), {}, scratch / "truth"), "");
  writeText(scratch / "truth/poses.txt", "0 -1 0 5 1 0 0 0 0 0 1 0\n0 -1 0 5 1 0 0 2 0 0 1 0\n");
  writeText(scratch / "t.tum", "0.0 0 0 0 0 0 0 1\n0.1 2 0 0 0 0 0 1\n");
  EvalOptions options;
  options.graph = scratch / "g.json";
  options.truth = scratch / "truth";
  EXPECT_EQ(evaluate(options)->objects.overall.recall(), 0.0);
  options.trajectory = scratch / "t.tum";
  const auto aligned = evaluate(options);
  ASSERT_TRUE(aligned) << aligned.error;
  EXPECT_EQ(aligned->objects.overall.recall(), 1.0);
  EXPECT_NEAR(aligned->objects.overall.meanError(), 0.0, 1e-12);
  ASSERT_TRUE(aligned->trajectory);
  EXPECT_NEAR(aligned->trajectory->ate, 0.0, 1e-12);
  EXPECT_EQ(aligned->trajectory->pairs, 2u);
}

TEST(Evaluate, TimesPairUnlikeCounts) {
  const Scratch scratch;
  writeText(scratch / "g.json", kGraph);
  ASSERT_EQ(writeTruth(oneCar(Vec3(1, 2, 3)), std::vector<Pose>(3, Pose::Identity()), scratch / "truth"), "");
  writeText(scratch / "t.tum", "1317042145.964000 0 0 0 0 0 0 1\n1317042146.074000 0 0 0 0 0 0 1\n");
  writeText(scratch / "times.txt", "1317042145.964\n1317042146.074\n1317042146.174\n");
  EvalOptions options;
  options.graph = scratch / "g.json";
  options.truth = scratch / "truth";
  options.trajectory = scratch / "t.tum";
  EXPECT_FALSE(evaluate(options));
  options.times = scratch / "times.txt";
  const auto evaluation = evaluate(options);
  ASSERT_TRUE(evaluation) << evaluation.error;
  EXPECT_EQ(evaluation->trajectory->pairs, 2u);
}

TEST(Evaluate, ClassesAreChosenByNameOrId) {
  const Scratch scratch;
  writeText(scratch / "g.json", kGraph);
  ASSERT_EQ(writeTruth(oneCar(Vec3(1, 2, 3)), {}, scratch / "truth"), "");
  EvalOptions options;
  options.graph = scratch / "g.json";
  options.truth = scratch / "truth";
  options.classes = {"car"};
  EXPECT_EQ(evaluate(options)->objects.overall.truth, 1u);
  options.classes = {"80"};
  EXPECT_EQ(evaluate(options)->objects.overall.truth, 0u);
  options.classes = {"unicorn"};
  const auto unknown = evaluate(options);
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.error.find("unicorn"), std::string::npos);
}

TEST(Report, JsonHoldsTheNumbersAndNullsForNone) {
  Evaluation evaluation{1.5, {{10, "car"}}, {}, {}};
  ObjectScore cars{2, 1, {{7, 1, 0.25}}, {2}, {}};
  evaluation.objects.classes[10] = evaluation.objects.overall = cars;
  evaluation.objects.classes[80] = {1, 0, {}, {9}, {}};
  evaluation.trajectory = TrajectoryScore{108, 0.14, Pose::Identity()};
  const auto json = nlohmann::json::parse(toJson(evaluation).dump());
  EXPECT_EQ(json["overall"]["truth"], 2);
  EXPECT_EQ(json["overall"]["true_positives"], 1);
  EXPECT_EQ(json["overall"]["recall"], 0.5);
  EXPECT_EQ(json["overall"]["position_error"]["mean"], 0.25);
  EXPECT_EQ(json["classes"][0]["name"], "car");
  EXPECT_TRUE(json["classes"][1]["precision"].is_null());
  EXPECT_EQ(json["trajectory"]["ate_rmse"], 0.14);
  EXPECT_EQ(json["trajectory"]["T_truth_map"].size(), 12u);
  const std::string table = formatTable(evaluation);
  EXPECT_NE(table.find("class 80"), std::string::npos);
  EXPECT_NE(table.find("ATE 0.140 m over 108 poses"), std::string::npos);
}

}  // namespace
}  // namespace hgg
