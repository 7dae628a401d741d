// A map's grid against the truth's, by hand and against brute force.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>

#include "eval/evaluate.h"
#include "eval/report.h"
#include "eval/walk.h"
#include "tools/scratch.h"
#include "truth/npy.h"

namespace hgg::walk_eval_test {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr std::uint8_t kFree = 0, kBlocked = 254, kUnknown = 255;

/// A floor at 0 that was seen all over.
WalkGrid floorTruth(int width, int height) {
  WalkGrid grid;
  grid.width = width, grid.height = height;
  grid.known.assign(grid.cells(), 1);
  for (std::size_t cell = 0; cell <= grid.cells(); ++cell) {
    grid.first.push_back(static_cast<std::uint32_t>(cell));
  }
  grid.surfaces.assign(grid.cells(), {0.0F, Standing::kFree, false, 1});
  return grid;
}

MapGrid floorMap(int width, int height) {
  MapGrid map;
  map.resolution = 0.1, map.width = width, map.height = height, map.levels = 1;
  map.cost.assign(static_cast<std::size_t>(width * height), kFree);
  map.heights.assign(map.cost.size(), 0.0F);
  return map;
}

const Laying kAsItIs{Pose::Identity()};
const std::vector<Pose> kWay{Pose::Identity()};

TEST(MapGrid, VerdictsAreThoseOfTheLevelNearestInHeight) {
  MapGrid map = floorMap(1, 1);
  map.levels = 3;
  map.cost = {kBlocked, 252, kUnknown};
  map.heights = {0.0F, 0.5F, kNaN};
  EXPECT_EQ(walkabilityAt(map, 0, 0, {0.2, 0.2 - 0.3, 0.2 + 0.3}), Walkability::kBlocked);
  EXPECT_EQ(walkabilityAt(map, 0, 0, {0.3, 0.3 - 0.3, 0.3 + 0.3}), Walkability::kWalkable);
  EXPECT_EQ(walkabilityAt(map, 0, 0, {0.81, 0.81 - 0.3, 0.81 + 0.3}), Walkability::kUnknown);
  EXPECT_EQ(walkabilityAt(map, 1, 0, {0.2, 0.2 - 0.3, 0.2 + 0.3}), Walkability::kUnknown);
  map.cost[2] = kBlocked;  // at no height: at every height where there is nothing else
  EXPECT_EQ(walkabilityAt(map, 0, 0, {0.81, 0.81 - 0.3, 0.81 + 0.3}), Walkability::kBlocked);
  EXPECT_EQ(walkabilityAt(map, 0, 0, {0.4, 0.4 - 0.3, 0.4 + 0.3}), Walkability::kWalkable);
}

TEST(MapGrid, IsReadAsItIsExported) {
  const Scratch scratch;
  const std::string header = R"({"format":"hgg-grid","version":1,"origin":[-1,2],"resolution":0.1,"width":2,"height":1,
    "levels":2,"reference_z":-0.6,"layers":{"cost":{"dtype":"uint8","file":"g.cost.npy"},"height":{"dtype":"float32","file":"g.height.npy"}}})";
  writeText(scratch / "g.layers.json", header);
  ASSERT_EQ(writeNpy(npyOf<std::uint8_t>({0, 254, 255, 7}, {2, 1, 2}), scratch / "g.cost.npy"), "");
  ASSERT_EQ(writeNpy(npyOf<float>({0, 1, kNaN, 3}, {2, 1, 2}), scratch / "g.height.npy"), "");
  const auto map = readMapGrid(scratch / "g.layers.json");
  ASSERT_TRUE(map) << map.error;
  EXPECT_EQ(map->origin_y, 2.0);
  EXPECT_EQ(map->cost[map->at(1, 1, 0)], 7);
  EXPECT_EQ(map->heights[map->at(0, 1, 0)], 1.0F);
  ASSERT_EQ(writeNpy(npyOf<float>({0, 1, kNaN}, {3, 1, 1}), scratch / "g.height.npy"), "");
  EXPECT_FALSE(readMapGrid(scratch / "g.layers.json"));
  for (const char* text : {"", "{}", "[]", R"({"format":"hgg-grid","version":2})"}) {
    writeText(scratch / "g.layers.json", text);
    EXPECT_FALSE(readMapGrid(scratch / "g.layers.json"));
  }
}

TEST(Walk, APerfectMapIsPerfect) {
  WalkGrid truth = floorTruth(20, 10);
  MapGrid map = floorMap(20, 10);
  truth.surfaces[25].standing = Standing::kBlocked;
  map.cost[25] = kBlocked;
  const WalkScore score = scoreWalk(map, truth, kAsItIs, kWay);
  for (const WalkShares& shares : {score.strict, score.tolerant}) {
    EXPECT_EQ(shares.blocked_called_walkable, 0.0);
    EXPECT_EQ(shares.precision, 1.0);
    EXPECT_EQ(shares.recall, 1.0);
  }
  EXPECT_EQ(score.confusion[0][0], 199U);
  EXPECT_EQ(score.confusion[1][1], 1U);
}

TEST(Walk, AnObstacleOneCellOffIsWrongCellForCellAndRightWithinOne) {
  WalkGrid truth = floorTruth(20, 10);
  MapGrid map = floorMap(20, 10);
  truth.surfaces[truth.at(5, 5)].standing = Standing::kBlocked;
  map.cost[map.at(0, 6, 5)] = kBlocked;
  const WalkScore one_off = scoreWalk(map, truth, kAsItIs, kWay);
  EXPECT_EQ(one_off.strict.blocked_called_walkable, 1.0);
  EXPECT_EQ(one_off.tolerant.blocked_called_walkable, 0.0);
  EXPECT_DOUBLE_EQ(one_off.strict.precision, 198.0 / 199.0);
  EXPECT_DOUBLE_EQ(one_off.tolerant.precision, 1.0);
  EXPECT_DOUBLE_EQ(one_off.strict.recall, 198.0 / 199.0);
  map.cost[map.at(0, 6, 5)] = kFree;
  EXPECT_EQ(scoreWalk(map, truth, kAsItIs, kWay).tolerant.blocked_called_walkable, 1.0) << "it is nowhere";
}

TEST(Walk, OnlyGroundThatWasSeenIsAskedFor) {
  WalkGrid truth = floorTruth(20, 10);
  MapGrid map = floorMap(20, 10);
  map.cost.assign(map.cost.size(), kUnknown);
  for (std::size_t i = 0; i < 50; ++i) {
    truth.surfaces[i].returns = 0;
  }
  truth.surfaces[60].island = true;
  truth.surfaces[61].standing = Standing::kClose;
  const WalkScore score = scoreWalk(map, truth, kAsItIs, kWay);
  EXPECT_EQ(score.confusion[0][2], 148U);
  EXPECT_EQ(score.strict.recall, 0.0);
  EXPECT_TRUE(std::isnan(score.strict.precision));
  EXPECT_TRUE(std::isnan(score.strict.blocked_called_walkable));
}

TEST(Walk, RecallEndsTwelveMetresFromTheWay) {
  const WalkGrid truth = floorTruth(200, 1);
  const WalkScore score = scoreWalk(floorMap(200, 1), truth, kAsItIs, kWay);
  EXPECT_EQ(score.free_near, 120U);
  EXPECT_EQ(score.confusion[0][0], 200U);
}

TEST(Walk, ATableTopCalledWalkableIsAnIslandAndAFloorInTheAirIsWrong) {
  WalkGrid truth = floorTruth(3, 1);
  truth.first = {0, 2, 3, 4};
  truth.surfaces = {{0.0F, Standing::kBlocked, false, 1},
                    {0.74F, Standing::kFree, true, 1},
                    {0.0F, Standing::kFree, false, 1},
                    {0.0F, Standing::kFree, false, 1}};
  MapGrid map = floorMap(3, 1);
  map.heights = {0.74F, 0.0F, 0.9F};
  const WalkScore score = scoreWalk(map, truth, kAsItIs, kWay);
  EXPECT_EQ(score.islands, 1U);
  EXPECT_EQ(score.free, 1U);
  EXPECT_EQ(score.nothing, 1U);
  EXPECT_DOUBLE_EQ(score.strict.precision, 0.5);
  EXPECT_EQ(score.confusion[1][2], 1U) << "the floor below the table";
}

TEST(Walk, TheTopOfALowBoxIsNotTheFloorBelowIt) {
  WalkGrid truth = floorTruth(1, 1);
  truth.first = {0, 2};
  truth.surfaces = {{0.0F, Standing::kBlocked, false, 1}, {0.29F, Standing::kFree, true, 1}};
  MapGrid map = floorMap(1, 1);
  map.heights = {0.27F};
  EXPECT_EQ(scoreWalk(map, truth, kAsItIs, kWay).confusion[1][2], 1U);
  map.heights = {0.1F};
  EXPECT_EQ(scoreWalk(map, truth, kAsItIs, kWay).confusion[1][0], 1U);
}

TEST(Walk, DriftCountsForTheWholeMapAndNotByTheNearestPose) {
  const WalkGrid truth = [] {
    WalkGrid grid = floorTruth(200, 20);
    for (int y = 0; y < 20; ++y) {
      grid.surfaces[grid.at(150, y)].standing = Standing::kBlocked;
    }
    return grid;
  }();
  MapGrid map = floorMap(200, 20);
  for (int y = 0; y < 20; ++y) {
    map.cost[map.at(0, 155, y)] = kBlocked;  // the map has run half a metre away there
  }
  std::vector<PosePair> pairs;
  for (double x = 0.5; x < 20.0; x += 0.5) {
    PosePair pair;
    pair.T_truth_body.translation() = Vec3(x, 1.0, 0.0);
    pair.T_map_body.translation() = Vec3(x > 10.0 ? x + 0.5 : x, 1.0, 0.0);
    pairs.push_back(pair);
  }
  EXPECT_EQ(scoreWalk(map, truth, kAsItIs, kWay).tolerant.blocked_called_walkable, 1.0);
  EXPECT_EQ(scoreWalk(map, truth, Laying(pairs), kWay).strict.blocked_called_walkable, 0.0);
}

/// The definitions, written down once more without any thought of time.
WalkShares bruteForce(const MapGrid& map, const WalkGrid& truth, const Pose& T_truth_map) {
  const Pose T_grid_map = truth.T_grid_map * T_truth_map;
  double blocked = 0, wrong = 0, free = 0, found = 0, walkable = 0, right = 0;
  for (int y = 0; y < truth.height; ++y) {
    for (int x = 0; x < truth.width; ++x) {
      for (const WalkSurface& s : truth.column(truth.at(x, y))) {
        if (s.returns == 0 || s.island || s.standing == Standing::kClose) {
          continue;
        }
        const Vec3 p_grid(truth.origin_x + (x + 0.5) * 0.1, truth.origin_y + (y + 0.5) * 0.1, s.height);
        const Vec3 p = T_grid_map.inverse() * p_grid;
        bool is_walkable = false;
        double nearest = 0.3;
        for (int level = 0; level < map.levels; ++level) {
          for (int i = 0; i < map.width * map.height; ++i) {
            const double u = (p.x() - map.origin_x) / map.resolution - i % map.width;
            const double v = (p.y() - map.origin_y) / map.resolution - i / map.width;
            const std::size_t at = map.at(level, i % map.width, i / map.width);
            const double apart = std::abs(static_cast<double>(map.heights[at]) - p.z());
            const double as_truth = static_cast<double>(map.heights[at]) - p.z() + static_cast<double>(s.height);
            bool is_anothers = false;
            for (const WalkSurface& other : truth.column(truth.at(x, y))) {
              is_anothers = is_anothers || std::abs(static_cast<double>(other.height) - as_truth) < apart - 1e-9;
            }
            if (!is_anothers && u >= 0 && u < 1 && v >= 0 && v < 1 && apart <= nearest && map.cost[at] != kUnknown) {
              nearest = apart;
              is_walkable = map.cost[at] <= 252;
            }
          }
        }
        const bool is_near = (p_grid - truth.T_grid_map.translation()).head<2>().norm() <= 12.0;
        blocked += s.standing == Standing::kBlocked, free += s.standing == Standing::kFree && is_near;
        wrong += s.standing == Standing::kBlocked && is_walkable;
        found += s.standing == Standing::kFree && is_near && is_walkable;
      }
    }
  }
  for (std::size_t at = 0; at < map.cost.size(); ++at) {
    const int i = static_cast<int>(at) % (map.width * map.height);
    const Vec3 p = T_grid_map * Vec3(map.origin_x + (i % map.width + 0.5) * map.resolution,
                                     map.origin_y + (i / map.width + 0.5) * map.resolution,
                                     std::isnan(map.heights[at]) ? map.reference_z : double(map.heights[at]));
    const int x = static_cast<int>(std::floor((p.x() - truth.origin_x) / 0.1));
    const int y = static_cast<int>(std::floor((p.y() - truth.origin_y) / 0.1));
    if (map.cost[at] > 252 || x < 0 || y < 0 || x >= truth.width || y >= truth.height ||
        truth.known[truth.at(x, y)] == 0) {
      continue;
    }
    const WalkSurface* nearest = nullptr;
    for (const WalkSurface& s : truth.column(truth.at(x, y))) {
      const double apart = std::abs(static_cast<double>(s.height) - p.z());
      if (apart <= 0.3 && (nearest == nullptr || apart <= std::abs(static_cast<double>(nearest->height) - p.z()))) {
        nearest = &s;
      }
    }
    const bool counts = nearest == nullptr || (!nearest->island && nearest->standing != Standing::kClose);
    walkable += counts ? 1 : 0;
    right += counts && nearest != nullptr && nearest->standing == Standing::kFree ? 1 : 0;
  }
  return {wrong / blocked, right / walkable, found / free};
}

TEST(Walk, IsWhatBruteForceFindsInRandomWorldsAnyWayTheyLie) {
  std::mt19937 random(5);
  const auto draw = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  for (int round = 0; round < 20; ++round) {
    WalkGrid truth = floorTruth(40, 30);
    truth.origin_x = -1.7, truth.origin_y = 0.3;
    truth.T_grid_map.linear() = Eigen::AngleAxisd(0.05 * draw(10), Vec3(0.1, 0.2, 1).normalized()).toRotationMatrix();
    truth.T_grid_map.translation() = Vec3(0.1 * draw(10), 0.5, 0.2);
    truth.surfaces.clear();
    for (std::size_t cell = 0; cell < truth.cells(); ++cell) {
      truth.known[cell] = draw(10) > 0;
      for (int k = draw(3); k > 0; --k) {
        truth.surfaces.push_back({0.25F * static_cast<float>(3 - k) + 0.01F * static_cast<float>(draw(9)),
                                  static_cast<Standing>(draw(3)), draw(4) == 0, static_cast<std::uint32_t>(draw(2))});
      }
      truth.first[cell + 1] = static_cast<std::uint32_t>(truth.surfaces.size());
    }
    MapGrid map = floorMap(35, 35);
    map.levels = 2, map.origin_x = -2.0, map.origin_y = -0.5, map.resolution = 0.08 + 0.01 * draw(5);
    map.cost.resize(2 * map.cost.size()), map.heights.resize(map.cost.size());
    for (std::size_t i = 0; i < map.cost.size(); ++i) {
      map.cost[i] = std::array{kFree, std::uint8_t{100}, kBlocked, kUnknown}[static_cast<std::size_t>(draw(4))];
      map.heights[i] = map.cost[i] == kUnknown ? kNaN : 0.01F * static_cast<float>(draw(100));
    }
    Pose T_truth_map = Pose::Identity();
    T_truth_map.linear() = Eigen::AngleAxisd(0.3 * draw(20), Vec3(0.05, 0, 1).normalized()).toRotationMatrix();
    const WalkScore score = scoreWalk(map, truth, Laying(T_truth_map), kWay);
    const WalkShares expected = bruteForce(map, truth, T_truth_map);
    EXPECT_DOUBLE_EQ(score.strict.blocked_called_walkable, expected.blocked_called_walkable);
    EXPECT_DOUBLE_EQ(score.strict.precision, expected.precision);
    EXPECT_DOUBLE_EQ(score.strict.recall, expected.recall);
    EXPECT_GT(expected.recall, 0.0) << "the worlds must overlap for this to say anything";
  }
}

/// A map of one graph, a truth that is turned by 90 degrees and shifted by (5, 0, 0), and its grid as the map has it.
EvalOptions turnedWorld(const Scratch& scratch) {
  writeText(scratch / "g.json", R"({"format":"hgg-graph","version":1,"classes":{},"objects":[],"edges":[]})");
  writeText(scratch / "t.tum", "0.0 0 0 0 0 0 0 1\n0.1 2 0 0 0 0 0 1\n");
  std::vector<Pose> T_truth_body;
  for (const double x : {0.0, 2.0}) {
    Pose pose = Pose::Identity();
    pose.linear() << 0, -1, 0, 1, 0, 0, 0, 0, 1;
    pose.translation() = Vec3(5, x, 0);
    T_truth_body.push_back(pose);
  }
  WalkGrid truth = floorTruth(60, 30);  // x from 2.5 to 8.5, y from 0 to 3 of the truth, shown a metre up
  truth.T_grid_map.translation() = Vec3(-2.5, 0, 1.0);
  for (WalkSurface& s : truth.surfaces) {
    s.height = 1.0F;
  }
  truth.surfaces[truth.at(40, 20)].cause = kCauseEdge;
  truth.surfaces[truth.at(40, 20)].standing = Standing::kBlocked;  // (6.55, 2.05) of the truth
  EXPECT_EQ(writeTruth({}, T_truth_body, scratch / "truth"), "");
  EXPECT_EQ(writeWalkGrid(truth, scratch / "truth"), "");
  MapGrid map = floorMap(30, 60);  // x = truth's y, y = 5 - truth's x: from -3.5 to 2.5
  map.cost[map.at(0, 20, 19)] = kBlocked;
  writeText(scratch / "grid.layers.json",
            R"({"format":"hgg-grid","version":1,"origin":[0,-3.5],"resolution":0.1,"width":30,"height":60,"levels":1,
"reference_z":0,"layers":{"cost":{"dtype":"uint8","file":"c.npy"},"height":{"dtype":"float32","file":"h.npy"}}})");
  EXPECT_EQ(writeNpy(npyOf(map.cost, {1, 60, 30}), scratch / "c.npy"), "");
  EXPECT_EQ(writeNpy(npyOf(map.heights, {1, 60, 30}), scratch / "h.npy"), "");
  EvalOptions options;
  options.graph = scratch / "g.json", options.truth = scratch / "truth", options.trajectory = scratch / "t.tum";
  options.grid = scratch / "grid.layers.json";
  return options;
}

TEST(Evaluate, AGridIsLaidOverTheTruthByTheTrajectory) {
  const Scratch scratch;
  EvalOptions options = turnedWorld(scratch);
  const auto evaluation = evaluate(options);
  ASSERT_TRUE(evaluation) << evaluation.error;
  ASSERT_TRUE(evaluation->grid && evaluation->grid->local);
  for (const WalkScore& score : {evaluation->grid->whole, *evaluation->grid->local}) {
    EXPECT_EQ(score.confusion[0][0], 1799U);
    EXPECT_EQ(score.confusion[1][1], 1U);
    EXPECT_EQ(score.strict.precision, 1.0);
    EXPECT_EQ(score.strict.recall, 1.0);
  }
  const auto json = toJson(*evaluation)["grid"];
  EXPECT_EQ(json["local"]["strict"]["recall"], 1.0);
  EXPECT_EQ(json["causes"].dump(), R"([{"cells":1,"name":"an edge","walkable":0}])");
  EXPECT_NE(formatTable(*evaluation).find("cell for cell"), std::string::npos);
  options.trajectory.clear();
  EXPECT_LT(evaluate(options)->grid->whole.strict.recall, 0.5);
  options.grid = scratch / "none";
  EXPECT_FALSE(evaluate(options));
}

TEST(Evaluate, PlansAreAskedForInTheMapsFrameAndScoredAfterwards) {
  const Scratch scratch;
  EvalOptions options = turnedWorld(scratch);
  options.plans = 5, options.plan_requests = scratch / "r.jsonl";
  ASSERT_TRUE(evaluate(options));
  const auto requests = readPlanRequests(scratch / "r.jsonl");
  ASSERT_TRUE(requests) << requests.error;
  ASSERT_EQ(requests->size(), 5U);
  std::string answers;
  for (const PlanPair& r : *requests) {
    EXPECT_TRUE(r.from.x() > 0.4 && r.from.x() < 2.6 && r.from.y() > -3.1 && r.from.y() < 2.1) << r.from;
    const auto text = [](const Vec3& p) {
      return "[" + std::to_string(p.x()) + "," + std::to_string(p.y()) + "," + std::to_string(p.z()) + "]";
    };
    answers += "{\"found\":true,\"path\":[" + text(r.from) + "," + text(r.to) + "]}\n";
  }
  options.plans = 0, options.plan_answers = scratch / "a.jsonl";
  writeText(options.plan_answers, answers);
  const auto evaluation = evaluate(options);
  ASSERT_TRUE(evaluation) << evaluation.error;
  EXPECT_EQ(evaluation->plans->found, 5U);
  EXPECT_EQ(evaluation->plans->off_ground, 0U);
  EXPECT_LE(evaluation->plans->worst_ratio, 1.0 + 1e-6);
  EXPECT_EQ(toJson(*evaluation)["plans"]["share"], 1.0);
  writeText(options.plan_answers, answers + "{\"found\":false}\n");
  EXPECT_NE(evaluate(options).error.find("6 answers to 5 requests"), std::string::npos);
}

}  // namespace
}  // namespace hgg::walk_eval_test
