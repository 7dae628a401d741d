#include "replay.h"

#include <gtest/gtest.h>

#include <fstream>

#include "bus/codec.h"
#include "map/file.h"
#include "run.h"
#include "small_world.h"
#include "tools/scratch.h"

namespace hgg::replay_test {
namespace {

using Message = std::vector<std::uint8_t>;
constexpr int kFrames = 8;
const std::atomic<bool> kNeverStop{false};

/// A log written message by message; times are SmallWorld's.
class LogBuilder {
 public:
  explicit LogBuilder(const std::string& path) : path_(path), log_(LogWriter::create(path)) {}
  LogBuilder& message(const std::string& channel, Micros time_us, const Message& bytes) {
    EXPECT_EQ(log_->write(channel, time_us, bytes), "");
    return *this;
  }
  LogBuilder& odometry(int i, Micros logged_us) {
    const auto sample = SmallWorld::odometry(i);
    return message("POSE_ODOM", logged_us, encodePose(sample.utime_us, sample.T_odom_body));
  }
  LogBuilder& cloud(int i, Micros logged_us) {
    return message("LIDAR_SEMANTIC", logged_us, encodeSemanticCloud(SmallWorld::timeOf(i), SmallWorld::points(i)));
  }
  LogBuilder& frames(int from, int to) {
    for (int i = from; i < to; ++i) {
      odometry(i, SmallWorld::timeOf(i)).cloud(i, SmallWorld::timeOf(i));
    }
    return *this;
  }
  std::string finish() {
    EXPECT_EQ(log_->close(), "");
    return path_;
  }

 private:
  std::string path_;
  Result<LogWriter> log_;
};

Mapper makeMapper() { return {Config{}, ClassTable::builtin()}; }

struct Outcome {
  Result<ReplayReport> report;
  std::vector<Micros> frames_us;
  std::vector<FrameTiming> timings;
};

Outcome replayOf(const std::string& path, Mapper& mapper) {
  Outcome out;
  const auto on_frame = [&](const StepReport& step, const FrameTiming& timing) {
    out.frames_us.push_back(step.utime_us);
    out.timings.push_back(timing);
  };
  out.report = replayLog(path, mapper, on_frame, {}, kNeverStop);
  return out;
}

Outcome replayOf(const std::string& path) {
  Mapper mapper = makeMapper();
  return replayOf(path, mapper);
}

std::vector<Micros> timesOf(std::initializer_list<int> frames) {
  std::vector<Micros> out;
  for (const int i : frames) {
    out.push_back(SmallWorld::timeOf(i));
  }
  return out;
}

class Replay : public ::testing::Test {
 protected:
  LogBuilder log() { return LogBuilder(path_); }

  Scratch scratch_;
  std::string path_ = scratch_ / "log.lcm";
};

TEST_F(Replay, EveryCloudWithOdometryBecomesAFrame) {
  Mapper mapper = makeMapper();
  const auto out = replayOf(log().frames(0, kFrames).finish(), mapper);
  ASSERT_TRUE(out.report) << out.report.error;
  EXPECT_EQ(out.frames_us, timesOf({0, 1, 2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(out.report->events, 2 * kFrames);
  EXPECT_EQ(out.report->counts.frames, kFrames);
  EXPECT_EQ(out.report->counts.drops.total(), 0);
  EXPECT_TRUE(out.report->counts.decode_errors.empty());
  EXPECT_FALSE(out.report->stopped);
  EXPECT_FALSE(mapper.map().nodes().empty());
  for (const auto& timing : out.timings) {
    ASSERT_FALSE(timing.stage_ms.empty());
    EXPECT_EQ(timing.stage_ms[0].first, "decode");
    EXPECT_GE(timing.frame_ms, timing.stage_ms[0].second);
  }
}

TEST_F(Replay, OdometryLaterInTheLogIsUsedHoweverLate) {
  const Micros t = SmallWorld::timeOf(1);
  for (const Micros late_us : {Micros{0}, Micros{200'001}, Micros{60'000'000}}) {
    EXPECT_EQ(replayOf(log().odometry(0, t).cloud(1, t).odometry(2, t + late_us).finish()).frames_us, timesOf({1}));
  }
}

TEST_F(Replay, SlowOdometryCostsNoFrames) {
  for (const int every : {2, 5, 10, 20}) {
    auto builder = log();
    for (int i = 0; i <= 40; ++i) {
      if (i % every == 0) {
        builder.odometry(i, SmallWorld::timeOf(i));
      }
      builder.cloud(i, SmallWorld::timeOf(i));
    }
    const auto out = replayOf(builder.finish());
    EXPECT_EQ(out.report->counts.frames, 41) << every;
    EXPECT_EQ(out.report->counts.drops.total(), 0) << every;
  }
}

TEST_F(Replay, MissingOdometryCostsItsFramesOnly) {
  auto builder = log();
  builder.frames(0, 3);
  for (const int i : {3, 4}) {
    builder.cloud(i, SmallWorld::timeOf(i));
  }
  // More than a gap away from 2: nothing in between is guessed.
  const Micros late_us = SmallWorld::timeOf(3) + std::llround(FrameConfig{}.odometry_gap_s * 1e6);
  builder.message("POSE_ODOM", late_us, encodePose(late_us, Pose::Identity()));
  builder.message("LIDAR_SEMANTIC", late_us, encodeSemanticCloud(late_us, SmallWorld::points(5)));
  const auto out = replayOf(builder.finish());
  EXPECT_EQ(out.report->counts.frames, 4);
  EXPECT_EQ(out.report->counts.drops.odometry, 2);
  EXPECT_EQ(out.report->counts.drops.causes.at("odometry: in a gap longer than frame.odometry_gap_s"), 2);
  EXPECT_EQ(out.report->counts.odometry_gap_us, 3'100'000);
}

TEST_F(Replay, LateAndDuplicateFramesAreDroppedAndCounted) {
  auto builder = log();
  builder.frames(0, 4).cloud(3, SmallWorld::timeOf(3)).cloud(1, SmallWorld::timeOf(3)).frames(4, 6);
  const auto out = replayOf(builder.finish());
  EXPECT_EQ(out.frames_us, timesOf({0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(out.report->counts.drops.invalid, 2);
}

TEST_F(Replay, BadMessagesAreCountedByReasonAndTheRestIsMapped) {
  const Message cloud = encodeSemanticCloud(SmallWorld::timeOf(2), SmallWorld::points(2));
  const Message pose = encodePose(SmallWorld::timeOf(2), Pose::Identity());
  const Message cut_cloud(cloud.begin(), cloud.end() - 100), cut_pose(pose.begin(), pose.end() - 1);
  const Micros t = SmallWorld::timeOf(2);
  auto builder = log();
  builder.frames(0, 2).message("LIDAR_SEMANTIC", t, cut_cloud).message("LIDAR_SEMANTIC", t, pose);
  builder.message("LIDAR_SEMANTIC", t, cut_cloud).message("POSE_ODOM", t, cut_pose).frames(2, 4);
  const auto out = replayOf(builder.finish());
  EXPECT_EQ(out.frames_us, timesOf({0, 1, 2, 3}));
  const std::map<std::string, std::int64_t> expected = {
      {"cloud: truncated", 2}, {"cloud: foreign fingerprint", 1}, {"odometry: truncated", 1}};
  EXPECT_EQ(out.report->counts.decode_errors, expected);
  EXPECT_EQ(out.report->counts.drops.invalid, 3);
}

TEST_F(Replay, PointsOutsideTheClassTableAndNonFiniteOnesAreCounted) {
  auto points = SmallWorld::points(0);
  points[0].label = points[1].label = 4711;
  points[2].x = std::numeric_limits<float>::quiet_NaN();
  auto builder = log();
  builder.odometry(0, 0).message("LIDAR_SEMANTIC", 0, encodeSemanticCloud(SmallWorld::timeOf(0), points));
  builder.odometry(1, 1).message("LIDAR_SEMANTIC", 1, encodeSemanticCloud(SmallWorld::timeOf(1), {}));
  const auto out = replayOf(builder.finish());
  EXPECT_EQ(out.report->counts.frames, 2);
  EXPECT_EQ(out.report->counts.unknown_labels, 2);
  EXPECT_EQ(out.report->counts.nonfinite_points, 1);
}

TEST_F(Replay, ADamagedLogIsMappedAroundTheDamage) {
  log().frames(0, kFrames).finish();
  std::string bytes = readText(path_);
  const auto frame_bytes = bytes.size() / kFrames;
  for (std::size_t i = 3 * frame_bytes + 500; i < 3 * frame_bytes + 50'000; ++i) {
    bytes[i] = '\x55';
  }
  bytes.resize(bytes.size() - 10);
  writeText(path_, bytes);
  const auto out = replayOf(path_);
  ASSERT_TRUE(out.report) << out.report.error;
  EXPECT_EQ(out.report->loss.gaps, 1);
  EXPECT_GT(out.report->loss.gap_bytes, 0);
  EXPECT_GT(out.report->loss.tail_bytes, 0);
  EXPECT_GE(out.frames_us.size(), 5u);
  EXPECT_LT(out.frames_us.size(), 8u);
  EXPECT_EQ(out.frames_us.back(), SmallWorld::timeOf(6));
}

TEST_F(Replay, TimeThatRestartsGoesOn) {
  auto builder = log();
  for (const Micros start_us : {Micros{100'000'000}, Micros{0}}) {
    for (int i = 0; i < 3; ++i) {
      const Micros t = start_us + SmallWorld::timeOf(i);
      builder.message("POSE_ODOM", t, encodePose(t, SmallWorld::odometry(i).T_odom_body));
      builder.message("LIDAR_SEMANTIC", t, encodeSemanticCloud(t, SmallWorld::points(i)));
    }
  }
  const auto out = replayOf(builder.finish());
  EXPECT_EQ(out.report->counts.frames, 6);
  EXPECT_EQ(out.report->counts.restarts, 1);
}

TEST_F(Replay, StopKeepsWhatWasMapped) {
  log().frames(0, kFrames).finish();
  std::atomic<bool> stop{false};
  Mapper mapper = makeMapper();
  int frames = 0;
  const auto on_frame = [&](const StepReport&, const FrameTiming&) { stop = ++frames == 3; };
  const auto report = replayLog(path_, mapper, on_frame, {}, stop);
  ASSERT_TRUE(report) << report.error;
  EXPECT_TRUE(report->stopped);
  EXPECT_EQ(report->counts.frames, 3);
  EXPECT_FALSE(mapper.map().nodes().empty());
}

TEST_F(Replay, ProgressRisesToOne) {
  log().frames(0, kFrames).finish();
  Mapper mapper = makeMapper();
  std::vector<double> shares;
  const auto on_progress = [&](double share, std::int64_t) { shares.push_back(share); };
  ASSERT_TRUE(replayLog(path_, mapper, {}, on_progress, kNeverStop));
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_EQ(shares.back(), 1.0);
}

TEST_F(Replay, TheSameLogGivesTheSameMap) {
  log().frames(0, kFrames).finish();
  for (const std::string name : {"a.hgg", "b.hgg"}) {
    Mapper mapper = makeMapper();
    replayOf(path_, mapper);
    ASSERT_EQ(saveMap(mapper.map(), scratch_ / name), "");
  }
  EXPECT_EQ(readText(scratch_ / "a.hgg"), readText(scratch_ / "b.hgg"));
}

TEST_F(Replay, ALogThatHoldsNothingForUsSaysWhatItHolds) {
  EXPECT_NE(replayOf(scratch_ / "none.lcm").report.error.find("No such file"), std::string::npos);
  writeText(path_, "no log");
  EXPECT_NE(replayOf(path_).report.error.find("is it an LCM log"), std::string::npos);
  const auto out = replayOf(log().odometry(0, 0).message("LIDAR_FRONT", 0, {1}).finish());
  EXPECT_NE(out.report.error.find("channels: LIDAR_FRONT: 1, POSE_ODOM: 1 bot_core.pose_t"), std::string::npos)
      << out.report.error;
}

TEST_F(Replay, WithoutOdometryThereIsNoMapAndTheChannelsAreNamed) {
  auto builder = log();
  for (int i = 0; i < kFrames; ++i) {
    builder.cloud(i, SmallWorld::timeOf(i));
    builder.message("POSE_BODY", SmallWorld::timeOf(i), encodePose(SmallWorld::timeOf(i), Pose::Identity()));
  }
  const std::string error = replayOf(builder.finish()).report.error;
  EXPECT_NE(error.find("nothing came on POSE_ODOM (lcm.odometry"), std::string::npos) << error;
  EXPECT_NE(error.find("POSE_BODY: 8 bot_core.pose_t"), std::string::npos) << error;
}

TEST_F(Replay, NoMapIsMadeOfStampsInAnotherUnit) {
  auto builder = log();
  for (int i = 0; i < 70; ++i) {
    const Micros t = SmallWorld::timeOf(i), seconds = t / 1'000'000;
    builder.message("POSE_ODOM", t, encodePose(seconds, SmallWorld::odometry(i).T_odom_body));
    builder.message("LIDAR_SEMANTIC", t, encodeSemanticCloud(seconds, {}));
  }
  const std::string error = replayOf(builder.finish()).report.error;
  EXPECT_NE(error.find("look like seconds"), std::string::npos) << error;
}

// ------------------------------------------------------------------------------------------- mounted sensors

/// The clouds of the small world as a sensor sees them that is mounted so.
std::vector<Point> seenFrom(const Mounting& mounting, std::vector<Point> points) {
  const Eigen::Isometry3f T_sensor_body = poseOf(mounting).inverse().cast<float>();
  for (Point& p : points) {
    const Eigen::Vector3f v = T_sensor_body * Eigen::Vector3f(p.x, p.y, p.z);
    p.x = v.x(), p.y = v.y(), p.z = v.z();
  }
  return points;
}

std::vector<Vec3> objectsOf(const Map& map) {
  std::vector<Vec3> out;
  for (const auto& [id, node] : map.nodes()) {
    if (isConfirmed(node) && !node.stuff) {
      out.push_back(node.belief.mean);
    }
  }
  return out;
}

TEST_F(Replay, CloudsOfAMountedSensorGiveTheMapOfTheBody) {
  const Mounting mounting{0.3, -0.2, 0.5, 4, 30, 90};
  std::vector<std::vector<Vec3>> objects;
  for (const Mounting& m : {Mounting{}, mounting}) {
    auto builder = log();
    for (int i = 0; i < kFrames; ++i) {
      builder.odometry(i, SmallWorld::timeOf(i));
      builder.message("LIDAR_SEMANTIC", SmallWorld::timeOf(i),
                      encodeSemanticCloud(SmallWorld::timeOf(i), seenFrom(m, SmallWorld::points(i))));
    }
    Config config;
    config.frame.range_min = 0;
    config.T_body_lidar.lidar_semantic = m;
    Mapper mapper(config, ClassTable::builtin());
    EXPECT_EQ(replayOf(builder.finish(), mapper).report->counts.frames, kFrames);
    objects.push_back(objectsOf(mapper.map()));
  }
  ASSERT_FALSE(objects[0].empty());
  ASSERT_EQ(objects[0].size(), objects[1].size());
  for (std::size_t k = 0; k < objects[0].size(); ++k) {
    EXPECT_LT((objects[0][k] - objects[1][k]).norm(), 1e-2);
  }
}

TEST_F(Replay, RangeLimitsAreAboutTheSensor) {
  const std::vector<Point> points{{1, 0, 0, 0, 10}, {6, 0, 0, 0, 10}, {9, 0, 0, 0, 10}};  // as the sensor sees them
  Config config;
  config.frame.range_min = 2, config.frame.range_max = 8;
  config.T_body_lidar.lidar_semantic = {5, 0, 0, 0, 0, 180};  // they lie at x = 4, -1 and -4 of the body
  auto builder = log();
  builder.odometry(0, 0).message("LIDAR_SEMANTIC", 0, encodeSemanticCloud(SmallWorld::timeOf(0), points));
  Mapper mapper(config, ClassTable::builtin());
  std::size_t kept = 0;
  const auto on_frame = [&](const StepReport& step, const FrameTiming&) { kept = step.points; };
  ASSERT_TRUE(replayLog(builder.finish(), mapper, on_frame, {}, kNeverStop));
  EXPECT_EQ(kept, 1u);
}

// ---------------------------------------------------------------------------------------------------- live

// LCM's file provider plays the log as fast as it can, so that clouds may be replaced before they are taken; the last
// never is.
TEST_F(Replay, ALiveRunMapsOrCountsEveryCloud) {
  log().frames(0, kFrames).finish();
  Config config;
  config.lcm.url = "file://" + path_ + "?speed=0";
  Mapper mapper(config, ClassTable::builtin());
  std::atomic<bool> stop{false};
  const auto on_frame = [&](const StepReport& step, const FrameTiming& timing) {
    EXPECT_EQ(timing.stage_ms.back().first, "publish");
    stop = step.utime_us == SmallWorld::timeOf(kFrames - 1);
  };
  const auto counts = runLive(config, mapper, stop, on_frame);
  ASSERT_TRUE(counts) << counts.error;
  EXPECT_EQ(counts->frames + counts->drops.busy, kFrames);
  EXPECT_EQ(counts->drops.total(), counts->drops.busy);
  EXPECT_EQ(counts->odometry_samples, kFrames);
}

TEST_F(Replay, ALiveRunWithoutABusIsAnError) {
  Config config;
  config.lcm.url = "garbage";
  Mapper mapper = makeMapper();
  EXPECT_NE(runLive(config, mapper, kNeverStop, {}).error.find("cannot open LCM url 'garbage'"), std::string::npos);
}

}  // namespace
}  // namespace hgg::replay_test
