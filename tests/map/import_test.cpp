#include "map/import.h"

#include <gtest/gtest.h>

#include "map/export.h"
#include "map/file.h"

namespace hgg::import_test {
namespace {

const std::string kGraph = R"({"objects":[
  {"id":0,"label":"chair","center":[1,2,3],"size":[2,4,6],"rgb":[10,20,30],"front":[1,5,3]},
  {"id":7,"label":"table","center":[0,0,0],"size":[1,2,1],"yaw":1.5707963}]})";

TEST(Import, TakesBoxesAndKeepsIds) {
  const Result<Map> map = importJson(kGraph);
  ASSERT_TRUE(map) << map.error;
  ASSERT_EQ(map->nodes().size(), 2U);
  const MapNode& chair = map->nodes().at(0);
  EXPECT_TRUE(chair.belief.mean.isApprox(Vec3(1, 2, 3)));
  EXPECT_TRUE((3 * chair.belief.cov.diagonal()).cwiseSqrt().isApprox(Vec3(1, 2, 3)));  // half the edges
  EXPECT_TRUE(isConfirmed(chair));
  EXPECT_EQ(map->classNames().at(chair.label), "chair");
  const MapNode& table = map->nodes().at(7);
  EXPECT_NEAR(std::sqrt(12 * table.belief.cov(0, 0)), 2, 1e-6);  // turned by a quarter
  EXPECT_EQ(map->nextId(), 8);
  EXPECT_EQ(map->graph().edges().size(), 1U);
}

TEST(Import, LooksSurviveTheFile) {
  const Result<StoredMap> stored = decodeMap(encodeMap(*importJson(kGraph)));
  ASSERT_TRUE(stored) << stored.error;
  const MapNode& chair = stored->map.nodes().at(0);
  ASSERT_TRUE(chair.looks.rgb && chair.looks.front_object);
  EXPECT_EQ(*chair.looks.rgb, (std::array<std::uint8_t, 3>{10, 20, 30}));
  EXPECT_TRUE((chair.T_map_object.linear() * *chair.looks.front_object).isApprox(Vec3(0, 1, 0), 1e-6));
  EXPECT_FALSE(stored->map.nodes().at(7).looks.rgb);
}

TEST(Import, MapsWithoutLooksAreWrittenInTheVersionBefore) {
  const std::string plain =
      encodeMap(*importJson(R"({"objects":[{"id":1,"label":3,"center":[0,0,0],"size":[1,1,1]}]})"));
  EXPECT_EQ(plain[8], 5);
  EXPECT_EQ(encodeMap(*importJson(kGraph))[8], 6);
}

TEST(Import, TakesWhatExportWrites) {
  const Result<StoredMap> first = decodeMap(encodeMap(*importJson(kGraph)));
  const std::string json = exportJson(*first);
  const Result<Map> again = importJson(json);
  ASSERT_TRUE(again) << again.error;
  ASSERT_EQ(again->nodes().size(), 2U);
  for (const auto& [id, node] : first->map.nodes()) {
    const MapNode& copy = again->nodes().at(id);
    EXPECT_TRUE(copy.belief.mean.isApprox(node.belief.mean));
    EXPECT_TRUE(copy.belief.cov.isApprox(node.belief.cov));
    EXPECT_EQ(copy.label, node.label);
  }
}

TEST(Import, SaysWhatIsWrong) {
  for (
      const auto& [text, why] : std::vector<std::pair<std::string, std::string>>{
          {"", "graph"},
          {"[]", "graph"},
          {R"({"objects":[3]})", "object 1"},
          {R"({"objects":[{"id":1,"label":"a"}]})", "center"},
          {R"({"objects":[{"id":-1,"label":"a","center":[0,0,0],"size":[1,1,1]}]})", "'id'"},
          {R"({"objects":[{"id":1,"center":[0,0,0],"size":[1,1,1]}]})", "'label'"},
          {R"({"objects":[{"id":1,"label":"a","center":[0,0],"size":[1,1,1]}]})", "'center'"},
          {R"({"objects":[{"id":1,"label":"a","center":[0,0,0],"size":[1,-1,1]}]})", "'size'"},
          {R"({"objects":[{"id":1,"label":"a","center":[0,0,1e300],"size":[1,1,1]}]})", "1000 km"},
          {R"({"objects":[{"id":1,"label":"a","mean":[0,0,0],"cov":[1,2,3,4,5,6,7,8,9]}]})", "'cov'"},
          {R"({"objects":[{"id":1,"label":"a","center":[0,0,0],"size":[1,1,1],"rgb":[300,0,0]}]})", "'rgb'"},
          {R"({"objects":[{"id":1,"label":"a","center":[0,0,0],"size":[1,1,1]},{"id":1,"label":"a","center":[0,0,0],"size":[1,1,1]}]})",
           "id 1"}}) {
    const Result<Map> map = importJson(text);
    EXPECT_FALSE(map) << text;
    EXPECT_NE(map.error.find(why), std::string::npos) << text << ": " << map.error;
  }
}

}  // namespace
}  // namespace hgg::import_test
