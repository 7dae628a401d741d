#include "output.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "map/file.h"
#include "map/test_map.h"
#include "test_scene.h"
#include "tools/scratch.h"

namespace hgg::output_test {
namespace {

StepReport reportAt(Micros utime_us, const Vec3& position, double yaw) {
  StepReport report;
  report.utime_us = utime_us;
  report.T_map_body.linear() = Eigen::AngleAxisd(yaw, Vec3::UnitZ()).toRotationMatrix();
  report.T_map_body.translation() = position;
  report.keyframe = 0;
  report.T_keyframe_body = report.T_map_body;
  return report;
}

/// A mapper that goes on from a map with its one keyframe at the origin.
Mapper someMapper() { return Mapper({}, testClasses(), mapOf({})); }

TEST(OutputDirectory, LeavesMapTrajectoryAndStatistics) {
  const Scratch scratch;
  const std::string directory = (scratch / "new/deep").string();
  const Mapper mapper = someMapper();
  auto out = OutputDirectory::open(directory);
  ASSERT_TRUE(out) << out.error;
  out->add(reportAt(1'000'007, Vec3(1, 2, 3), M_PI / 2), {12, {}}, mapper.map());
  out->add(reportAt(2'500'000, Vec3(123456.789, -0.001, 0), 0), {14, {}}, mapper.map());
  RunCounts counts;
  counts.frames = 2;
  ASSERT_EQ(out->finish(mapper, counts), "");

  EXPECT_TRUE(loadMap(directory + "/map.hgg"));
  EXPECT_EQ(nlohmann::json::parse(readText(directory + "/stats.json"))["frames"], 2);
  std::istringstream lines(readText(directory + "/trajectory.tum"));
  std::vector<std::vector<double>> rows;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    rows.emplace_back(std::istream_iterator<double>(words), std::istream_iterator<double>());
  }
  ASSERT_EQ(rows.size(), 2U);
  const std::vector<std::vector<double>> expected{{1.000007, 1, 2, 3, 0, 0, std::sqrt(0.5), std::sqrt(0.5)},
                                                  {2.5, 123456.789, -0.001, 0, 0, 0, 0, 1}};
  for (std::size_t r = 0; r < 2; ++r) {
    ASSERT_EQ(rows[r].size(), 8U);
    for (std::size_t k = 0; k < 8; ++k) {
      EXPECT_NEAR(rows[r][k], expected[r][k], 1e-6) << "row " << r << ", column " << k;
    }
  }
}

TEST(OutputDirectory, HasALineForEachFrameThatSeesAMover) {
  const Scratch scratch;
  const Mapper mapper = someMapper();
  auto out = OutputDirectory::open((scratch / "").string());
  ASSERT_TRUE(out) << out.error;
  StepReport report = reportAt(1'000'000, Vec3::Zero(), 0);
  Mover seen, coasting;
  seen.id = 7, seen.label = 10, seen.first_us = 400'000, seen.last_us = 1'000'000, seen.views = 6;
  seen.motion = seenAt({1, 2, 3}, Mat3::Identity(), 4 * Mat3::Identity());
  seen.motion.mean.tail<3>() = Vec3(-8, 0.5, 0);
  coasting.id = 8, coasting.last_us = 900'000;
  report.moving = {seen, coasting};
  out->add(report, {12, {}}, mapper.map());
  ASSERT_EQ(out->finish(mapper, {}), "");
  std::istringstream lines(readText(scratch / "moving.jsonl"));
  std::string line, more;
  ASSERT_TRUE(std::getline(lines, line));
  EXPECT_FALSE(std::getline(lines, more));
  const auto entry = nlohmann::json::parse(line);
  EXPECT_EQ(entry["id"], 7);
  EXPECT_EQ(entry["utime"], 1'000'000);
  EXPECT_EQ(entry["first_us"], 400'000);
  EXPECT_EQ(entry["position"], (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(entry["velocity"], (std::vector<double>{-8, 0.5, 0}));
  EXPECT_EQ(entry["velocity_cov"][4], 4);
}

TEST(OutputDirectory, KeepsTimesOfOurEraToTheMicrosecond) {
  const Scratch scratch;
  const Mapper mapper = someMapper();
  auto out = OutputDirectory::open((scratch / "").string());
  ASSERT_TRUE(out) << out.error;
  out->add(reportAt(1'700'000'000'000'042, Vec3(0, 0, 0), 0), {1, {}}, mapper.map());
  ASSERT_EQ(out->finish(mapper, {}), "");
  EXPECT_TRUE(readText(scratch / "trajectory.tum").starts_with("1700000000.000042 "));
}

TEST(OutputDirectory, PosesEndWhereTheirKeyframesDo) {
  const Scratch scratch;
  std::mt19937 random(1);
  KeyframeGraph keyframes;
  for (int k = 0; k < 3; ++k) {
    keyframes.add({k, randomPose(random, 20)});
  }
  const Mapper mapper({}, testClasses(), Map::restore({}, keyframes, {}, 1));
  auto out = OutputDirectory::open((scratch / "").string());
  ASSERT_TRUE(out) << out.error;
  std::vector<Pose> expected;
  for (int frame = 0; frame < 9; ++frame) {
    StepReport report = reportAt(frame, randomVector(random, 20), 1);  // where it was thought to be at the time
    report.keyframe = frame / 3;
    report.T_keyframe_body = randomPose(random, 2);
    out->add(report, {1, {}}, mapper.map());
    expected.push_back(keyframes.poses()[static_cast<std::size_t>(frame / 3)].T_map_body * report.T_keyframe_body);
  }
  ASSERT_EQ(out->finish(mapper, {}), "");
  std::istringstream lines(readText(scratch / "trajectory.tum"));
  for (const Pose& T : expected) {
    double t = 0;
    Vec3 p;
    Eigen::Quaterniond q;
    lines >> t >> p.x() >> p.y() >> p.z() >> q.x() >> q.y() >> q.z() >> q.w();
    ASSERT_TRUE(lines);
    EXPECT_LE((p - T.translation()).norm(), 1e-6);
    EXPECT_LE(q.angularDistance(Eigen::Quaterniond(T.linear())), 1e-6);
  }
  EXPECT_FALSE(std::filesystem::exists((scratch / "trajectory.tum.part").string()));
}

TEST(OutputDirectory, ALineItCannotReadIsAnErrorThatKeepsThePartAndTheEarlierTrajectory) {
  const Scratch scratch;
  writeText(scratch / "trajectory.tum", "earlier");
  const Mapper mapper = someMapper();
  auto out = OutputDirectory::open((scratch / "").string());
  ASSERT_TRUE(out) << out.error;
  out->add(reportAt(1, Vec3(1, 2, 3), 0), {1, {}}, mapper.map());
  StepReport unknown = reportAt(2, Vec3(1, 2, 3), 0);
  unknown.keyframe = 1;
  out->add(unknown, {1, {}}, mapper.map());
  const std::string error = out->finish(mapper, {});
  EXPECT_NE(error.find("trajectory.tum: cannot write the trajectory"), std::string::npos) << error;
  EXPECT_EQ(readText(scratch / "trajectory.tum"), "earlier");
  EXPECT_FALSE(std::filesystem::exists((scratch / "trajectory.tum.tmp").string()));
  EXPECT_EQ(std::ranges::count(readText(scratch / "trajectory.tum.part"), '\n'), 2);
  EXPECT_TRUE(loadMap((scratch / "map.hgg").string()));
}

TEST(OutputDirectory, ThatCannotBeMadeIsAnErrorThatNamesIt) {
  const Scratch scratch;
  writeText(scratch / "file", "in the way");
  const auto out = OutputDirectory::open((scratch / "file/sub").string());
  EXPECT_FALSE(out);
  EXPECT_NE(out.error.find((scratch / "file/sub").string()), std::string::npos) << out.error;
}

TEST(OutputDirectory, LivePosesAreThoseThatWerePublishedWithAWordEach) {
  const Scratch scratch;
  KeyframeGraph keyframes;
  keyframes.add({0, Pose(Eigen::Translation3d(7, 0, 0))});  // a correction has moved it since
  const Mapper mapper({}, testClasses(), Map::restore({}, keyframes, {}, 1));
  auto out = OutputDirectory::open((scratch / "").string());
  ASSERT_TRUE(out) << out.error;
  std::vector<StepReport> reports(9, reportAt(1'000'000, Vec3(1, 2, 3), 0));
  reports[0].source = PoseSource::kAligned;
  reports[1].source = PoseSource::kDegenerate;
  reports[3].tracking = Tracking::kRecovered;
  reports[4].tracking = Tracking::kDoubtful;
  reports[5].tracking = Tracking::kLost;
  reports[6].source = PoseSource::kAligned, reports[6].fragment = 4;
  reports[7].odometry_fault = OdometryFault::kSlip;
  reports[8].odometry_fault = OdometryFault::kSlip, reports[8].tracking = Tracking::kDoubtful;
  const std::vector<std::string> words{"aligned", "degenerate", "odometry",      "recovered", "doubtful",
                                       "lost",    "lost",       "odometry_slip", "doubtful"};
  for (const StepReport& report : reports) {
    out->add(report, {1, {}}, mapper.map());
  }
  ASSERT_EQ(out->finish(mapper, {}), "");
  std::string expected;
  for (const std::string& word : words) {
    expected += "1.000000 1 2 3 0 0 0 1 " + word + "\n";
  }
  EXPECT_EQ(readText(scratch / "live.tum"), expected);
  EXPECT_TRUE(readText(scratch / "trajectory.tum").starts_with("1.000000 8 2 3 ")) << "which the trajectory is not";
  EXPECT_FALSE(std::filesystem::exists((scratch / "live.tum.part").string()));
}

TEST(OutputDirectory, ARunThatCameToNothingLeavesTheEarlierLivePoses) {
  const Scratch scratch;
  writeText(scratch / "live.tum", "earlier");
  const Mapper mapper = someMapper();
  auto out = OutputDirectory::open((scratch / "").string());
  ASSERT_TRUE(out) << out.error;
  out->add(reportAt(1, Vec3(1, 2, 3), 0), {1, {}}, mapper.map());
  out->discard();
  EXPECT_EQ(readText(scratch / "live.tum"), "earlier");
  EXPECT_FALSE(std::filesystem::exists((scratch / "live.tum.part").string()));
}

}  // namespace
}  // namespace hgg::output_test
