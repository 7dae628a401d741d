#include "eval/evaluate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "bus/codec.h"
#include "bus/log.h"
#include "eval/report.h"
#include "map/file.h"
#include "tools/scratch.h"
#include "truth/cloud.h"
#include "truth/poses.h"

namespace hgg::evaluate_test {
namespace {

const char* const kGraph = R"({"format":"hgg-graph","version":1,"classes":{"10":"car","40":"road"},"objects":[
{"id":1,"label":10,"name":"car","mean":[1,2,3],"cov":[1,0,0,0,2,0,0,0,3],"kappa":50},
{"id":2,"label":40,"name":"road","mean":[0,0,0],"cov":[1,0,0,0,1,0,0,0,1],"kappa":9,"stuff":true}],"edges":[]})";

std::vector<TruthObject> oneCar(const Vec3& at) {
  return {{1000001, 10, false, false, 3, {at, Mat3::Identity(), 120}}};
}

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

/// A graph of these objects; each text is spliced into an otherwise fine one.
std::string graphOf(std::initializer_list<std::string> numbers) {
  std::string objects;
  for (const std::string& text : numbers) {
    objects += (objects.empty() ? "" : ",") + std::string(R"({"mean":[1,2,3],)") + text + "}";
  }
  return R"({"format":"hgg-graph","version":1,"objects":[)" + objects + "]}";
}

TEST(ReadGraphJson, AnIdThatAppearsTwiceIsAnError) {
  const Scratch scratch;
  const std::string car = R"("id":7,"label":10,"cov":[1,0,0,0,1,0,0,0,1],"kappa":5)";
  writeText(scratch / "g.json", graphOf({car, car}));
  const auto graph = readGraphJson(scratch / "g.json");
  ASSERT_FALSE(graph);
  EXPECT_NE(graph.error.find("object 7: this id appears twice"), std::string::npos) << graph.error;
}

TEST(ReadGraphJson, NumbersWithoutAMeaningAreErrorsThatNameTheObject) {
  const Scratch scratch;
  const std::string unit = R"("cov":[1,0,0,0,1,0,0,0,1])";
  const std::pair<std::string, std::string> cases[] = {
      {R"("id":7,"label":65546,"kappa":5,)" + unit, "label 65546"},
      {R"("id":7,"label":-1,"kappa":5,)" + unit, "label -1"},
      {R"("id":7,"label":10.5,"kappa":5,)" + unit, "label 10.5"},
      {R"("id":7,"label":10,"kappa":0,)" + unit, "kappa is 0"},
      {R"("id":7,"label":10,"kappa":-2,)" + unit, "kappa is -2"},
      {R"("id":7,"label":10,"kappa":5,"cov":[1,0.5,0,0,1,0,0,0,1])", "cov is not symmetric"},
      {R"("id":7,"label":10,"kappa":5,"cov":[1,2,0,2,1,0,0,0,1])", "cov has a negative eigenvalue"},
      {R"("id":7,"label":10,"kappa":5,"position_cov":[-1,0,0,0,-1,0,0,0,-1],)" + unit, "position_cov has a negative"},
      {R"("id":7,"label":10,"kappa":5,"geometry":[{"mean":[0,0,0],"cov":[1,0,0,0,1,0,0,0,-1],"kappa":5}],)" + unit,
       "cov has a negative"}};
  for (const auto& [text, problem] : cases) {
    writeText(scratch / "g.json", graphOf({text}));
    const auto graph = readGraphJson(scratch / "g.json");
    ASSERT_FALSE(graph) << text;
    EXPECT_NE(graph.error.find("object 7"), std::string::npos) << graph.error;
    EXPECT_NE(graph.error.find(problem), std::string::npos) << graph.error;
  }
  writeText(scratch / "g.json", graphOf({R"("id":7,"label":65535,"kappa":0.5,"cov":[0,0,0,0,0,0,0,0,0])"}));
  EXPECT_TRUE(readGraphJson(scratch / "g.json"));
}

TEST(ReadMapObjects, FlatLeavesSurviveTheirStorageAsFloats) {
  const Scratch scratch;
  MapNode road;
  road.id = 5;
  road.label = 40;
  road.belief = {Vec3(1, 2, 3), Mat3::Identity(), 77};
  Leaves leaves;
  for (int i = 1; i <= 200; ++i) {
    const Mat3 R = Eigen::AngleAxisd(0.1 * i, Vec3(1, 2, -3).normalized()).toRotationMatrix();
    leaves.push_back(packLeaf({Vec3::Zero(), R * Vec3(0, 0.1, 0.3).asDiagonal() * R.transpose(), 5}));
  }
  road.geometry = shareLeaves(std::move(leaves));
  ASSERT_EQ(saveMap(Map::restore({road}, {}, {{40, "road"}}, 1, 6), (scratch / "map.hgg").string()), "");
  const auto graph = readMapObjects(scratch / "map.hgg");
  EXPECT_TRUE(graph) << graph.error;
}

TEST(ReadGraphJson, CovariancesThatAreNotFiniteAreErrors) {
  const Scratch scratch;
  for (const char* text : {"null,0,0,0,1,0,0,0,1", "1e999,0,0,0,1,0,0,0,1", "1e308,0,0,0,1e308,0,0,0,1"}) {
    writeText(scratch / "g.json", graphOf({R"("id":7,"label":10,"kappa":5,"cov":[)" + std::string(text) + "]"}));
    EXPECT_FALSE(readGraphJson(scratch / "g.json")) << text;
  }
}

TEST(ReadGraphJson, AClassKeyThatIsNoLabelIsNamed) {
  const Scratch scratch;
  for (const std::string key : {"car", "70000", "-1", "10x", ""}) {
    writeText(scratch / "g.json",
              R"({"format":"hgg-graph","version":1,"classes":{")" + key + R"(":"car"},"objects":[]})");
    const auto graph = readGraphJson(scratch / "g.json");
    ASSERT_FALSE(graph) << key;
    EXPECT_NE(graph.error.find("class key \"" + key + "\" is not a whole number"), std::string::npos) << graph.error;
  }
}

TEST(ReadTruth, AnIdThatAppearsTwiceIsAnError) {
  const Scratch scratch;
  auto objects = oneCar(Vec3(0, 0, 0));
  objects.push_back(objects[0]);
  ASSERT_EQ(writeTruth(objects, {}, scratch / "truth"), "");
  const auto read = readTruthObjects(scratch / "truth/gt_objects.json");
  ASSERT_FALSE(read);
  EXPECT_NE(read.error.find("object 1000001: this id appears twice"), std::string::npos) << read.error;
}

TEST(Evaluate, AMapCannotHideGhostsAsStuff) {
  const Scratch scratch;
  const std::string numbers = R"("label":10,"cov":[1,0,0,0,1,0,0,0,1],"kappa":5,"stuff":true,)";
  writeText(scratch / "g.json", graphOf({numbers + R"("id":1)", numbers + R"("id":2)"}));
  ASSERT_EQ(writeTruth(oneCar(Vec3(1, 2, 3)), {}, scratch / "truth"), "");
  EvalOptions options;
  options.graph = scratch / "g.json";
  options.truth = scratch / "truth";
  EXPECT_EQ(evaluate(options)->objects.overall.precision(), 0.5);
}

TEST(ReadMapObjects, ReadsWhatTheMapperSaves) {
  const Scratch scratch;
  MapNode car;
  car.id = 4;
  car.label = 10;
  car.belief = {Vec3(1, 2, 3), Mat3::Identity(), 77};
  addViews(car.classes, {{10, 50.0F}});
  MapNode road = car;
  road.id = 5;
  road.label = 40;
  road.stuff = true;
  MapNode doubted = car;
  doubted.id = 6;
  doubted.classes = {{{10, 1.0F}, {40, 30.0F}}};
  const Map map = Map::restore({car, road, doubted}, {}, {{10, "car"}, {40, "road"}}, 1, 7);
  ASSERT_EQ(saveMap(map, (scratch / "map.hgg").string()), "");
  const auto graph = readMapObjects(scratch / "map.hgg");
  ASSERT_TRUE(graph) << graph.error;
  ASSERT_EQ(graph->objects.size(), 2u) << "the third is not confirmed";
  EXPECT_EQ(graph->objects[0].id, 4);
  EXPECT_EQ(graph->objects[0].belief.mean, Vec3(1, 2, 3));
  EXPECT_TRUE(graph->objects[1].stuff);
  EXPECT_EQ(graph->class_names.at(40), "road");
  EXPECT_FALSE(readMapObjects(scratch / "missing.hgg"));
}

TEST(TruthAccumulator, KeepsTheMiddleOfTheFramesPoints) {
  TruthAccumulator truth;
  truth.add(1, 10, 3, Vec3(0, 0, 0));
  truth.add(1, 10, 3, Vec3(2, 0, 1));
  truth.add(1, 10, 7, Vec3(5, 5, 5));
  const auto objects = truth.objects();
  ASSERT_EQ(objects.size(), 1u);
  EXPECT_EQ(objects[0].track, (std::vector<Vec3>{Vec3(1, 0, 0.5), Vec3(5, 5, 5)}));
  EXPECT_EQ(objects[0].track_points, (std::vector<std::int64_t>{2, 1}));
  EXPECT_EQ(objects[0].track_frames, (std::vector<std::int64_t>{3, 7}));
}

TEST(ReadTruth, ComesBackAsWritten) {
  const Scratch scratch;
  auto objects = oneCar(Vec3(0.1, 1e-9, -3.25));
  objects.push_back({7, 80, true, false, 1, {Vec3(1, 1, 1), 0.5 * Mat3::Identity(), 3}});
  objects[0].belief.cov(0, 1) = objects[0].belief.cov(1, 0) = 1.0 / 3.0;
  objects[0].track = objects[1].track = {Vec3(1, 0, 0), Vec3(1.5, -2, 0.25)};
  objects[1].track_points = {5, 70}, objects[1].track_frames = {3, 4};
  ASSERT_EQ(writeTruth(objects, {Pose::Identity()}, scratch / "truth"), "");
  const auto read = readTruthObjects(scratch / "truth/gt_objects.json");
  ASSERT_TRUE(read) << read.error;
  ASSERT_EQ(read->size(), 2u);
  EXPECT_EQ((*read)[0].belief.mean, objects[0].belief.mean);
  EXPECT_EQ((*read)[0].belief.cov, objects[0].belief.cov);
  EXPECT_EQ((*read)[1].belief.kappa, 3.0);
  EXPECT_TRUE((*read)[1].dynamic);
  EXPECT_TRUE((*read)[0].track.empty()) << "it stays";
  EXPECT_EQ((*read)[1].track, objects[1].track);
  EXPECT_EQ((*read)[1].track_points, objects[1].track_points);
  EXPECT_EQ((*read)[1].track_frames, objects[1].track_frames);
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
  EXPECT_NEAR(aligned->objects.overall.positionError().mean, 0.0, 1e-12);
  ASSERT_TRUE(aligned->trajectory);
  EXPECT_NEAR(aligned->trajectory->ate, 0.0, 1e-12);
  EXPECT_EQ(aligned->trajectory->pairs, 2u);
}

TEST(Evaluate, BeliefsAreHeldAgainstTheTruthFromTheFirstPoseOn) {
  const Scratch scratch;
  writeText(scratch / "g.json", kGraph);
  ASSERT_EQ(writeTruth(oneCar(Vec3(1, 2, 3)), {}, scratch / "truth"), "");
  writeText(scratch / "truth/poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 2 0 1 0 0 0 0 1 0\n");
  writeText(scratch / "t.tum", "0.0 0 0 0 0 0 0 1\n0.1 2.4 0 0 0 0 0 1\n");
  EvalOptions options;
  options.graph = scratch / "g.json";
  options.truth = scratch / "truth";
  options.trajectory = scratch / "t.tum";
  const auto evaluation = evaluate(options);
  ASSERT_TRUE(evaluation) << evaluation.error;
  EXPECT_NEAR(evaluation->objects.overall.positionError().mean, 0.2, 1e-9) << "after the best fit";
  EXPECT_NEAR(evaluation->objects.overall.calibration().mean_over_3, 0.0, 1e-9);
  EXPECT_FALSE(evaluation->neighbours) << "a graph JSON does not tell how its objects drifted together";
}

TEST(Evaluate, NeighboursOfAMapAreHeldAgainstEachOther) {
  const Scratch scratch;
  MapNode car;
  car.id = 4;
  car.label = 10;
  car.belief = {Vec3(1, 2, 3), Mat3::Identity(), 77};
  addViews(car.classes, {{10, 50.0F}});
  MapNode other = car;
  other.id = 5;
  other.belief.mean.x() += 10;
  ASSERT_EQ(saveMap(Map::restore({car, other}, {}, {{10, "car"}}, 1, 6), (scratch / "map.hgg").string()), "");
  auto truth = oneCar(car.belief.mean);
  truth.push_back(truth[0]);
  truth[1].id += 1;
  truth[1].belief.mean = other.belief.mean;
  ASSERT_EQ(writeTruth(truth, {}, scratch / "truth"), "");
  EvalOptions options;
  options.map = scratch / "map.hgg";
  options.truth = scratch / "truth";
  const auto evaluation = evaluate(options);
  ASSERT_TRUE(evaluation) << evaluation.error;
  ASSERT_TRUE(evaluation->neighbours);
  EXPECT_EQ(evaluation->neighbours->count, 1u);
  EXPECT_NEAR(evaluation->neighbours->mean_over_3, 0.0, 1e-9);
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

TEST(ReadGraphJson, ReadsPublishedCovarianceAndGeometry) {
  const Scratch scratch;
  writeText(scratch / "g.json", R"({"format":"hgg-graph","version":1,"objects":[
{"id":1,"label":10,"mean":[1,2,3],"cov":[1,0,0,0,2,0,0,0,3],"kappa":50,"position_cov":[4,0,0,0,5,0,0,0,6],
 "geometry":[{"mean":[1,1,1],"cov":[9,0,0,0,8,0,0,0,7],"kappa":5}]},
{"id":2,"label":10,"mean":[1,2,3],"cov":[1,0,0,0,2,0,0,0,3],"kappa":50}]})");
  const auto graph = readGraphJson(scratch / "g.json");
  ASSERT_TRUE(graph) << graph.error;
  EXPECT_EQ(graph->objects[0].position_cov(1, 1), 5.0);
  ASSERT_EQ(graph->objects[0].geometry.size(), 1u);
  EXPECT_EQ(graph->objects[0].geometry[0].cov(2, 2), 7.0);
  EXPECT_EQ(graph->objects[1].position_cov(1, 1), 2.0 / 50);  // cov / kappa
}

TEST(TransformPrediction, TurnsCovarianceAndGeometryAlong) {
  MappedObject object{1, 10, false, {Vec3(1, 0, 0), Vec3(4, 1, 1).asDiagonal(), 9}, Vec3(0.4, 0.1, 0.1).asDiagonal(),
                      {}};
  object.geometry = {{Vec3(2, 0, 0), Vec3(1, 0, 0).asDiagonal(), 5}};
  Pose T = Pose::Identity();
  T.rotate(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitZ()));
  T.pretranslate(Vec3(0, 0, 1));
  const MappedObject turned = transform(T, object);
  EXPECT_TRUE(turned.belief.mean.isApprox(Vec3(0, 1, 1)));
  EXPECT_NEAR(turned.position_cov(1, 1), 0.4, 1e-12);
  EXPECT_TRUE(turned.geometry[0].mean.isApprox(Vec3(0, 2, 1)));
  EXPECT_NEAR(turned.geometry[0].cov(1, 1), 1.0, 1e-12);
}

/// A drive of 5 frames along x at 1 m/s, logged with odometry that runs 10 % too fast, and its truth.
struct LoggedDrive {
  explicit LoggedDrive(const Scratch& scratch) {
    options.graph = scratch / "g.json";
    options.truth = scratch / "truth";
    options.trajectory = scratch / "t.tum";
    options.log = scratch / "d.lcm";
    writeText(options.graph, kGraph);
    auto log = LogWriter::create(options.log.string());
    std::vector<Pose> poses;
    std::string tum;
    for (int i = 0; i < 5; ++i) {
      const Micros t_us = 100'000 * (i + 1);
      Pose T = Pose::Identity();
      T.translation().x() = 1.1 * i;
      EXPECT_EQ(log->write("POSE_ODOM", t_us, encodePose(t_us, T)), "");
      EXPECT_EQ(log->write("LIDAR_SEMANTIC", t_us, {}), "");
      T.translation().x() = i;
      poses.push_back(T);
      if (i != 2) {  // a frame the mapper dropped
        tum += std::to_string(0.1 * (i + 1)) + " " + std::to_string(i) + " 0 0 0 0 0 1\n";
      }
    }
    EXPECT_EQ(log->close(), "");
    EXPECT_EQ(writeTruth(oneCar(Vec3(1, 2, 3)), poses, options.truth), "");
    writeText(options.trajectory, tum);
  }
  EvalOptions options;
};

TEST(Evaluate, OdometryOfTheLogIsScoredBesideTheCorrectedPath) {
  const Scratch scratch;
  const LoggedDrive drive(scratch);
  const auto e = evaluate(drive.options);
  ASSERT_TRUE(e) << e.error;
  EXPECT_EQ(e->trajectory->share, 0.8);
  EXPECT_EQ(e->odometry->share, 0.8);
  EXPECT_EQ(e->trajectory->pairs, 4u);  // paired by the log's times, as one frame is missing
  EXPECT_NEAR(e->trajectory->ate, 0.0, 1e-6);
  ASSERT_TRUE(e->odometry);
  // Positions 0, 1, 3, 4 estimated as 0, 1.1, 3.3, 4.4: residuals 0.1 times 2, 1, 1, 2 about the middle.
  EXPECT_NEAR(e->odometry->ate, 0.1 * std::sqrt((4 + 1 + 1 + 4) / 4.0), 1e-6);
  EXPECT_NEAR(e->odometry->relative.translation, 10.0, 1e-6);
}

TEST(Evaluate, LogOfAnotherDriveIsAnError) {
  const Scratch scratch;
  LoggedDrive drive(scratch);
  writeText(drive.options.trajectory,
            "7.0 0 0 0 0 0 0 1\n7.1 1 0 0 0 0 0 1\n7.2 1 0 0 0 0 0 1\n7.3 1 0 0 0 0 0 1\n7.4 1 0 0 0 0 0 1\n");
  EXPECT_FALSE(evaluate(drive.options));
  LoggedDrive silent(scratch);
  silent.options.odometry_channel = "ODOMETRY";
  const auto e = evaluate(silent.options);
  ASSERT_FALSE(e);
  EXPECT_NE(e.error.find("ODOMETRY"), std::string::npos) << e.error;
}

/// A graph with one leaf of a floor and one of vegetation 1 m above it.
const char* const kFloorGraph =
    R"({"format":"hgg-graph","version":1,"classes":{"40":"road","70":"vegetation"},"objects":[
{"id":1,"label":40,"mean":[0,0,0],"cov":[1,0,0,0,1,0,0,0,0],"kappa":9,"stuff":true,
 "geometry":[{"mean":[0,0,0],"cov":[0.33333333,0,0,0,0.33333333,0,0,0,0],"kappa":9}]},
{"id":2,"label":70,"mean":[0,0,1],"cov":[1,0,0,0,1,0,0,0,0],"kappa":9,"stuff":true,
 "geometry":[{"mean":[0,0,1],"cov":[0.33333333,0,0,0,0.33333333,0,0,0,0],"kappa":9}]}]})";

/// The floor of kFloorGraph, 2 x 2 m, with leaves 1.5 m above it.
std::vector<CloudPoint> floorUnderLeaves() {
  std::vector<CloudPoint> cloud;
  for (int i = 0; i <= 40; ++i) {
    for (int j = 0; j <= 40; ++j) {
      const auto x = static_cast<float>(0.05 * i - 1), y = static_cast<float>(0.05 * j - 1);
      cloud.push_back({x, y, 0, 40, 1});
      cloud.push_back({x, y, 1.5F, 70, 2});
    }
  }
  return cloud;
}

TEST(Evaluate, TheTruthSaysWhatIsVegetation) {
  const Scratch scratch;
  EvalOptions options;
  options.graph = scratch / "g.json";
  options.truth = scratch / "truth";
  std::string boastful = kFloorGraph;  // of its leaves, it calls the wrong ones vegetation
  boastful.replace(boastful.find("vegetation"), 10, "road");
  boastful.replace(boastful.find("road"), 4, "vegetation");
  writeText(options.graph, boastful);
  ASSERT_EQ(writeTruth(oneCar(Vec3(0, 0, 0)), {Pose::Identity()}, options.truth), "");
  ASSERT_EQ(writeCloud(floorUnderLeaves(), options.truth / "cloud.ply"), "");
  const auto believed = evaluate(options);
  EXPECT_NEAR(believed->geometry->T_reference_estimate.translation().z(), 0.5, 0.01);  // leaves laid over leaves
  writeText(options.truth / "classes.toml",
            "[[class]]\nid = 40\nname = \"road\"\nkind = \"stuff\"\nmin_points = 30\n"
            "[[class]]\nid = 70\nname = \"vegetation\"\nkind = \"stuff\"\nmin_points = 30\n");
  const auto e = evaluate(options);
  ASSERT_TRUE(e) << e.error;
  EXPECT_NEAR(e->geometry->T_reference_estimate.translation().z(), 0.0, 0.01);
  writeText(options.truth / "classes.toml", "no table");
  EXPECT_NE(evaluate(options).error.find("classes.toml"), std::string::npos);
}

TEST(Evaluate, SurfaceLeftOutShowsInTheCoverage) {
  const Scratch scratch;
  EvalOptions options;
  options.graph = scratch / "g.json";
  options.truth = scratch / "truth";
  writeText(options.graph, graphOf({R"("id":1,"label":40,"kappa":9,"stuff":true,"cov":[1,0,0,0,1,0,0,0,0],"geometry":[
{"mean":[0,0,0],"cov":[0.3,0,0,0,0.3,0,0,0,0],"kappa":9},{"mean":[50,0,0],"cov":[0.3,0,0,0,0.3,0,0,0,0],"kappa":9}])"}));
  std::vector<CloudPoint> cloud = floorUnderLeaves();
  std::erase_if(cloud, [](const CloudPoint& p) { return p.label == 70; });
  for (const float away : {10.0F, 40.0F}) {  // the map has neither; the path does not come near the second
    std::vector<CloudPoint> more = floorUnderLeaves();
    std::erase_if(more, [](const CloudPoint& p) { return p.label == 70; });
    for (CloudPoint& p : more) {
      cloud.push_back({p.x + away, p.y, p.z, 40, 1});
    }
  }
  ASSERT_EQ(writeTruth(oneCar(Vec3(0, 0, 0)), {Pose::Identity()}, options.truth), "");
  ASSERT_EQ(writeCloud(cloud, options.truth / "cloud.ply"), "");
  const auto e = evaluate(options);
  ASSERT_TRUE(e) << e.error;
  EXPECT_EQ(e->geometry->left_out, 0.5);
  EXPECT_NEAR(e->geometry->coverage, 0.5, 0.05);
  const auto json = toJson(*e);
  EXPECT_EQ(json["geometry"]["left_out"], 0.5);
  EXPECT_EQ(json["geometry"]["coverage"], e->geometry->coverage);
  EXPECT_NE(formatTable(*e).find("of the reference along the path; 0.500 of the leaves"), std::string::npos);
}

TEST(Evaluate, GeometryLeavesVegetationOut) {
  const Scratch scratch;
  EvalOptions options;
  options.graph = scratch / "g.json";
  options.truth = scratch / "truth";
  options.spacing = 0.05;
  writeText(options.graph, kFloorGraph);
  ASSERT_EQ(writeTruth(oneCar(Vec3(0, 0, 0)), {Pose::Identity()}, options.truth), "");
  EXPECT_FALSE(evaluate(options)->geometry);
  ASSERT_EQ(writeCloud(floorUnderLeaves(), options.truth / "cloud.ply"), "");
  const auto e = evaluate(options);
  ASSERT_TRUE(e) << e.error;
  ASSERT_TRUE(e->geometry);
  EXPECT_LT(e->geometry->chamfer, 0.04);  // of points 0.05 m apart on one plane
  EXPECT_LE(e->geometry->reference_points, 41u * 41u);
  // Driven by 30 m away, the floor lies where a reference need not reach: nothing is left to compare.
  Pose far = Pose::Identity();
  far.translation().x() = 30;
  ASSERT_EQ(writePoses({far}, options.truth / "poses.txt"), "");
  EXPECT_EQ(evaluate(options)->geometry->estimate_points, 0u);
}

TEST(Evaluate, CostIsReadFromBesideTheMapAndRetrievalFromAnswers) {
  const Scratch scratch;
  MapNode car;
  car.id = 4;
  car.label = 10;
  car.belief = {Vec3(1, 2, 3), Mat3::Identity(), 77};
  addViews(car.classes, {{10, 50.0F}});
  ASSERT_EQ(saveMap(Map::restore({car}, {}, {{10, "car"}}, 1, 5), (scratch / "map.hgg").string()), "");
  ASSERT_EQ(writeTruth(oneCar(Vec3(1, 2, 3)), {}, scratch / "truth"), "");
  writeText(scratch / "truth/queries.jsonl", R"({"text":"the car","target":1000001,"class":"car"})"
                                             "\n");
  writeText(scratch / "stats.json", R"({"frames":3,"frame_ms":{"p50":1.5}})");
  writeText(scratch / "answers.jsonl", R"({"text":"the car","answers":[{"id":4}]})"
                                       "\n");
  EvalOptions options;
  options.map = scratch / "map.hgg";
  options.truth = scratch / "truth";
  EXPECT_FALSE(evaluate(options)->retrieval);
  options.answers = scratch / "answers.jsonl";
  const auto e = evaluate(options);
  ASSERT_TRUE(e) << e.error;
  EXPECT_EQ(e->cost["frames"], 3);
  EXPECT_EQ(e->retrieval->recallAt(1), 1.0);
  writeText(scratch / "stats.json", "{");
  EXPECT_NE(evaluate(options).error.find("stats.json"), std::string::npos);
}

TEST(Report, WhatIsNotScoredSaysNotYet) {
  Evaluation evaluation;
  evaluation.radius = 1;
  const std::string table = formatTable(evaluation);
  EXPECT_NE(table.find("retrieval: not yet"), std::string::npos) << table;
  EXPECT_NE(table.find("geometry: not yet"), std::string::npos) << table;
  const auto json = nlohmann::json::parse(toJson(evaluation).dump());
  for (const char* part : {"trajectory", "odometry", "geometry", "retrieval", "cost"}) {
    EXPECT_TRUE(json[part].is_null()) << part;
  }
}

TEST(Report, JsonHoldsTheNumbersAndNullsForNone) {
  Evaluation evaluation;
  evaluation.radius = 1.5;
  evaluation.class_names = {{10, "car"}};
  ObjectScore cars{2, 1, {{7, 1, 0.25, 0.5, 6.0, 0.04}}, {2}, {}};
  evaluation.objects.classes[10] = evaluation.objects.overall = cars;
  evaluation.objects.classes[80] = {1, 0, {}, {9}, {}};
  evaluation.trajectory = TrajectoryScore{108, 0.14, Pose::Identity(), {100, 5, 1.25, 0.5}, 0.9};
  evaluation.odometry = TrajectoryScore{108, 0.14, Pose::Identity(), {100, 5, 1.25, 0.5}, 0.95};
  evaluation.objects.dynamic = {{8, 3, 0.5, 0.5, 6.0, 0.01}, {9, 4, 0.5, 0.5, 6.0, 0.01}};
  const auto json = nlohmann::json::parse(toJson(evaluation).dump());
  EXPECT_EQ(json["overall"]["truth"], 2);
  EXPECT_EQ(json["overall"]["true_positives"], 1);
  EXPECT_EQ(json["overall"]["recall"], 0.5);
  EXPECT_EQ(json["overall"]["position_error"]["mean"], 0.25);
  EXPECT_EQ(json["overall"]["extent_error"]["max"], 0.5);
  EXPECT_EQ(json["overall"]["calibration"]["mean_over_3"], 2.0);
  EXPECT_EQ(json["positions"]["from_start"]["mean_over_3"], 2.0);
  EXPECT_TRUE(json["positions"]["neighbours"].is_null());
  EXPECT_EQ(json["trajectory"]["relative"]["translation_m_per_100m"], 1.25);
  EXPECT_EQ(json["classes"][0]["name"], "car");
  EXPECT_TRUE(json["classes"][1]["precision"].is_null());
  EXPECT_EQ(json["trajectory"]["ate_rmse"], 0.14);
  EXPECT_EQ(json["trajectory"]["T_truth_map"].size(), 12u);
  EXPECT_EQ(json["trajectory"]["share"], 0.9);
  EXPECT_EQ(json["odometry"]["share"], 0.95);
  EXPECT_EQ(json["overall"]["calibration"]["mean_sigma"], 0.2);
  EXPECT_EQ(json["classes"][0]["calibration"]["mean_sigma"], 0.2);
  EXPECT_EQ(json["overall"]["set_aside"], 2);
  const std::string table = formatTable(evaluation);
  EXPECT_NE(table.find("class 80"), std::string::npos);
  EXPECT_NE(table.find("ATE 0.140 m over 108 poses (share 0.900"), std::string::npos) << table;
  EXPECT_NE(table.find("warning: trajectory: only 90.0 % of the true poses"), std::string::npos) << table;
  EXPECT_EQ(table.find("warning: odometry"), std::string::npos) << table;
  EXPECT_NE(table.find("mean sigma 0.200 m"), std::string::npos) << table;
}

}  // namespace
}  // namespace hgg::evaluate_test
