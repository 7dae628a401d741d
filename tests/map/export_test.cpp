#include "map/export.h"

#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/spd.h"
#include "map/test_map.h"

namespace hgg::export_test {
namespace {

using Json = nlohmann::json;

StoredMap sample() {
  std::mt19937 random(1);
  MapNode car = nodeAt(10, Vec3(1, 2, 3), 0.5, 42);
  car.belief.cov = randomSpd(random, 1e-2);
  car.T_map_object.linear() = randomRotation(random);
  car.views = 7, car.first_us = 1111, car.last_us = 2222;
  for (int k = 0; k < 3; ++k) {
    addLeaf(car, packLeaf({randomVector(random, 1), randomSpd(random, 1e-3), 14}));
  }
  MapUpdate update;
  update.keyframe = NewKeyframe{};
  update.keyframe->pose.utime_us = 5;
  update.keyframe->pose.T_map_body.linear() = Eigen::AngleAxisd(M_PI / 2, Vec3::UnitZ()).toRotationMatrix();
  update.keyframe->pose.T_map_body.translation() = Vec3(7, 8, 9);
  update.created = {car, tileNode(40, {0, 0, 0}, Vec3(-4, 0, 0)), nodeAt(99, Vec3(0, 0, 0))};
  StoredMap stored;
  stored.map.setClassNames({{10, "car"}, {40, "road"}});
  stored.map.apply(std::move(update));
  stored.edges = {{1, 2, 0.5F}, {2, 3, 0.25F}};
  return stored;
}

std::vector<std::string> keysOf(const Json& j) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : j.items()) {
    keys.push_back(key);
  }
  return keys;
}

TEST(ExportJson, HasTheDocumentedKeysAndNoOthers) {
  const Json j = Json::parse(exportJson(sample()));
  EXPECT_EQ(keysOf(j), (std::vector<std::string>{"classes", "edges", "format", "keyframes", "objects", "region_edges",
                                                 "regions", "version"}));
  EXPECT_EQ(j["format"], "hgg-graph");
  EXPECT_EQ(j["version"], 1);
  EXPECT_EQ(keysOf(j["objects"][0]),
            (std::vector<std::string>{"anchor", "cov", "dynamic", "existence", "first_us", "geometry", "id", "kappa",
                                      "label", "label_belief", "last_us", "mean", "name", "position_cov",
                                      "position_cov_local", "stuff", "views"}));
  EXPECT_EQ(keysOf(j["objects"][0]["geometry"][0]), (std::vector<std::string>{"cov", "kappa", "mean"}));
  EXPECT_EQ(keysOf(j["keyframes"][0]), (std::vector<std::string>{"pose", "utime"}));
}

TEST(ExportJson, SaysWhereInTheMapAndWhereRelativeToTheAnchor) {
  StoredMap stored = sample();
  MapUpdate update;
  update.keyframe =
      NewKeyframe{{9, stored.map.keyframes().poses()[0].T_map_body}, {{0, -1, Pose::Identity(), 0.5, 0.1}}};
  update.created = {nodeAt(10, stored.map.keyframes().poses()[0].T_map_body.translation())};
  stored.map.apply(std::move(update));
  const Json j = Json::parse(exportJson(stored));
  const Json& car = j["objects"][3];
  EXPECT_EQ(car["anchor"], 1);
  EXPECT_NEAR(car["position_cov"][0].get<double>() - car["position_cov_local"][0].get<double>(), 0.25, 1e-12);
}

TEST(ExportJson, HasTheValuesOfTheMap) {
  const StoredMap stored = sample();
  const Json j = Json::parse(exportJson(stored));
  EXPECT_EQ(j["classes"], Json::parse(R"({"10": "car", "40": "road"})"));
  ASSERT_EQ(j["objects"].size(), 3U);
  const Json& car = j["objects"][0];
  EXPECT_EQ(car["id"], 1);
  EXPECT_EQ(car["label"], 10);
  EXPECT_EQ(car["name"], "car");
  EXPECT_EQ(car["mean"], Json::array({1.0, 2.0, 3.0}));
  EXPECT_EQ(car["kappa"], 42);
  EXPECT_EQ(car["views"], 7);
  EXPECT_EQ(car["first_us"], 1111);
  EXPECT_EQ(car["last_us"], 2222);
  EXPECT_EQ(car["label_belief"], Json::parse(R"({"10": 1.0})"));
  EXPECT_EQ(car["stuff"], false);
  EXPECT_EQ(car["dynamic"], false);
  EXPECT_EQ(car["existence"], existence(stored.map.find(1)->classes, 10, 42));
  ASSERT_EQ(car["cov"].size(), 9U);
  for (Eigen::Index k = 0; k < 9; ++k) {
    const double cov = stored.map.find(1)->belief.cov(k / 3, k % 3);
    EXPECT_DOUBLE_EQ(car["cov"][static_cast<std::size_t>(k)], cov);
    for (const char* name : {"position_cov", "position_cov_local"}) {  // the first keyframe has not drifted
      EXPECT_DOUBLE_EQ(car[name][static_cast<std::size_t>(k)], positionCovariance(*stored.map.find(1))(k / 3, k % 3));
    }
  }
  EXPECT_EQ(j["objects"][1]["stuff"], true);
  EXPECT_EQ(j["objects"][2]["name"], "class 99");  // outside the class table
  EXPECT_EQ(j["edges"], Json::parse("[[1, 2, 0.5], [2, 3, 0.25]]"));
  EXPECT_EQ(j["regions"], Json::array());
}

TEST(ExportJson, HasTheRegionsThatWereFound) {
  Regions regions;
  regions.regions = {{1, "car park", {Vec3(1, 2, 3), 4 * Mat3::Identity(), 50}, {1, 3}}, {2, "", {}, {2}}};
  regions.edges = {{1, 2, 0.5F}};
  const Json j = Json::parse(exportJson(sample(), regions));
  ASSERT_EQ(j["regions"].size(), 2U);
  EXPECT_EQ(keysOf(j["regions"][0]), (std::vector<std::string>{"cov", "id", "kappa", "mean", "name", "objects"}));
  EXPECT_EQ(j["regions"][0]["name"], "car park");
  EXPECT_EQ(j["regions"][0]["objects"], Json::parse("[1, 3]"));
  EXPECT_EQ(j["regions"][0]["cov"][4], 4);
  EXPECT_EQ(j["region_edges"], Json::parse("[[1, 2, 0.5]]"));
}

TEST(ExportJson, GeometryIsInTheMapFrame) {
  const StoredMap stored = sample();
  const Json j = Json::parse(exportJson(stored));
  const MapNode& car = *stored.map.find(1);
  ASSERT_EQ(j["objects"][0]["geometry"].size(), 3U);
  for (std::size_t k = 0; k < 3; ++k) {
    const Json& leaf = j["objects"][0]["geometry"][k];
    const Belief expected = transform(car.T_map_object, unpackLeaf(leavesOf(car)[k]));
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_DOUBLE_EQ(leaf["mean"][i], expected.mean[static_cast<Eigen::Index>(i)]);
    }
    EXPECT_DOUBLE_EQ(leaf["cov"][5], expected.cov(1, 2));
    EXPECT_EQ(leaf["kappa"], 14);
  }
}

TEST(ExportJson, KeyframesAreTimePositionAndQuaternion) {
  const Json k = Json::parse(exportJson(sample()))["keyframes"][0];
  EXPECT_EQ(k["utime"], 5);
  const double expected[] = {7, 8, 9, 0, 0, std::sqrt(0.5), std::sqrt(0.5)};  // x y z qx qy qz qw
  ASSERT_EQ(k["pose"].size(), 7U);
  for (std::size_t i = 0; i < 7; ++i) {
    EXPECT_NEAR(k["pose"][i].get<double>(), expected[i], 1e-12);
  }
}

TEST(ExportJson, OfAnEmptyMapIsValid) {
  const Json j = Json::parse(exportJson({}));
  EXPECT_EQ(j["objects"], Json::array());
  EXPECT_EQ(j["edges"], Json::array());
  EXPECT_EQ(j["classes"], Json::object());
}

TEST(ExportJson, SurvivesClassNamesThatAreNoText) {
  StoredMap stored = sample();
  stored.map.setClassNames({{10, "bad \xff\xfe \"name\"\n"}});
  EXPECT_EQ(Json::parse(exportJson(stored))["objects"].size(), 3U);
}

struct Ply {
  std::size_t vertices = 0, bytes_a_vertex = 0;
  std::string body;
};

/// Reads the header like a viewer would.
Ply readPly(const std::string& text) {
  Ply ply;
  const std::map<std::string, std::size_t> sizes{{"float", 4}, {"int", 4}, {"ushort", 2}, {"uchar", 1}};
  std::istringstream header(text);
  for (std::string line, word; std::getline(header, line) && line != "end_header";) {
    std::istringstream words(line);
    words >> word;
    if (word == "element") {
      words >> word >> ply.vertices;
    } else if (word == "property") {
      words >> word;
      ply.bytes_a_vertex += sizes.at(word);
    }
  }
  ply.body = text.substr(text.find("end_header\n") + 11);
  return ply;
}

TEST(ExportPly, HasOneVertexALeafAndTheSizeItsHeaderSays) {
  const Ply ply = readPly(exportPly(sample()));
  EXPECT_EQ(ply.vertices, 3U);
  EXPECT_EQ(ply.bytes_a_vertex, 49U);
  EXPECT_EQ(ply.body.size(), ply.vertices * ply.bytes_a_vertex);
  EXPECT_TRUE(exportPly(sample()).starts_with("ply\nformat binary_little_endian 1.0\n"));
}

TEST(ExportPly, OfAnEmptyMapHasNoVertices) {
  const Ply ply = readPly(exportPly({}));
  EXPECT_EQ(ply.vertices, 0U);
  EXPECT_TRUE(ply.body.empty());
}

TEST(ExportPly, VerticesHoldMeanNormalAndDeviations) {
  const StoredMap stored = sample();
  const Ply ply = readPly(exportPly(stored));
  const MapNode& car = *stored.map.find(1);
  for (std::size_t k = 0; k < 3; ++k) {
    float v[10];
    std::memcpy(v, ply.body.data() + k * 49, sizeof(v));
    const Belief b = transform(car.T_map_object, unpackLeaf(leavesOf(car)[k]));
    const Vec3 mean(v[0], v[1], v[2]), normal(v[3], v[4], v[5]), deviations(v[6], v[7], v[8]);
    EXPECT_LE((mean - b.mean).norm(), 1e-6);
    EXPECT_NEAR(normal.norm(), 1, 1e-6);
    EXPECT_NEAR(normal.dot(b.cov * normal), deviations[0] * deviations[0], 1e-6);  // the flattest direction
    EXPECT_NEAR(deviations.squaredNorm(), b.cov.trace(), 1e-5);
    EXPECT_TRUE(deviations[0] <= deviations[1] && deviations[1] <= deviations[2]);
    EXPECT_EQ(v[9], 14);
    std::int32_t object = 0;
    std::uint16_t label = 0;
    std::memcpy(&object, ply.body.data() + k * 49 + 40, 4);
    std::memcpy(&label, ply.body.data() + k * 49 + 44, 2);
    EXPECT_EQ(object, 1);
    EXPECT_EQ(label, 10);
  }
}

TEST(ExportPly, ColoursTellClassesApart) {
  MapNode a = nodeAt(10, Vec3(0, 0, 0)), b = nodeAt(40, Vec3(5, 0, 0)), c = nodeAt(10, Vec3(9, 0, 0));
  for (MapNode* node : {&a, &b, &c}) {
    addLeaf(*node, packLeaf({Vec3(0, 0, 0), Mat3::Identity(), 1}));
  }
  const Ply ply = readPly(exportPly({mapOf({a, b, c}), {}}));
  ASSERT_EQ(ply.vertices, 3U);
  const auto colour = [&](std::size_t k) { return ply.body.substr(k * 49 + 46, 3); };
  EXPECT_EQ(colour(0), colour(2));
  EXPECT_NE(colour(0), colour(1));
}

}  // namespace
}  // namespace hgg::export_test
