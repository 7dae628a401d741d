#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <set>

#include "sim/queries.h"
#include "sim/raycaster.h"
#include "sim/world_cloud.h"
#include "sim/world_surface.h"
#include "tools/scratch.h"
#include "truth/objects.h"

namespace hgg::truth_files_test {
namespace {

Pose poseAtPoint(const Vec3& position) {
  Pose pose = Pose::Identity();
  pose.translation() = position;
  return pose;
}

/// Ground, a house with a box inside, a crate; the sensor passes by.
Scene smallYard() {
  Scene scene;
  addObject(scene.world, {.label = 72, .name = "terrain"}, {uprightBox(Vec3(0, 0, -0.1), Vec3(30, 30, 0.1), 0.0)});
  addObject(scene.world, {.label = 50, .name = "building"}, {uprightBox(Vec3(0, 8, 0), Vec3(6, 4, 3), 0.0)});
  addObject(scene.world, {.label = 24, .thing = true, .name = "box"}, {uprightBox(Vec3(0, 8, 1), Vec3(1, 1, 1), 0.0)});
  addObject(scene.world, {.label = 24, .thing = true, .name = "box"}, {uprightBox(Vec3(3, 3, 0), Vec3(1, 1, 1), 0.3)});
  return scene;
}

std::vector<Pose> passingBy() {
  std::vector<Pose> poses;
  for (double x = -6.0; x <= 6.0; x += 0.25) {
    poses.push_back(poseAtPoint(Vec3(x, 0, 1.5)));
  }
  return poses;
}

TEST(ReferenceCloud, HasTheSurfaceThatCouldBeSeenAndNoOther) {
  const Scene scene = smallYard();
  const auto cloud = sampleSurfaces(scene, passingBy(), 0.0, {.spacing = 0.1, .reach = 20.0});
  const Vec3 origin(-6, 0, 1.5);  // the map's
  std::set<std::uint32_t> objects;
  double house_front = 0;
  for (const CloudPoint& point : cloud) {
    const Vec3 p = Vec3(point.x, point.y, point.z) + origin;
    objects.insert(point.object);
    EXPECT_EQ(point.label, scene.world.objects[point.object - 1].label);
    EXPECT_FALSE(point.object == 2 && p.y() > 9.99) << "the far side of the house";
    house_front += point.object == 2 && std::abs(p.y() - 6.0) < 1e-3 ? 1 : 0;
  }
  EXPECT_EQ(objects, (std::set<std::uint32_t>{1, 2, 4}));   // not the box in the house
  EXPECT_NEAR(house_front, 6.0 * 3.0 / 0.01, 0.05 * 1800);  // its door side, less what the crate hides
}

TEST(ReferenceCloud, IsAllWithinReachAndAboutAsManyAsAskedFor) {
  const auto cloud =
      sampleSurfaces(smallYard(), passingBy(), 0.0, {.spacing = 0.02, .reach = 7.0, .max_points = 20'000});
  EXPECT_GT(cloud.size(), 15'000u);
  EXPECT_LT(cloud.size(), 25'000u);
  for (const CloudPoint& p : cloud) {
    EXPECT_LT(std::abs(p.y), 9.0);
  }
}

TEST(ReferenceCloud, LeavesOutWhatMovesAndWhatIsGone) {
  Scene scene = smallYard();
  scene.motions.push_back({3, [](double time) { return time < 3.0 ? std::optional(Pose::Identity()) : std::nullopt; }});
  const auto objectsAt = [&](double end_time) {
    std::set<std::uint32_t> objects;
    for (const CloudPoint& p : sampleSurfaces(scene, passingBy(), end_time, {.spacing = 0.2})) {
      objects.insert(p.object);
    }
    return objects;
  };
  EXPECT_TRUE(objectsAt(2.0).contains(4));
  EXPECT_FALSE(objectsAt(4.0).contains(4));
  scene.world.objects[3].dynamic = true;
  EXPECT_FALSE(objectsAt(2.0).contains(4));
}

TEST(ReferenceCloud, SurvivesTheFile) {
  const Scratch scratch;
  const std::vector<CloudPoint> cloud{{1.5F, -2.0F, 0.25F, 70, 3}, {0, 0, 1e-3F, 261, 4'000'000'000U}};
  ASSERT_EQ(writeCloud(cloud, scratch / "cloud.ply"), "");
  const auto read = readCloud(scratch / "cloud.ply");
  ASSERT_TRUE(read) << read.error;
  ASSERT_EQ(read->size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ((*read)[i].x, cloud[i].x);
    EXPECT_EQ((*read)[i].z, cloud[i].z);
    EXPECT_EQ((*read)[i].label, cloud[i].label);
    EXPECT_EQ((*read)[i].object, cloud[i].object);
  }
}

TEST(ReferenceCloud, CutOrForeignFilesAreErrors) {
  const Scratch scratch;
  ASSERT_EQ(writeCloud({{1, 2, 3, 4, 5}, {1, 2, 3, 4, 5}}, scratch / "cloud.ply"), "");
  const std::string whole = readText(scratch / "cloud.ply");
  for (const std::string& text : {whole.substr(0, whole.size() - 1), whole + "x", whole.substr(0, 30), std::string(),
                                  std::string("ply\nelement vertex 99999999999999\n")}) {
    writeText(scratch / "bad.ply", text);
    EXPECT_FALSE(readCloud(scratch / "bad.ply"));
  }
  EXPECT_FALSE(readCloud(scratch / "none.ply"));
}

TEST(Surface, PointsLieOnTheShapeAndCoverItEvenly) {
  const Shape shapes[] = {uprightBox(Vec3(1, 2, 3), Vec3(2, 1, 3), 0.4), Cylinder{Vec3(0, 0, 0), 1.0, 2.0},
                          Ellipsoid{Vec3(0, 0, 0), Vec3(1, 1, 1)},
                          Triangle{Vec3(0, 0, 0), Vec3(3, 0, 0), Vec3(0, 2, 1)}};
  const double areas[] = {2.0 * (2 + 6 + 3), 2.0 * M_PI * 3.0, 4.0 * M_PI, 0.5 * 3.0 * std::sqrt(5.0)};
  constexpr double kSpacing = 0.05;
  for (std::size_t k = 0; k < 4; ++k) {
    double count = 0;
    sampleSurface(shapes[k], kSpacing, {}, [&](const Vec3& p, const Vec3& normal) {
      const Vec3 out = normal.isZero() ? Vec3(Vec3(0, 2, 1).cross(Vec3(3, 0, 0)).normalized()) : normal;
      const auto range = std::visit([&](const auto& s) { return intersect(s, {p + 0.1 * out, -out}); }, shapes[k]);
      ASSERT_TRUE(range) << k;
      ASSERT_NEAR(*range, 0.1, 1e-6) << k;
      ++count;
    });
    EXPECT_NEAR(count * kSpacing * kSpacing, areas[k], 0.08 * areas[k]) << k;
  }
}

TEST(Queries, SurviveTheFile) {
  const Scratch scratch;
  ASSERT_EQ(writeQueries({{"the \"odd\" bench", 7, "bench"}, {"the bin", 8, "bin"}}, scratch / "queries.jsonl"), "");
  const auto read = readQueries(scratch / "queries.jsonl");
  ASSERT_TRUE(read) << read.error;
  ASSERT_EQ(read->size(), 2u);
  EXPECT_EQ(read->front().text, "the \"odd\" bench");
  EXPECT_EQ(read->back().target, 8);
  EXPECT_EQ(read->back().class_name, "bin");
  writeText(scratch / "bad.jsonl", "{\"text\":\"a\",\"target\":1,\"class\":\"b\"}\n{\"text\":1}\n");
  const auto bad = readQueries(scratch / "bad.jsonl");
  ASSERT_FALSE(bad);
  EXPECT_NE(bad.error.find("line 2"), std::string::npos);
}

/// What a sensor that misses nothing has seen.
std::vector<TruthObject> allSeen(const Scene& scene) {
  std::vector<TruthObject> seen;
  for (std::size_t i = 0; i < scene.world.objects.size(); ++i) {
    const WorldObject& object = scene.world.objects[i];
    const auto points = sampleObject(scene.world, i, 0.05);
    if (object.thing && !points.empty()) {
      seen.push_back({.id = object.id,
                      .label = object.label,
                      .dynamic = object.dynamic,
                      .frames = 10,
                      .belief = beliefFromPoints(points)});
    }
  }
  return seen;
}

void addThing(Scene& scene, ClassId label, const std::string& name, const Vec3& base, const Vec3& size) {
  addObject(scene.world, {.label = label, .thing = true, .name = name}, {uprightBox(base, size, 0.0)});
}

std::map<std::string, std::int64_t> phrasesOf(const Scene& scene, const std::vector<TruthObject>& seen) {
  std::map<std::string, std::int64_t> phrases;
  for (const TruthQuery& query : makeQueries(scene, seen)) {
    EXPECT_TRUE(phrases.emplace(query.text, query.target).second) << query.text << " is asked twice";
  }
  return phrases;
}

/// Three benches, a bin beside the second, a bus.
Scene benches() {
  Scene scene;
  addThing(scene, 260, "bench", Vec3(0, 0, 0), Vec3(0.5, 1.5, 0.8));
  addThing(scene, 260, "bench", Vec3(10, 0, 0), Vec3(0.5, 1.5, 0.8));
  addThing(scene, 260, "bench", Vec3(20, 0, 0), Vec3(0.5, 2.5, 0.8));
  addThing(scene, 261, "bin", Vec3(10, 1.5, 0), Vec3(0.4, 0.4, 1.0));
  addThing(scene, 13, "bus", Vec3(60, 0, 0), Vec3(10, 2.5, 3.0));
  return scene;
}

TEST(Queries, NameWhatIsUniqueLargestNextAndFarthest) {
  const Scene scene = benches();
  const auto phrases = phrasesOf(scene, allSeen(scene));
  const std::map<std::string, std::int64_t> expected{{"the bin", 4},
                                                     {"the bus", 5},
                                                     {"the largest bench", 3},
                                                     {"the bench next to the bin", 2},
                                                     {"the bench farthest from the bus", 1}};
  for (const auto& [text, target] : expected) {
    ASSERT_TRUE(phrases.contains(text)) << text;
    EXPECT_EQ(phrases.at(text), target) << text;
  }
  EXPECT_FALSE(phrases.contains("the smallest bench"));  // two are
  EXPECT_FALSE(phrases.contains("the tallest bench"));
  EXPECT_FALSE(phrases.contains("the bench"));
}

TEST(Queries, ARivalWithinTheMarginSilencesThem) {
  Scene scene = benches();
  addThing(scene, 260, "bench", Vec3(40, 0, 0), Vec3(0.5, 2.4, 0.8));
  addThing(scene, 261, "bin", Vec3(20, 2.1, 0), Vec3(0.4, 0.4, 1.0));
  addThing(scene, 13, "bus", Vec3(80, 0, 0), Vec3(10, 2.5, 3.0));
  const auto phrases = phrasesOf(scene, allSeen(scene));
  for (const char* text :
       {"the largest bench", "the bench next to the bin", "the bin", "the bus", "the bench farthest from the bus"}) {
    EXPECT_FALSE(phrases.contains(text)) << text;
  }
}

TEST(Queries, OnlyWhatWasSeenAndStandsStillIsAskedFor) {
  Scene scene = benches();
  auto seen = allSeen(scene);
  seen[4].gone = true;                    // the bus
  seen.erase(seen.begin() + 3);           // the bin was never seen
  scene.world.objects[0].dynamic = true;  // a bench that walks: no bench can be told
  EXPECT_TRUE(makeQueries(scene, seen).empty());
}

TEST(Queries, AWallBetweenMakesNoNeighbours) {
  Scene scene = benches();
  addObject(scene.world, {.label = 50, .name = "building"}, {uprightBox(Vec3(10, 1.0, 0), Vec3(6, 0.1, 3), 0.0)});
  EXPECT_FALSE(phrasesOf(scene, allSeen(scene)).contains("the bench next to the bin"));
}

TEST(Queries, ADeskRivalsATable) {
  Scene scene;
  addThing(scene, 11, "table", Vec3(0, 0, 0), Vec3(1, 1, 0.7));
  addThing(scene, 12, "desk", Vec3(5, 0, 0), Vec3(1, 2, 0.7));
  const auto phrases = phrasesOf(scene, allSeen(scene));
  EXPECT_FALSE(phrases.contains("the table"));
  EXPECT_FALSE(phrases.contains("the largest table"));
  EXPECT_TRUE(phrases.contains("the desk"));
}

TEST(Queries, WhatIsNextToADeskIsNotNextToTheTable) {
  Scene scene;
  addThing(scene, 11, "table", Vec3(0, 0, 0), Vec3(1, 1, 0.7));
  addThing(scene, 12, "desk", Vec3(10, 0, 0), Vec3(1, 1, 0.7));
  addThing(scene, 14, "bin", Vec3(10, 1.0, 0), Vec3(0.3, 0.3, 0.6));
  addThing(scene, 14, "bin", Vec3(30, 0, 0), Vec3(0.3, 0.3, 0.6));
  const auto phrases = phrasesOf(scene, allSeen(scene));
  EXPECT_FALSE(phrases.contains("the bin next to the table"));
  EXPECT_EQ(phrases.at("the bin next to the desk"), 3);
}

TEST(Queries, ATableToStandNextToMayBeADeskOrMustNot) {
  Scene scene;
  addThing(scene, 11, "table", Vec3(0, 0, 0), Vec3(1, 1, 0.7));
  addThing(scene, 12, "desk", Vec3(10, 0, 0), Vec3(1, 1, 0.7));
  addThing(scene, 13, "chair", Vec3(0, 2.5, 0), Vec3(0.5, 0.5, 0.9));
  addThing(scene, 13, "chair", Vec3(20, 0, 0), Vec3(0.5, 0.5, 0.9));
  addThing(scene, 14, "bin", Vec3(10, 1.0, 0), Vec3(0.3, 0.3, 0.6));
  addThing(scene, 14, "bin", Vec3(0, -1.5, 0), Vec3(0.3, 0.3, 0.6));
  addThing(scene, 14, "bin", Vec3(30, 0, 0), Vec3(0.3, 0.3, 0.6));
  const auto phrases = phrasesOf(scene, allSeen(scene));
  EXPECT_FALSE(phrases.contains("the bin next to the table"));        // the bin at the desk is, too
  EXPECT_FALSE(phrases.contains("the bin farthest from the table"));  // which?
  EXPECT_FALSE(phrases.contains("the chair closest to the table"));   // which?
  EXPECT_EQ(phrases.at("the bin next to the desk"), 5);
  scene.world.objects[4].label = 15, scene.world.objects[4].name = "box";
  EXPECT_EQ(phrasesOf(scene, allSeen(scene)).at("the bin next to the table"), 6);  // whatever a desk is
}

/// Two trees; a bench 1 m from the trunk of the first, another 4 m from that of the second.
Scene trees(double crown) {
  Scene scene;
  for (const double x : {0.0, 20.0}) {
    addObject(scene.world, {.label = 71, .thing = true, .name = "trunk"},
              {Cylinder{Vec3(x, 0, 0), 0.2, 2.0 + 0.1 * x}});
    if (crown > 0.0) {
      addObject(scene.world, {.label = 70, .foliage = true, .name = "vegetation"},
                {Ellipsoid{Vec3(x, 0, 2.4 + 0.1 * x), Vec3(x > 0 ? crown : 0.5, 0.5, 1.0)}});
    }
  }
  addThing(scene, 260, "bench", Vec3(0, 1.45, 0), Vec3(1.5, 0.5, 0.8));
  addThing(scene, 260, "bench", Vec3(24.5, 0, 2.6), Vec3(0.6, 1.5, 0.8));
  return scene;
}

TEST(Queries, ATreeIsItsTrunkOrHasItsCrown) {
  const Scene bare = trees(0.0), small = trees(0.6), wide = trees(3.5);
  const std::string next = "the bench next to the tree";
  EXPECT_EQ(phrasesOf(bare, allSeen(bare)).at(next), 3);
  EXPECT_EQ(phrasesOf(small, allSeen(small)).at(next), 5);
  EXPECT_FALSE(phrasesOf(wide, allSeen(wide)).contains(next));  // the crown reaches over the other bench
  for (const auto& [text, target] : phrasesOf(bare, allSeen(bare))) {
    EXPECT_FALSE(text.ends_with("est tree")) << text;
  }
}

TEST(Queries, NoOneSaysTheOtherVehicle) {
  Scene scene = benches();
  addThing(scene, 20, "other-vehicle", Vec3(0, 2.0, 0), Vec3(2, 1, 2));
  for (const auto& [text, target] : phrasesOf(scene, allSeen(scene))) {
    EXPECT_EQ(text.find("other"), std::string::npos) << text;
  }
}

TEST(Queries, WhatIsOnlyALittleFartherIsNextToItAsWell) {
  Scene scene = benches();
  addThing(scene, 260, "bench", Vec3(12.0, 1.5, 0), Vec3(0.5, 1.5, 0.8));  // 1.55 m from the bin, the other 0.55 m
  auto phrases = phrasesOf(scene, allSeen(scene));
  EXPECT_FALSE(phrases.contains("the bench next to the bin"));
  EXPECT_EQ(phrases.at("the bench closest to the bin"), 2);
  addThing(scene, 261, "bin", Vec3(-40, 0, 0), Vec3(0.4, 0.4, 1.0));
  EXPECT_FALSE(phrasesOf(scene, allSeen(scene)).contains("the bench closest to the bin"));  // which?
}

/// The things of a world by their nouns, thinly sampled; a desk is a table too and a tree has its crown when asked for.
struct Surface {
  std::vector<Vec3> points;
  Bounds bounds;
};
std::map<std::string, std::map<std::uint32_t, Surface>> surfacesByNoun(const World& world, bool crowns, bool desks) {
  constexpr double kSpacing = 0.12;
  std::map<std::string, std::map<std::uint32_t, Surface>> things;
  for (std::size_t i = 0; i < world.objects.size(); ++i) {
    const WorldObject& object = world.objects[i];
    if (!object.thing) {
      continue;
    }
    Surface surface{sampleObject(world, i, kSpacing), {}};
    const bool has_crown = object.name == "trunk" && i + 1 < world.objects.size() && world.objects[i + 1].foliage;
    if (crowns && has_crown) {  // worlds add it after its trunk
      std::ranges::copy(sampleObject(world, i + 1, kSpacing), std::back_inserter(surface.points));
    }
    for (const Vec3& p : surface.points) {
      surface.bounds = join(surface.bounds, {p, p});
    }
    std::string noun = object.name == "trunk" ? "tree" : object.name;
    std::ranges::replace(noun, '-', ' ');
    if (desks && noun == "desk") {
      things["table"][object.id] = surface;
    }
    things[noun][object.id] = std::move(surface);
  }
  return things;
}

/// m between two surfaces; those farther apart than `enough` are only known to be.
double surfaceDistance(const Surface& a, const Surface& b, double enough) {
  double nearest = (a.bounds.lo - b.bounds.hi).cwiseMax(b.bounds.lo - a.bounds.hi).cwiseMax(0.0).norm();
  if (nearest > enough) {
    return nearest;
  }
  nearest = std::numeric_limits<double>::infinity();
  for (const Vec3& p : a.points) {
    for (const Vec3& q : b.points) {
      nearest = std::min(nearest, (p - q).squaredNorm());
    }
  }
  return std::sqrt(nearest);
}

/// The oracle for "next to": measures every pair of the two classes, under every reading of tree and table.
TEST(Queries, WhatIsNextToAThingIsTheOnlyOneThatIsByBruteForce) {
  constexpr double kNextTo = 1.5, kRival = 2.0, kSlack = 0.15;
  int checked = 0;
  for (const std::string& name : sceneNames()) {
    for (const std::uint64_t seed : {1, 2, 3}) {
      const Scene scene = *makeScene(name, seed);
      const auto queries = makeQueries(scene, allSeen(scene));
      for (const bool widely : {false, true}) {
        const auto things = surfacesByNoun(scene.world, widely, widely);
        for (const TruthQuery& query : queries) {
          const std::size_t at = query.text.find(" next to the ");
          if (at == std::string::npos) {
            continue;
          }
          ++checked;
          for (const auto& [id, candidate] : things.at(query.text.substr(4, at - 4))) {
            double distance = std::numeric_limits<double>::infinity();
            for (const auto& [other, anchor] : things.at(query.text.substr(at + 13))) {
              distance = std::min(distance, surfaceDistance(candidate, anchor, kRival));
            }
            EXPECT_TRUE(id == query.target ? distance < kNextTo + kSlack : distance > kRival - kSlack)
                << name << " " << seed << ": " << query.text << ": " << id << " at " << distance << " m";
          }
        }
      }
    }
  }
  EXPECT_GT(checked, 2 * 40);
}

}  // namespace
}  // namespace hgg::truth_files_test
