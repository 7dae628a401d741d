// Ways over the truth, and plans held against them.
#include <gtest/gtest.h>

#include <cmath>

#include "eval/plans.h"
#include "tools/scratch.h"

namespace hgg::plans_eval_test {
namespace {

/// 10 x 6 m of seen floor at 0, from (0, 0).
WalkGrid floorTruth() {
  WalkGrid grid;
  grid.width = 100, grid.height = 60;
  grid.known.assign(grid.cells(), 1);
  for (std::size_t cell = 0; cell <= grid.cells(); ++cell) {
    grid.first.push_back(static_cast<std::uint32_t>(cell));
  }
  grid.surfaces.assign(grid.cells(), {0.0F, Standing::kFree, false, 1});
  return grid;
}

void wall(WalkGrid& grid, int x, int y0, int y1) {
  for (int y = y0; y < y1; ++y) {
    grid.surfaces[grid.at(x, y)].standing = Standing::kBlocked;
  }
}

std::uint32_t at(const WalkGrid& grid, double x, double y) { return grid.first[*grid.cellOf(x, y)]; }

const Laying kAsItIs{Pose::Identity()};

TEST(WalkPaths, AStraightWayIsAtMostThreePercentLonger) {
  const WalkGrid grid = floorTruth();
  const WalkPaths paths(grid, {});
  for (const auto& [x, y] : {std::pair{9.05, 1.05}, {9.05, 4.95}, {3.15, 4.95}, {5.05, 3.55}, {1.05, 4.05}}) {
    const double straight = std::hypot(x - 1.05, y - 1.05);
    const auto length = paths.shortest(at(grid, 1.05, 1.05), at(grid, x, y));
    ASSERT_TRUE(length);
    EXPECT_GE(*length, straight - 1e-9);
    EXPECT_LE(*length, 1.03 * straight);
  }
}

TEST(WalkPaths, TheRobotAndItsMarginStayAwayFromTheEdge) {
  const WalkGrid grid = floorTruth();
  const WalkPaths paths(grid, {});
  EXPECT_TRUE(paths.shortest(at(grid, 0.45, 0.45), at(grid, 5.05, 0.45)));
  EXPECT_FALSE(paths.shortest(at(grid, 0.35, 0.45), at(grid, 5.05, 0.45)));
}

TEST(WalkPaths, GoesRoundAWallAndThroughADoorThatIsWideEnough) {
  WalkGrid grid = floorTruth();
  wall(grid, 50, 0, 50);
  const auto around = WalkPaths(grid, {}).shortest(at(grid, 4.05, 1.05), at(grid, 6.05, 1.05));
  ASSERT_TRUE(around);
  EXPECT_NEAR(*around, 2.0 * std::hypot(0.55, 4.4) + 0.9, 0.25);  // over the wall's end, 0.45 m away from it
  for (int y = 20; y < 29; ++y) {
    grid.surfaces[grid.at(50, y)].standing = Standing::kFree;  // 0.9 m
  }
  const auto through = WalkPaths(grid, {}).shortest(at(grid, 4.05, 1.05), at(grid, 6.05, 1.05));
  ASSERT_TRUE(through);
  EXPECT_LT(*through, *around - 3.0);
  wall(grid, 50, 20, 22);  // 0.7 m
  EXPECT_NEAR(WalkPaths(grid, {}).shortest(at(grid, 4.05, 1.05), at(grid, 6.05, 1.05)).value_or(0.0), *around, 1e-9);
}

TEST(WalkPaths, GroundThatWasNotSeenIsNoWay) {
  WalkGrid grid = floorTruth();
  for (int y = 0; y < 60; ++y) {
    for (int x = 45; x < 49; ++x) {
      grid.surfaces[grid.at(x, y)].returns = 0;  // as between two rings of a LiDAR
    }
  }
  EXPECT_TRUE(WalkPaths(grid, {}).shortest(at(grid, 2.05, 1.05), at(grid, 8.05, 1.05)));
  for (int y = 0; y < 60; ++y) {
    for (int x = 45; x < 52; ++x) {
      grid.surfaces[grid.at(x, y)].returns = 0;
    }
  }
  EXPECT_FALSE(WalkPaths(grid, {}).shortest(at(grid, 2.05, 1.05), at(grid, 8.05, 1.05)));
}

TEST(WalkPaths, StairsAreClimbedAndCliffsAreNot) {
  for (const float rise : {0.15F, 0.25F}) {
    WalkGrid grid = floorTruth();
    for (int y = 0; y < 60; ++y) {
      for (int x = 40; x < 100; ++x) {
        grid.surfaces[grid.at(x, y)].height = rise * static_cast<float>(std::min((x - 40) / 3 + 1, 5));
      }
    }
    EXPECT_EQ(WalkPaths(grid, {}).shortest(at(grid, 2.05, 3.05), at(grid, 8.05, 3.05)).has_value(), rise < 0.2F);
  }
}

TEST(Plans, DrawnPairsAreTheSameEveryTimeAndHaveAWay) {
  WalkGrid grid = floorTruth();
  wall(grid, 30, 0, 60);
  grid.T_grid_map.translation() = Vec3(1, 2, 3);
  const auto requests = drawPlans(grid, {}, kAsItIs, 20, 1), again = drawPlans(grid, {}, kAsItIs, 20, 1);
  ASSERT_EQ(requests.size(), 20U);
  for (std::size_t i = 0; i < requests.size(); ++i) {
    EXPECT_EQ(requests[i].from, again[i].from);
    EXPECT_GE(requests[i].shortest, 2.0);
    for (const Vec3& p : {requests[i].from, requests[i].to}) {
      EXPECT_DOUBLE_EQ(p.z(), -3.0);
      EXPECT_GT(p.x() + 1.0, 3.4) << "the larger side of the wall";
    }
  }
  EXPECT_NE(requests[0].from, drawPlans(grid, {}, kAsItIs, 20, 2)[0].from);
  wall(grid, 65, 0, 60), wall(grid, 80, 0, 60), wall(grid, 48, 0, 60), wall(grid, 10, 0, 60), wall(grid, 20, 0, 60);
  for (int x = 0; x < 100; x += 5) {
    wall(grid, x, 0, 60);
  }
  EXPECT_TRUE(drawPlans(grid, {}, kAsItIs, 20, 1).empty());
}

TEST(Plans, RequestsAndAnswersAreFiles) {
  const Scratch scratch;
  const std::vector<PlanPair> requests{{{1, 2, 3}, {4, 5, 6.125}, 7.5}};
  ASSERT_EQ(writePlanRequests(requests, scratch / "r.jsonl"), "");
  EXPECT_EQ(readText(scratch / "r.jsonl"), "{\"from\":[1.0,2.0,3.0],\"shortest\":7.5,\"to\":[4.0,5.0,6.125]}\n");
  const auto read = readPlanRequests(scratch / "r.jsonl");
  ASSERT_TRUE(read) << read.error;
  EXPECT_EQ(read->at(0).to, requests[0].to);
  writeText(scratch / "a.jsonl",
            "{\"found\":false,\"reason\":\"no\"}\n{\"found\":true,\"path\":[[1,2,3],[4,5,6]],\"length\":5.2}\n");
  const auto answers = readPlanAnswers(scratch / "a.jsonl");
  ASSERT_TRUE(answers) << answers.error;
  EXPECT_FALSE(answers->at(0).found);
  EXPECT_EQ(answers->at(1).path[1], Vec3(4, 5, 6));
  writeText(scratch / "a.jsonl", "{\"found\":true,\"path\":[[1,2]]}\n");
  EXPECT_FALSE(readPlanAnswers(scratch / "a.jsonl"));
  EXPECT_FALSE(readPlanAnswers(scratch / "none.jsonl"));
}

TEST(Plans, WhatAPathMeetsIsTold) {
  WalkGrid grid = floorTruth();
  wall(grid, 50, 0, 40);
  const Vec3 from(2.05, 2.05, 0), to(8.05, 2.05, 0);
  const PlanPair request{from, to, 8.0};
  const PlanAnswer around{true, {from, {5.0, 4.6, 0.1}, to}}, through{true, {from, to}},
      in_the_air{true, {from, {5.0, 4.6, 0.5}, to}}, elsewhere{true, {from, {5.0, 4.6, 0}}}, none{false, {}};
  const PlanScore score =
      scorePlans(std::vector(5, request), {around, through, in_the_air, elsewhere, none}, grid, kAsItIs);
  EXPECT_EQ(score.asked, 5U);
  EXPECT_EQ(score.found, 3U);
  EXPECT_EQ(score.through_blocked, 1U);
  EXPECT_EQ(score.off_ground, 1U);
  EXPECT_EQ(score.longer, 0U);
  const double leg = std::hypot(2.95, 2.55), other = std::hypot(3.05, 2.55);
  EXPECT_NEAR(
      score.mean_ratio,
      (std::hypot(leg, 0.1) + std::hypot(other, 0.1) + 6.0 + std::hypot(leg, 0.5) + std::hypot(other, 0.5)) / 24.0,
      1e-9);
  const PlanScore detour = scorePlans({{from, to, 6.0}}, {around}, grid, kAsItIs);
  EXPECT_EQ(detour.longer, 1U);
  EXPECT_TRUE(std::isnan(scorePlans({request}, {none}, grid, kAsItIs).mean_ratio));
}

}  // namespace
}  // namespace hgg::plans_eval_test
