#include "publish/health.h"

#include <gtest/gtest.h>

#include "map/test_map.h"

namespace hgg::health_test {
namespace {

TEST(Health, StatusDescribesTheMap) {
  std::mt19937 random(1);
  MapNode car = nodeAt(10, Vec3(0, 0, 0));
  car.geometry = shareLeaves(Leaves(5, randomLeaf(random)));
  const Map map = mapOf({car, nodeAt(10, Vec3(5, 0, 0))});
  Status status;
  describeMap(map, status);
  EXPECT_EQ(status.objects, 2);
  EXPECT_EQ(status.leaves, 5);
  EXPECT_EQ(status.revision, map.revision());
  EXPECT_DOUBLE_EQ(status.map_mb, map.megabytes());
}

TEST(Health, NothingWrongIsNothingToSay) {
  RunCounts counts;
  counts.frames = 10, counts.drops = {1, 1, 1}, counts.restarts = 2, counts.decode_errors = {{"cloud: truncated", 3}};
  EXPECT_TRUE(describeTroubles(counts, counts).empty());
}

TEST(Health, OfAnErrorThatGoesOnTheNewOnesAndAllAreTold) {
  RunCounts before, now;
  before.decode_errors = {{"cloud: truncated", 3}};
  now.decode_errors = {{"cloud: truncated", 5}, {"odometry: truncated", 1}};
  EXPECT_EQ(describeTroubles(before, now),
            (std::vector<std::string>{"2 messages unreadable: cloud: truncated (5 in all)",
                                      "1 messages unreadable: odometry: truncated (1 in all)"}));
}

}  // namespace
}  // namespace hgg::health_test
