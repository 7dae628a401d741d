#include "sim/simulate.h"

#include <gtest/gtest.h>

#include <bot_core/pointcloud2_t.hpp>
#include <cmath>
#include <cstring>
#include <map>
#include <set>

#include "bus/codec.h"
#include "bus/log.h"
#include "sim/motion.h"
#include "tools/scratch.h"
#include "truth/poses.h"

namespace hgg::simulate_test {
namespace {

const Progress kQuiet = [](std::size_t, std::size_t) {};

SimOptions smallDrive() {
  SimOptions options;
  options.frames = 12;
  options.rate_hz = 1.0;
  options.sensors.lidar = spinningLidar(16, false);
  options.sensors.lidar->columns = 360;
  options.odometry = OdometryErrors{};
  return options;
}

SimCamera small(SimCamera camera) {
  camera.model.fx /= 4, camera.model.fy /= 4, camera.model.width /= 4, camera.model.height /= 4;
  camera.model.cx = (camera.model.width - 1) / 2.0, camera.model.cy = (camera.model.height - 1) / 2.0;
  return camera;
}

SimOptions smallRig() {
  SimOptions options = smallDrive();
  for (const SimCamera& camera : rigCameras(2)) {
    options.sensors.cameras.push_back(small(camera));
  }
  return options;
}

SimOptions smallRgbd() {
  SimOptions options = smallDrive();
  options.sensors = {std::nullopt, {small(depthCamera())}};
  return options;
}

SimOptions poorDrive(SimOptions options) {
  options.cloud_labels = *labelPreset("poor", Segmented::kCloud);
  options.image_labels = *labelPreset("poor", Segmented::kImage);
  options.odometry = odometryPreset("poor");
  options.instances = true;
  return options;
}

/// The messages of a log by channel and time.
std::map<std::string, std::map<Micros, std::vector<std::uint8_t>>> readLog(const std::filesystem::path& log) {
  auto reader = LogReader::open(log.string());
  EXPECT_TRUE(reader) << reader.error;
  std::map<std::string, std::map<Micros, std::vector<std::uint8_t>>> channels;
  while (auto event = reader->next()) {
    channels[event->channel][event->timestamp_us] = event->data;
  }
  return channels;
}

std::map<Micros, std::vector<std::uint8_t>> readChannel(const std::filesystem::path& log, const std::string& name) {
  return readLog(log)[name];
}

std::vector<SemanticCloud> semanticClouds(const std::filesystem::path& log) {
  std::vector<SemanticCloud> clouds;
  for (const auto& [utime_us, message] : readChannel(log, "LIDAR_SEMANTIC")) {
    clouds.push_back(*decodeSemanticCloud(message, 0.0F));
    EXPECT_EQ(clouds.back().utime_us, utime_us);
  }
  return clouds;
}

/// The "time" field of a cloud, as another program would read it; empty when there is none.
std::vector<float> timesOf(const std::vector<std::uint8_t>& message) {
  bot_core::pointcloud2_t cloud;
  EXPECT_GT(cloud.decode(message.data(), 0, static_cast<int>(message.size())), 0);
  std::vector<float> times;
  for (const auto& field : cloud.fields) {
    if (field.name != "time") {
      continue;
    }
    for (std::int32_t i = 0; i < cloud.width; ++i) {
      std::memcpy(&times.emplace_back(), cloud.data.data() + i * cloud.point_step + field.offset, sizeof(float));
    }
  }
  return times;
}

using PoseOf = std::function<Pose(std::size_t frame, std::size_t point)>;

/// Accumulates the instances of a log and holds them against the truth, to the last point.
void expectTruthOfLog(const std::vector<TruthObject>& truth, const std::vector<SemanticCloud>& clouds,
                      const PoseOf& T_map_body) {
  std::map<std::uint32_t, std::vector<Vec3>> points;
  std::map<std::uint32_t, std::set<std::size_t>> seen_in;
  std::map<std::uint32_t, ClassId> labels;
  for (std::size_t frame = 0; frame < clouds.size(); ++frame) {
    for (std::size_t i = 0; i < clouds[frame].points.size(); ++i) {
      const Point& p = clouds[frame].points[i];
      if (p.instance == 0) {
        continue;
      }
      points[p.instance].push_back(T_map_body(frame, i) * Vec3(p.x, p.y, p.z));
      seen_in[p.instance].insert(frame);
      labels[p.instance] = p.label;
    }
  }
  ASSERT_GT(truth.size(), 5u);
  EXPECT_EQ(truth.size(), points.size());
  for (const TruthObject& object : truth) {
    const auto id = static_cast<std::uint32_t>(object.id);
    const Belief expected = beliefFromPoints(points[id]);
    EXPECT_EQ(object.label, labels[id]);
    EXPECT_EQ(object.belief.kappa, expected.kappa);
    EXPECT_EQ(object.frames, static_cast<std::int64_t>(seen_in[id].size()));
    EXPECT_LT((object.belief.mean - expected.mean).norm(), 1e-9);
    EXPECT_LT((object.belief.cov - expected.cov).norm(), 1e-9);
  }
}

TEST(Simulate, TruthRecomputedFromTheLogEqualsTheTruthFile) {
  const Scratch scratch;
  SimOptions options = smallDrive();
  options.instances = true;
  options.odometry = odometryPreset("poor");  // the truth must come from the true poses, not from these
  const auto drive = simulate(makeYard(5), options, scratch / "log", kQuiet);
  ASSERT_TRUE(drive) << drive.error;
  ASSERT_EQ(writeTruth(drive->objects, drive->T_map_body, scratch / "truth"), "");
  const auto poses = readPoses(scratch / "truth/poses.txt");
  const auto truth = readTruthObjects(scratch / "truth/gt_objects.json");
  ASSERT_TRUE(poses && truth);
  ASSERT_EQ(poses->size(), 12u);
  expectTruthOfLog(*truth, semanticClouds(scratch / "log"),
                   [&](std::size_t frame, std::size_t) { return (*poses)[frame]; });
}

TEST(Simulate, CommonConfusionIsInTheLabelsAndNotInTheTruth) {
  const Scratch scratch;
  SimOptions options = smallDrive();
  options.cloud_labels = {};
  const Scene scene = makeYard(5);
  const auto clear = simulate(scene, options, scratch / "clear", kQuiet);
  options.cloud_labels.common = 0.3;
  const auto confused = simulate(scene, options, scratch / "confused", kQuiet);
  options.threads = 3;
  ASSERT_TRUE(simulate(scene, options, scratch / "again", kQuiet));
  ASSERT_TRUE(clear && confused);
  EXPECT_TRUE(readText(scratch / "confused") == readText(scratch / "again")) << "whatever the threads";
  ASSERT_EQ(clear->objects.size(), confused->objects.size());
  for (std::size_t i = 0; i < clear->objects.size(); ++i) {
    EXPECT_EQ(clear->objects[i].belief.mean, confused->objects[i].belief.mean);
  }
  const auto a = semanticClouds(scratch / "clear"), b = semanticClouds(scratch / "confused");
  std::size_t wrong = 0, points = 0;
  for (std::size_t f = 0; f < a.size(); ++f) {
    for (std::size_t i = 0; i < a[f].points.size(); ++i, ++points) {
      wrong += a[f].points[i].label != b[f].points[i].label ? 1 : 0;
    }
  }
  EXPECT_GT(wrong, points / 100);
  EXPECT_LT(wrong, points / 2);
}

TEST(Simulate, TruthOfADepthCameraIsThatOfItsLog) {
  const Scratch scratch;
  SimOptions options = smallRgbd();
  options.instances = true;
  ASSERT_GT(options.sensors.cameras[0].errors.mixed, 0.1);  // their pixels carry labels, but no instances
  const auto drive = simulate(makeYard(5), options, scratch / "log", kQuiet);
  ASSERT_TRUE(drive) << drive.error;
  expectTruthOfLog(drive->objects, semanticClouds(scratch / "log"),
                   [&](std::size_t frame, std::size_t) { return drive->T_map_body[frame]; });
}

TEST(Simulate, TruthOfADistortedLogIsThatOfItsPointsUndistorted) {
  const Scratch scratch;
  SimOptions options = smallDrive();
  options.instances = options.motion_distortion = true;
  const Scene scene = makeYard(5);
  const auto drive = simulate(scene, options, scratch / "log", kQuiet);
  ASSERT_TRUE(drive) << drive.error;
  std::vector<std::vector<float>> times;
  for (const auto& [utime_us, message] : readChannel(scratch / "log", "LIDAR_SEMANTIC")) {
    times.push_back(timesOf(message));
  }
  const Pose T_map_world = scene.T_world_body(0).inverse();
  expectTruthOfLog(drive->objects, semanticClouds(scratch / "log"), [&](std::size_t frame, std::size_t i) {
    EXPECT_LE(times[frame][i], 0.0F);
    EXPECT_GT(times[frame][i], -1.0F);
    return T_map_world * scene.T_world_body(static_cast<double>(frame) + static_cast<double>(times[frame][i]));
  });
}

TEST(Simulate, LabelErrorsNeverReachTheTruth) {
  const Scratch scratch;
  const auto perfect = simulate(makeYard(5), smallDrive(), scratch / "perfect", kQuiet);
  const auto poor = simulate(makeYard(5), poorDrive(smallDrive()), scratch / "poor", kQuiet);
  ASSERT_EQ(perfect->objects.size(), poor->objects.size());
  for (std::size_t i = 0; i < perfect->objects.size(); ++i) {
    EXPECT_EQ(perfect->objects[i].label, poor->objects[i].label);
    EXPECT_EQ(perfect->objects[i].belief.mean, poor->objects[i].belief.mean);
  }
  EXPECT_FALSE(readText(scratch / "perfect") == readText(scratch / "poor"));
}

TEST(Simulate, SameSeedSameBytesWhateverTheThreads) {
  const Scratch scratch;
  for (const SimOptions& sensors : {smallDrive(), smallRig(), smallRgbd()}) {
    SimOptions options = poorDrive(sensors);
    options.frames = 3;
    options.motion_distortion = true;
    ASSERT_TRUE(simulate(makeYard(1), options, scratch / "a", kQuiet));
    options.threads = 2;
    ASSERT_TRUE(simulate(makeYard(1), options, scratch / "b", kQuiet));
    ASSERT_TRUE(simulate(makeYard(2), options, scratch / "world", kQuiet));
    options.seed = 2;
    ASSERT_TRUE(simulate(makeYard(1), options, scratch / "noise", kQuiet));
    const std::string bytes = readText(scratch / "a");
    EXPECT_TRUE(bytes == readText(scratch / "b"));
    EXPECT_FALSE(bytes == readText(scratch / "world"));
    EXPECT_FALSE(bytes == readText(scratch / "noise"));
  }
}

TEST(Simulate, TheWalkGridCountsTheReturnsOfTheLog) {
  const Scratch scratch;
  SimOptions options = smallDrive();
  options.motion_distortion = true;
  options.sensors.lidar->errors.noise = 0, options.sensors.lidar->errors.mixed = 0;
  const auto truth = simulate(makeYard(1), options, scratch / "log", kQuiet);
  ASSERT_TRUE(truth && truth->walk_grid);
  const WalkGrid& grid = *truth->walk_grid;
  std::vector<std::uint32_t> counted(grid.surfaces.size(), 0);
  const auto T_world_body = makeYard(1).T_world_body;
  std::size_t frame = 0;
  for (const auto& [utime_us, message] : readChannel(scratch / "log", "LIDAR_SEMANTIC")) {
    const auto cloud = decodeSemanticCloud(message, 0.0F);
    const std::vector<float> times = timesOf(message);
    for (std::size_t i = 0; i < times.size(); ++i) {
      const Point& q = cloud->points[i];
      const Vec3 p = T_world_body(static_cast<double>(frame) + static_cast<double>(times[i])) * Vec3(q.x, q.y, q.z);
      const auto cell = grid.cellOf(p.x(), p.y());
      for (std::size_t k = cell ? grid.first[*cell] : 0; cell && k < grid.first[*cell + 1]; ++k) {
        const double above = p.z() - static_cast<double>(grid.surfaces[k].height);
        counted[k] += above >= -0.05 && above <= 0.1 ? 1 : 0;
      }
    }
    ++frame;
  }
  std::size_t all = 0, apart = 0;
  for (std::size_t k = 0; k < counted.size(); ++k) {
    if (grid.surfaces[k].standing == Standing::kFree) {
      all += counted[k];
      apart += static_cast<std::size_t>(std::abs(static_cast<double>(counted[k]) - grid.surfaces[k].returns));
    }
  }
  EXPECT_GT(all, 3000U);
  EXPECT_LT(static_cast<double>(apart), 0.005 * static_cast<double>(all))
      << "more than rounding on faces that lie along the cells' edges";
  options.walk_grid = false;
  EXPECT_FALSE(simulate(makeYard(1), options, scratch / "log", kQuiet)->walk_grid);
}

TEST(Simulate, InstancesAreOffUnlessAskedFor) {
  const Scratch scratch;
  ASSERT_TRUE(simulate(makeYard(1), smallDrive(), scratch / "log", kQuiet));
  const auto clouds = semanticClouds(scratch / "log");
  for (const Point& p : clouds.front().points) {
    ASSERT_EQ(p.instance, 0u);
  }
}

TEST(Simulate, OdometryIsTheTruthUnlessDisturbed) {
  const Scratch scratch;
  const auto drive = simulate(makeYard(1), smallDrive(), scratch / "log", kQuiet);
  ASSERT_TRUE(drive);
  EXPECT_TRUE(drive->T_map_body[0].isApprox(Pose::Identity()));
  std::size_t frame = 0;
  for (const auto& [utime_us, message] : readChannel(scratch / "log", "POSE_ODOM")) {
    const auto sample = decodePose(message);
    EXPECT_EQ(sample->utime_us, 1'000'000 + static_cast<Micros>(frame) * 1'000'000);
    EXPECT_TRUE(sample->T_odom_body.isApprox(drive->T_map_body[frame++], 1e-9)) << "frame " << frame;
  }
  EXPECT_EQ(frame, 12u);
}

TEST(Simulate, MissingOdometryLeavesItsClouds) {
  const Scratch scratch;
  SimOptions options = smallDrive();
  options.odometry->dropout = 0.5;
  ASSERT_TRUE(simulate(makeYard(1), options, scratch / "log", kQuiet));
  auto channels = readLog(scratch / "log");
  EXPECT_EQ(channels["LIDAR_SEMANTIC"].size(), 12u);
  EXPECT_LT(channels["POSE_ODOM"].size(), 12u);
  EXPECT_EQ(channels["POSE_ODOM"].begin()->first, channels["LIDAR_SEMANTIC"].begin()->first);
  EXPECT_EQ(channels["POSE_ODOM"].rbegin()->first, channels["LIDAR_SEMANTIC"].rbegin()->first);
}

TEST(Simulate, TheScenesOwnOdometryIsTakenAsItIs) {
  const Scratch scratch;
  Scene scene = makeYard(1);
  scene.T_odom_body = [truth = scene.T_world_body](double t) { return truth(t) * Eigen::Translation3d(0.1 * t, 0, 0); };
  SimOptions options = smallDrive();
  options.odometry.reset();
  const auto drive = simulate(scene, options, scratch / "log", kQuiet);
  std::size_t frame = 0;
  for (const auto& [utime_us, message] : readChannel(scratch / "log", "POSE_ODOM")) {
    const Pose expected = drive->T_map_body[frame] * Eigen::Translation3d(0.1 * static_cast<double>(frame), 0, 0);
    EXPECT_TRUE(decodePose(message)->T_odom_body.isApprox(expected, 1e-9));
    ++frame;
  }
  EXPECT_EQ(frame, 12u);
}

TEST(Simulate, GaitRollsAndPitchesTruthAndOdometryAlike) {
  const Scratch scratch;
  SimOptions options = smallDrive();
  options.rate_hz = 7.0, options.frames = 60;
  options.gait_deg = 2.0;
  options.sensors.lidar->columns = 8;
  const auto drive = simulate(makeYard(1), options, scratch / "log", kQuiet);
  double steepest_deg = 0;
  for (const Pose& T_world_body : drive->T_world_body) {
    steepest_deg = std::max(steepest_deg, std::acos(T_world_body.linear()(2, 2)) * 180 / M_PI);
  }
  EXPECT_GT(steepest_deg, 1.5);
  EXPECT_LT(steepest_deg, 4.0);
  const auto odometry = readChannel(scratch / "log", "POSE_ODOM");
  EXPECT_TRUE(decodePose(odometry.rbegin()->second)->T_odom_body.isApprox(drive->T_map_body.back(), 1e-9));
}

TEST(Simulate, ARigWritesItsImagesItsCloudAndWhatTheyGiveTogether) {
  const Scratch scratch;
  SimOptions options = smallRig();
  options.instances = true;
  ASSERT_TRUE(simulate(makeYard(1), options, scratch / "log", kQuiet));
  EXPECT_TRUE(exists(scratch / "log.rig.toml"));
  auto channels = readLog(scratch / "log");
  std::set<std::string> names;
  for (const auto& [name, messages] : channels) {
    names.insert(name);
    EXPECT_EQ(messages.size(), 12u) << name;
  }
  EXPECT_EQ(names, (std::set<std::string>{"POSE_ODOM", "POSE_ODOM_TRUE", "POSE_ODOM_EXCELLENT", "POSE_ODOM_GOOD",
                                          "POSE_ODOM_POOR", "CAMERA_LABELS_front", "CAMERA_LABELS_left", "LIDAR",
                                          "LIDAR_SEMANTIC"}));
  for (const auto& [utime_us, message] : channels["LIDAR_SEMANTIC"]) {
    const auto semantic = decodeSemanticCloud(message, 0.0F), cloud = decodeCloud(channels["LIDAR"][utime_us]);
    const auto front = decodeLabelImage(channels["CAMERA_LABELS_front"][utime_us]);
    ASSERT_TRUE(semantic && cloud && front);
    EXPECT_LT(semantic->points.size(), 0.7 * static_cast<double>(cloud->points.size()));
    std::size_t in_front = 0;
    for (const Point& p : semantic->points) {
      const auto pixel = project(options.sensors.cameras[0], Vec3(p.x, p.y, p.z));
      if (!pixel) {
        continue;
      }
      ++in_front;
      ASSERT_EQ(p.label, front->labels[front->at(pixel->x, pixel->y)]);
      ASSERT_EQ(p.instance, front->instances[front->at(pixel->x, pixel->y)]);
    }
    EXPECT_GT(in_front, 100u);
  }
}

TEST(Simulate, ADepthCamerasCloudIsItsDepthAndItsLabels) {
  const Scratch scratch;
  const SimOptions options = poorDrive(smallRgbd());
  ASSERT_TRUE(simulate(makeYard(1), options, scratch / "log", kQuiet));
  auto channels = readLog(scratch / "log");
  EXPECT_EQ(channels.size(), 8u);
  for (const auto& [utime_us, message] : channels["LIDAR_SEMANTIC"]) {
    const auto cloud = decodeSemanticCloud(message, 0.0F);
    const auto depth = decodeDepthImage(channels["DEPTH_front"][utime_us]);
    const auto labels = decodeLabelImage(channels["CAMERA_LABELS_front"][utime_us]);
    ASSERT_TRUE(cloud && depth && labels);
    std::size_t n = 0;
    for (int y = 0; y < depth->height; ++y) {
      for (int x = 0; x < depth->width; ++x) {
        const std::size_t at = depth->at(x, y);
        if (depth->depth_mm[at] == 0) {
          continue;
        }
        const Point& p = cloud->points[n++];
        ASSERT_LT(
            (unproject(options.sensors.cameras[0], {x, y}, depth->depth_mm[at] / 1000.0) - Vec3(p.x, p.y, p.z)).norm(),
            1e-5);
        ASSERT_EQ(p.label, labels->labels[at]);
        ASSERT_EQ(p.instance, labels->instances[at]);
      }
    }
    EXPECT_EQ(n, cloud->points.size());
    EXPECT_GT(n, 500u);
  }
}

TEST(Simulate, TheSemanticCloudOfCamerasCanBeLeftOut) {
  const Scratch scratch;
  for (SimOptions options : {smallRig(), smallRgbd(), smallDrive()}) {
    options.semantic_cloud = false;
    options.frames = 1;
    ASSERT_TRUE(simulate(makeYard(1), options, scratch / "log", kQuiet));
    EXPECT_EQ(readLog(scratch / "log").contains("LIDAR_SEMANTIC"), options.sensors.cameras.empty());
  }
}

TEST(Simulate, MixedReturnsAreUnknownToPerfectLabelsAndOnNoObject) {
  const Scratch scratch;
  SimOptions options = smallDrive();
  options.sensors.lidar->errors.mixed = 1.0;
  const auto mixed = simulate(makeYard(1), options, scratch / "mixed", kQuiet);
  options.sensors.lidar->errors.mixed = 0.0;
  const auto clean = simulate(makeYard(1), options, scratch / "clean", kQuiet);
  const auto unknown = [&](const char* log) {
    std::ptrdiff_t n = 0;
    for (const auto& cloud : semanticClouds(scratch / log)) {
      n += std::count_if(cloud.points.begin(), cloud.points.end(), [](const Point& p) { return p.label == 0; });
    }
    return n;
  };
  EXPECT_EQ(unknown("clean"), 0);
  EXPECT_GT(unknown("mixed"), 100);
  double mixed_points = 0, clean_points = 0;
  for (const auto& object : mixed->objects) {
    mixed_points += object.belief.kappa;
  }
  for (const auto& object : clean->objects) {
    clean_points += object.belief.kappa;
  }
  EXPECT_LT(mixed_points, clean_points);
}

/// Objects of the reference cloud, by their number of points.
std::map<std::uint32_t, int> pointsInCloud(const WorldTruth& truth) {
  std::map<std::uint32_t, int> points;
  for (const CloudPoint& p : truth.cloud) {
    ++points[p.object];
  }
  return points;
}

TEST(CompleteTruth, TheCloudShowsTheWorldAsItStandsAtTheLastFrameWhateverTheRate) {
  const Scratch scratch;
  const Scene scene = *makeScene("hall", 1, 1.0);
  SimOptions options = smallDrive();
  options.rate_hz = 2.0, options.frames = 0;
  options.sensors.lidar = spinningLidar(16, true);
  options.sensors.lidar->columns = 360;
  const auto drive = simulate(scene, options, scratch / "log", kQuiet);
  ASSERT_TRUE(drive) << drive.error;
  EXPECT_EQ(drive->end_time, static_cast<double>(drive->T_map_body.size() - 1) / 2.0);
  const auto points = pointsInCloud(completeTruth(scene, *drive, 2));
  int gone = 0, standing = 0, came = 0;
  for (const TruthObject& object : drive->objects) {
    const auto id = static_cast<std::uint32_t>(object.id);
    EXPECT_TRUE(!points.contains(id) || !(object.gone || object.dynamic)) << id;
    EXPECT_TRUE(points.contains(id) || object.gone || object.dynamic || object.belief.kappa < 50) << id;
    gone += object.gone;
    standing += !object.gone && !object.dynamic;
    came += !poseAt(scene, id - 1, 0.0) && points.contains(id);
  }
  EXPECT_GT(gone, 0);
  EXPECT_GT(came, 0);
  EXPECT_GT(standing, 20);
}

TEST(CompleteTruth, WhatADepthCameraSawIndoorsIsInTheCloud) {
  const Scratch scratch;
  for (const char* world : {"apartment", "office"}) {
    const Scene scene = *makeScene(world, 1);
    SimOptions options = smallRgbd();
    options.rate_hz = 10.0, options.frames = 600, options.threads = 2;
    const auto drive = simulate(scene, options, scratch / "log", kQuiet);
    ASSERT_TRUE(drive) << drive.error;
    const auto points = pointsInCloud(completeTruth(scene, *drive, 2));
    for (const TruthObject& object : drive->objects) {
      const bool is_seen_well = object.belief.kappa >= 50.0 / 16.0;  // of the 50 that the full camera would see
      EXPECT_TRUE(!is_seen_well || points.contains(static_cast<std::uint32_t>(object.id)))
          << world << ": " << scene.world.objects[static_cast<std::size_t>(object.id) - 1].name << " " << object.id;
    }
  }
}

TEST(CompleteTruth, IsTheSameWhateverTheThreads) {
  const Scratch scratch;
  const Scene scene = makeYard(1);
  const auto drive = simulate(scene, smallDrive(), scratch / "log", kQuiet);
  for (const int threads : {1, 3}) {
    ASSERT_EQ(writeTruth(completeTruth(scene, *drive, threads), scratch / std::to_string(threads)), "");
  }
  EXPECT_TRUE(readText(scratch / "1/cloud.ply") == readText(scratch / "3/cloud.ply"));
}

TEST(Simulate, AWholeTourIsTheDefault) {
  Scene scene = makeYard(1);
  scene.duration = 20.0;
  SimOptions options;
  EXPECT_EQ(frameCount(scene, options), 201);
  options.frames = 7;
  EXPECT_EQ(frameCount(scene, options), 7);
}

TEST(Simulate, ALogHasItsNameWhenItIsWhole) {
  const Scratch scratch;
  writeText(scratch / "log.lcm", "older");
  SimOptions options = smallDrive();
  options.frames = 2;
  const auto drive = simulate(makeYard(1), options, scratch / "log.lcm", [&](std::size_t, std::size_t) {
    EXPECT_TRUE(exists(scratch / "log.lcm.part"));
    EXPECT_EQ(readText(scratch / "log.lcm"), "older");
  });
  ASSERT_TRUE(drive) << drive.error;
  EXPECT_FALSE(exists(scratch / "log.lcm.part"));
  EXPECT_EQ(readChannel(scratch / "log.lcm", "LIDAR_SEMANTIC").size(), 2u);
}

TEST(Simulate, TwoLogsOfAFolderEachHaveTheirCameras) {
  const Scratch scratch;
  SimOptions rig = smallRig(), rgbd = smallRgbd();
  rig.frames = rgbd.frames = 1;
  ASSERT_TRUE(simulate(makeYard(1), rig, scratch / "a.lcm", kQuiet));
  ASSERT_TRUE(simulate(makeYard(1), rgbd, scratch / "b.lcm", kQuiet));
  EXPECT_NE(readText(scratch / "a.rig.toml").find("left"), std::string::npos);
  EXPECT_NE(readText(scratch / "b.rig.toml").find("DEPTH_front"), std::string::npos);
}

TEST(Simulate, ALogThatCannotBeWrittenIsAnError) {
  const auto drive = simulate(makeYard(1), smallDrive(), "/nonexistent/log", kQuiet);
  EXPECT_FALSE(drive);
  EXPECT_NE(drive.error.find("/nonexistent/log"), std::string::npos);
}

}  // namespace
}  // namespace hgg::simulate_test
