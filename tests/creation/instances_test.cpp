#include "creation/instances.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <numbers>
#include <set>

#include "brute_force.h"
#include "test_scene.h"

namespace hgg::instances_test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInf = std::numeric_limits<float>::infinity();

Instances segment(const Frame& frame, const Config& config = {}, const Pose& T_map_body = Pose::Identity()) {
  return segmentInstances(frame, T_map_body, testClasses(), config);
}

Frame lineOf(int n, ClassId label, const Vec3& start, const Vec3& step, std::uint32_t instance = 0) {
  Frame frame;
  for (int i = 0; i < n; ++i) {
    frame.points.push_back(pointAt(start + i * step, label, instance));
  }
  return frame;
}

void append(Frame& frame, const Frame& more) {
  frame.points.insert(frame.points.end(), more.points.begin(), more.points.end());
}

TEST(SegmentInstances, NonFinitePointsAreDroppedAndCounted) {
  Frame frame = lineOf(10, kCar, Vec3(5, 0, 0), Vec3(0.1, 0, 0));
  for (const float bad : {kNan, kInf, -kInf}) {
    frame.points.push_back({bad, 0, 0, 0, kCar});
    frame.points.push_back({5, bad, 0, 0, kCar});
    frame.points.push_back({5, 0, bad, 0, kRoad});
  }
  frame.points.push_back({3e38F, 3e38F, 3e38F, 0, kCar});  // finite, but not its square
  const Instances out = segment(frame);
  EXPECT_EQ(out.nonfinite_points, 10U);
  EXPECT_EQ(out.points.size(), 10U);
  ASSERT_EQ(out.list.size(), 1U);
  EXPECT_EQ(out.list[0].end - out.list[0].begin, 10U);
}

TEST(SegmentInstances, NoPointsAndOnlyBadPointsGiveNothing) {
  EXPECT_TRUE(segment({}).list.empty());
  Frame frame;
  frame.points = {{kNan, kNan, kNan, 0, kCar}, {0, 0, 0, 0, kCar}, {5, 0, 0, 0, 999}};
  const Instances out = segment(frame);
  EXPECT_TRUE(out.list.empty());
  EXPECT_TRUE(out.points.empty());
}

TEST(SegmentInstances, PointsOutsideTheRangeAreDroppedAndCounted) {
  Config config;
  config.frame.range_min = 2, config.frame.range_max = 8;
  Frame frame;
  for (const float x : {0.0F, 1.99F, 2.0F, -2.0F, 5.0F, 8.0F, -8.0F, 8.01F, 100.0F}) {
    frame.points.push_back({0, x, 0, 0, kCar});
  }
  const Instances out = segment(frame, config);
  EXPECT_EQ(out.out_of_range_points, 4U);
  EXPECT_EQ(out.points.size(), 5U);
}

TEST(SegmentInstances, ALabelOutsideTheTableIsCountedAndTreatedAsIgnore) {
  Frame frame = lineOf(10, kCar, Vec3(5, 0, 0), Vec3(0.1, 0, 0));
  append(frame, lineOf(20, 999, Vec3(5, 1, 0), Vec3(0.1, 0, 0)));
  append(frame, lineOf(30, kUnlabeled, Vec3(5, 2, 0), Vec3(0.1, 0, 0)));
  const Instances out = segment(frame);
  EXPECT_EQ(out.unknown_labels, 20U);
  EXPECT_EQ(out.ignored_points, 30U);
  EXPECT_EQ(out.list.size(), 1U);
}

TEST(SegmentInstances, ClustersAndTilesBelowMinPointsAreDropped) {
  for (const int missing : {0, 1}) {
    Frame frame = lineOf(5 - missing, kCar, Vec3(5, 0, 0), Vec3(0.1, 0, 0));
    append(frame, lineOf(3 - missing, kRoad, Vec3(5, 2, 0), Vec3(0.1, 0, 0)));
    const Instances out = segment(frame);
    EXPECT_EQ(out.list.size(), missing == 0 ? 2U : 0U);
    EXPECT_EQ(out.points.size(), frame.points.size());  // dropped clusters' points stay, without an instance
  }
}

TEST(SegmentInstances, InstanceIdsSplitWhatTouches) {
  Frame frame;
  for (int i = 0; i < 40; ++i) {  // interleaved, centimetres apart
    frame.points.push_back({5 + 0.01F * static_cast<float>(i), 0, 0, 1U + static_cast<std::uint32_t>(i % 2), kCar});
  }
  const Instances out = segment(frame);
  ASSERT_EQ(out.list.size(), 2U);
  EXPECT_EQ(out.list[0].instance, 1U);
  EXPECT_EQ(out.list[1].instance, 2U);
  EXPECT_EQ(out.list[0].end - out.list[0].begin, 20U);
}

TEST(SegmentInstances, InstanceIdsNeverJoinWhatIsApart) {
  Frame frame = lineOf(10, kCar, Vec3(5, 0, 0), Vec3(0.1, 0, 0), 7);
  append(frame, lineOf(10, kCar, Vec3(20, 0, 0), Vec3(0.1, 0, 0), 7));
  EXPECT_EQ(segment(frame).list.size(), 2U);
}

TEST(SegmentInstances, ClassesStayApartAndFoldedLabelsJoin) {
  Frame frame;
  for (int i = 0; i < 30; ++i) {
    frame.points.push_back({5 + 0.01F * static_cast<float>(i), 0, 0, 0,
                            i % 3 == 0   ? kCar
                            : i % 3 == 1 ? kMovingCar
                                         : kPole});
  }
  const Instances out = segment(frame);
  ASSERT_EQ(out.list.size(), 2U);
  EXPECT_EQ(out.list[0].label, kCar);
  EXPECT_EQ(out.list[0].end - out.list[0].begin, 20U);
  EXPECT_EQ(out.list[1].label, kPole);
}

TEST(SegmentInstances, TheClusterRadiusFollowsTheBeamSpacing) {
  Config config;
  config.creation.beam_spacing_deg = 0.45;
  config.creation.beam_factor = 2;
  const double reach = 2 * 0.45 * std::numbers::pi / 180 * 40;  // 0.63 m at 40 m, where the class alone bridges 0.2 m
  for (const double share : {0.98, 1.02}) {
    const Frame frame = lineOf(12, kPole, Vec3(40, 0, -3), Vec3(0, 0, share * reach));
    EXPECT_EQ(segment(frame, config).list.size(), share < 1 ? 1U : 0U) << share;
  }
  config.creation.beam_spacing_deg = 0;
  EXPECT_EQ(segment(lineOf(12, kPole, Vec3(40, 0, -3), Vec3(0, 0, 0.98 * reach)), config).list.size(), 0U);
}

/// Instances as sets of points, without their order.
using PointSet = std::multiset<std::array<float, 3>>;

std::multiset<PointSet> setsOf(const Instances& instances) {
  std::multiset<PointSet> sets;
  for (const Instance& instance : instances.list) {
    PointSet set;
    for (std::size_t i = instance.begin; i < instance.end; ++i) {
      set.insert({instances.points[i][0], instances.points[i][1], instances.points[i][2]});
    }
    sets.insert(std::move(set));
  }
  return sets;
}

/// The oracle: points grouped by class, segmenter instance and tile; things by the components of all pairs.
std::multiset<PointSet> partitionByBruteForce(const Frame& frame, const Pose& T_map_body, const Config& config) {
  const ClassTable classes = testClasses();
  std::map<std::tuple<ClassId, std::uint32_t, Tile>, std::vector<PackedPoint>> groups;
  for (const Point& p : frame.points) {
    const Vec3 v(p.x, p.y, p.z);
    const ClassInfo& info = *classes.find(p.label);
    if (info.kind != ClassKind::kIgnore && v.norm() >= config.frame.range_min) {
      const bool stuff = info.kind == ClassKind::kStuff;
      const Tile tile = stuff ? tileOf(T_map_body * v, config.creation.tile_size) : Tile{};
      groups[{info.id, stuff ? 0 : p.instance, tile}].emplace_back(p.x, p.y, p.z, 0.0F);
    }
  }
  const double slope = config.creation.beam_factor * config.creation.beam_spacing_deg * std::numbers::pi / 180;
  std::multiset<PointSet> sets;
  for (const auto& [key, points] : groups) {
    const ClassInfo& info = *classes.find(std::get<0>(key));
    const RadiusLaw law{static_cast<float>(info.cluster_radius), static_cast<float>(slope)};
    const std::vector<std::int32_t> cluster =
        info.kind == ClassKind::kStuff ? std::vector<std::int32_t>(points.size(), 0) : clusterByBruteForce(points, law);
    std::map<std::int32_t, PointSet> parts;
    for (std::size_t i = 0; i < points.size(); ++i) {
      parts[cluster[i]].insert({points[i][0], points[i][1], points[i][2]});
    }
    for (const auto& [id, part] : parts) {
      if (part.size() >= static_cast<std::size_t>(info.min_points)) {
        sets.insert(part);
      }
    }
  }
  return sets;
}

TEST(SegmentInstances, EqualBruteForcePartitionOfEveryClassInstanceAndTile) {
  std::mt19937 random(1);
  const ClassId labels[] = {kCar, kMovingCar, kPole, kRoad, kUnlabeled};
  for (int round = 0; round < 10; ++round) {
    Frame frame;
    for (int k = 0; k < 100; ++k) {
      const ClassId label = labels[below(random, 5)];
      const int points = 1 + static_cast<int>(below(random, 25));
      addBox(frame, random, points, label, randomVector(random, 20), randomVector(random, 1.5), below(random, 3));
    }
    const Pose T_map_body = randomPose(random, 100);
    const std::multiset<PointSet> expected = partitionByBruteForce(frame, T_map_body, {});
    EXPECT_GT(expected.size(), 20U);
    EXPECT_EQ(setsOf(segment(frame, {}, T_map_body)), expected) << "round " << round;
  }
}

TEST(SegmentInstances, TheSamePatchOfGroundLandsInTheSameTileFromAnyPose) {
  std::mt19937 random(2);
  const Config config;
  for (int round = 0; round < 200; ++round) {
    const Tile tile{static_cast<int>(below(random, 400)) - 200, static_cast<int>(below(random, 400)) - 200,
                    static_cast<int>(below(random, 4)) - 2};
    const Vec3 centre = Vec3(tile.x, tile.y, tile.z) * config.creation.tile_size;
    for (int view = 0; view < 3; ++view) {
      Pose T_map_body = randomPose(random, 1);
      T_map_body.translation() = centre + randomVector(random, 30);
      Frame frame;
      while (frame.points.size() < 20) {
        const Vec3 p_body = T_map_body.inverse() * (centre + randomVector(random, 0.499 * config.creation.tile_size));
        if (p_body.norm() > 1.1) {
          frame.points.push_back(pointAt(p_body, kRoad));
        }
      }
      const Instances out = segment(frame, config, T_map_body);
      ASSERT_EQ(out.list.size(), 1U) << "round " << round;
      EXPECT_EQ(out.list[0].tile, tile);
      EXPECT_TRUE(out.list[0].stuff);
    }
  }
}

TEST(SegmentInstances, StuffIgnoresInstanceIds) {
  Frame frame = lineOf(5, kRoad, Vec3(2, 0, 0), Vec3(0.1, 0, 0), 1);
  append(frame, lineOf(5, kRoad, Vec3(3, 0, 0), Vec3(0.1, 0, 0), 2));
  EXPECT_EQ(segment(frame).list.size(), 1U);
}

TEST(SegmentInstances, EveryPointIsAccountedFor) {
  std::mt19937 random(3);
  Frame frame;
  for (int i = 0; i < 5000; ++i) {
    const float values[] = {kNan, kInf, 0, 500};
    const float x = below(random, 10) == 0 ? values[below(random, 4)] : static_cast<float>(uniform(random, -60, 60));
    frame.points.push_back(
        {x, static_cast<float>(uniform(random, -60, 60)), 0, 0, static_cast<ClassId>(below(random, 60))});
  }
  const Instances out = segment(frame);
  EXPECT_EQ(
      out.points.size() + out.nonfinite_points + out.out_of_range_points + out.ignored_points + out.unknown_labels,
      5000U);
  EXPECT_GT(out.nonfinite_points, 0U);
  EXPECT_GT(out.out_of_range_points, 0U);
}

TEST(SegmentInstances, AnAbsurdPoseGivesStuffSomeTileAndNoCrash) {
  Pose T = Pose::Identity();
  T.translation() = Vec3(1e300, -1e300, 1e15);
  const Instances out = segment(lineOf(50, kRoad, Vec3(5, 0, 0), Vec3(0.1, 0, 0)), {}, T);
  EXPECT_EQ(out.points.size(), 50U);
}

TEST(TileOf, CellZeroIsCentredOnTheOrigin) {
  EXPECT_EQ(tileOf(Vec3(4.9, -4.9, 0), 10), (Tile{0, 0, 0}));
  EXPECT_EQ(tileOf(Vec3(5.1, -5.1, 14.9), 10), (Tile{1, -1, 1}));
  EXPECT_EQ(tileOf(Vec3(-1.6, 0, 0), 3), (Tile{-1, 0, 0}));
}

}  // namespace
}  // namespace hgg::instances_test
