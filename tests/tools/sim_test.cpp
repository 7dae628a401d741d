#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "bus/codec.h"
#include "bus/log.h"
#include "sim/raycast.h"
#include "sim/simulate.h"
#include "tools/scratch.h"
#include "truth/poses.h"

namespace hgg {
namespace {

const Progress kQuiet = [](std::size_t, std::size_t) {};

SimOptions smallDrive() {
  SimOptions options;
  options.frames = 12;
  options.rate_hz = 1.0;
  options.lidar.beams = 16;
  options.lidar.columns = 360;
  return options;
}

struct LoggedFrame {
  OdometrySample odometry;
  SemanticCloud cloud;
};

std::vector<LoggedFrame> readFrames(const std::filesystem::path& log) {
  auto reader = LogReader::open(log.string());
  EXPECT_TRUE(reader) << reader.error;
  std::vector<LoggedFrame> frames;
  while (auto event = reader->next()) {
    if (event->channel == "POSE_ODOM") {
      frames.push_back({*decodePose(event->data), {}});
    } else {
      EXPECT_EQ(event->channel, "LIDAR_SEMANTIC");
      frames.back().cloud = *decodeSemanticCloud(event->data, 0.0F);
      EXPECT_EQ(frames.back().cloud.utime_us, frames.back().odometry.utime_us);
      EXPECT_EQ(event->timestamp_us, frames.back().cloud.utime_us);
    }
  }
  return frames;
}

TEST(Sim, TruthRecomputedFromTheLogEqualsTheTruthFile) {
  const Scratch scratch;
  SimOptions options = smallDrive();
  options.instances = true;
  options.odometry = driftOf(2.0);  // the truth must come from the true poses, not from these
  const auto drive = simulate(makeYard(5), options, scratch / "log", kQuiet);
  ASSERT_TRUE(drive) << drive.error;
  ASSERT_EQ(writeTruth(drive->objects, drive->T_map_body, scratch / "truth"), "");

  const auto poses = readPoses(scratch / "truth/poses.txt");
  const auto truth = readTruthObjects(scratch / "truth/gt_objects.json");
  const auto frames = readFrames(scratch / "log");
  ASSERT_TRUE(poses && truth);
  ASSERT_EQ(frames.size(), 12u);
  ASSERT_EQ(poses->size(), 12u);
  std::map<std::uint32_t, std::vector<Vec3>> points;
  std::map<std::uint32_t, std::set<std::size_t>> seen_in;
  std::map<std::uint32_t, ClassId> labels;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    for (const Point& p : frames[i].cloud.points) {
      points[p.instance].push_back((*poses)[i] * Vec3(p.x, p.y, p.z));
      seen_in[p.instance].insert(i);
      labels[p.instance] = p.label;
    }
  }
  ASSERT_GT(truth->size(), 20u);
  for (const TruthObject& object : *truth) {
    const auto id = static_cast<std::uint32_t>(object.id);
    const Belief expected = beliefFromPoints(points[id]);
    EXPECT_EQ(object.label, labels[id]);
    EXPECT_EQ(object.belief.kappa, expected.kappa);
    EXPECT_EQ(object.frames, static_cast<std::int64_t>(seen_in[id].size()));
    EXPECT_FALSE(object.dynamic);
    EXPECT_LT((object.belief.mean - expected.mean).norm(), 1e-9);
    EXPECT_LT((object.belief.cov - expected.cov).norm(), 1e-9);
    points.erase(id);
  }
  const std::set<ClassId> stuff{40, 50, 51, 70, 72};
  for (const auto& [id, rest] : points) {
    EXPECT_TRUE(stuff.contains(labels[id])) << "a thing is missing in the truth: id " << id;
  }
}

TEST(Sim, SameSeedSameBytesOtherSeedOtherWorld) {
  const Scratch scratch;
  SimOptions options = smallDrive();
  options.frames = 2;
  ASSERT_TRUE(simulate(makeYard(1), options, scratch / "a", kQuiet));
  ASSERT_TRUE(simulate(makeYard(1), options, scratch / "b", kQuiet));
  ASSERT_TRUE(simulate(makeYard(2), options, scratch / "world", kQuiet));
  options.seed = 2;
  ASSERT_TRUE(simulate(makeYard(1), options, scratch / "noise", kQuiet));
  const std::string bytes = readText(scratch / "a");
  EXPECT_EQ(bytes, readText(scratch / "b"));
  EXPECT_NE(bytes, readText(scratch / "world"));
  EXPECT_NE(bytes, readText(scratch / "noise"));
}

TEST(Sim, InstancesAreOffUnlessAskedFor) {
  const Scratch scratch;
  SimOptions options = smallDrive();
  options.frames = 1;
  ASSERT_TRUE(simulate(makeYard(1), options, scratch / "log", kQuiet));
  const auto frames = readFrames(scratch / "log");
  for (const Point& p : frames[0].cloud.points) {
    ASSERT_EQ(p.instance, 0u);
  }
}

TEST(Sim, OdometryIsTheTruthUnlessDisturbed) {
  const Scratch scratch;
  SimOptions options = smallDrive();
  const auto drive = simulate(makeYard(1), options, scratch / "log", kQuiet);
  ASSERT_TRUE(drive);
  EXPECT_TRUE(drive->T_map_body[0].isApprox(Pose::Identity()));
  const auto frames = readFrames(scratch / "log");
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_TRUE(frames[i].odometry.T_odom_body.isApprox(drive->T_map_body[i], 1e-9)) << "frame " << i;
  }
}

TEST(Sim, DriftIsItsPercentOfTheWay) {
  std::vector<Pose> straight(101, Pose::Identity());
  for (std::size_t i = 0; i < straight.size(); ++i) {
    straight[i].translation().x() = static_cast<double>(i);
  }
  const auto scaled = disturbOdometry(straight, {.scale = 0.01}, 1);
  EXPECT_NEAR(scaled.back().translation().x(), 101.0, 1e-9);
  const auto turned = disturbOdometry(straight, {.yaw_deg_per_m = 0.1}, 1);
  EXPECT_NEAR(Eigen::AngleAxisd(turned.back().linear()).angle(), 10.0 * M_PI / 180.0, 1e-9);
}

TEST(Sim, ScanFollowsTheBeamsAndTheirNoise) {
  World world;
  addObject(world, 40, false, {Plane{Vec3(0, 0, -2), Vec3::UnitZ()}});
  LidarModel lidar;
  lidar.elevation_min_deg = -30;
  lidar.elevation_max_deg = -10;
  lidar.range_noise = 0.05;
  const auto directions = beamDirections(lidar);
  const auto points = scan(world, lidar, directions, Pose::Identity(), {7, 0});
  ASSERT_EQ(points.size(), directions.size());
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 p(points[i].x, points[i].y, points[i].z);
    ASSERT_LT(p.cross(directions[i]).norm(), 1e-5);
    const double error = p.norm() - 2.0 / -directions[i].z();
    sum += error;
    squares += error * error;
  }
  const auto n = static_cast<double>(points.size());
  EXPECT_NEAR(sum / n, 0.0, 0.002);
  EXPECT_NEAR(std::sqrt(squares / n), 0.05, 0.001);
}

TEST(Sim, PointsOutOfRangeAreNotReturned) {
  World world;
  addObject(world, 40, false, {Plane{Vec3(0, 0, -2), Vec3::UnitZ()}});
  LidarModel lidar;
  lidar.elevation_min_deg = -80;
  lidar.elevation_max_deg = -1;
  lidar.range_min = 3.0;
  lidar.range_max = 20.0;
  lidar.range_noise = 0.0;
  const auto points = scan(world, lidar, beamDirections(lidar), Pose::Identity(), {7, 0});
  ASSERT_FALSE(points.empty());
  for (const Point& p : points) {
    const double range = Vec3(p.x, p.y, p.z).norm();
    ASSERT_GE(range, 3.0 - 1e-5);
    ASSERT_LE(range, 20.0 + 1e-5);
  }
}

TEST(Sim, YardIsALapWithoutCollisions) {
  const Scene yard = makeYard(1);
  for (double time = 0; time < 20.0; time += 0.1) {
    const Vec3 at = yard.T_world_body(time).translation();
    const double speed = (yard.T_world_body(time + 0.01).translation() - at).head<2>().norm() / 0.01;
    ASSERT_GT(speed, 1.0);
    ASSERT_LT(speed, 5.0);
    for (int i = 0; i < 36; ++i) {
      const auto hit = castRay(yard.world, {at, Vec3(std::cos(i * M_PI / 18), std::sin(i * M_PI / 18), 0)});
      ASSERT_TRUE(!hit || hit->range > 1.5) << "object " << hit->object << " is on the road at " << time << " s";
    }
  }
  EXPECT_LT((yard.T_world_body(20.0).translation() - yard.T_world_body(0.0).translation()).norm(), 0.1);
}

TEST(Sim, UnknownWorldIsNotMade) { EXPECT_FALSE(makeScene("atlantis", 1)); }

}  // namespace
}  // namespace hgg
