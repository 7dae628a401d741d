#include <gtest/gtest.h>

#include "eval/recovery.h"
#include "tools/scratch.h"

namespace hgg::recovery_eval_test {
namespace {

/// A pose a second from 0 on with these errors.
std::vector<TrackedPose> track(const std::vector<double>& errors, bool is_sure = true) {
  std::vector<TrackedPose> poses;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    poses.push_back({static_cast<Micros>(i) * 1'000'000, errors[i], true, is_sure});
  }
  return poses;
}

TEST(Recovery, IsFromTheFaultToTheFirstPoseThatStaysRight) {
  const auto score = scoreRecovery(track({0, 0, 0, 2, 2, 0.1, 2, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 5}), 3'000'000);
  ASSERT_TRUE(score.back_after);
  EXPECT_EQ(*score.back_after, 4.0);  // the one at 5 s did not stay; the one at 13 s came later
  EXPECT_EQ(score.end_error, 5.0);
  EXPECT_EQ(score.worst_error, 5.0);
  EXPECT_EQ(score.longest_off, 2.0);
}

TEST(Recovery, OfWhatNeverWentWrongIsAtOnceAndOfWhatEndsWrongIsNever) {
  EXPECT_EQ(*scoreRecovery(track({0, 0.3, 0.3, 0}), 1'000'000).back_after, 0.0);
  EXPECT_FALSE(scoreRecovery(track({0, 0, 1}), 1'000'000).back_after);
}

TEST(Recovery, AWrongPlaceIsOneThatTheStatusDoesNotAdmit) {
  auto poses = track({0, 2, 2, 2, 2, 0});
  EXPECT_EQ(scoreRecovery(poses, 0).longest_wrong, 4.0);
  EXPECT_FALSE(scoreRecovery(poses, 1'000'000).said_after);
  poses[3].is_sure = poses[4].is_sure = false;
  EXPECT_EQ(scoreRecovery(poses, 0).longest_wrong, 2.0);
  EXPECT_EQ(*scoreRecovery(poses, 1'000'000).said_after, 2.0);
  EXPECT_EQ(scoreRecovery(track({0, 0.9, 0.9, 0.9}), 0).longest_wrong, 0.0);
}

TEST(Recovery, WithoutAStatusNothingWasSaidAndNothingWasClaimed) {
  auto poses = track({0, 2, 2}, false);
  for (TrackedPose& pose : poses) {
    pose.has_status = false;
  }
  EXPECT_FALSE(scoreRecovery(poses, 0).said_after);
  EXPECT_EQ(scoreRecovery(poses, 0).longest_wrong, 0.0);
}

TEST(ReadLive, ReadsPosesWithAndWithoutAStatus) {
  const Scratch scratch;
  writeText(scratch / "live.tum", "# comment\n1.5 1 2 3 0 0 0 1 aligned\n2.5 1 2 3 0 0 0 2\n");
  const auto live = readLive(scratch / "live.tum");
  ASSERT_TRUE(live) << live.error;
  ASSERT_EQ(live->size(), 2u);
  EXPECT_EQ((*live)[0].status, "aligned");
  EXPECT_EQ((*live)[0].pose.utime_us, 1'500'000);
  EXPECT_EQ((*live)[1].status, "");
  EXPECT_TRUE((*live)[1].pose.T_map_body.linear().isApprox(Mat3::Identity()));
  writeText(scratch / "live.tum", "1.5 1 2 3 0 0 0 1 aligned\n2.5 1 2\n");
  EXPECT_NE(readLive(scratch / "live.tum").error.find("line 2"), std::string::npos);
  EXPECT_FALSE(readLive(scratch / "missing.tum"));
}

TEST(TrackPoses, LaysTheMapOverTheTruthAtTheFirstPose) {
  std::vector<LivePose> live;
  std::vector<Pose> truth;
  const Pose T_map_truth = Eigen::Translation3d(5, 0, 0) * Pose(Eigen::AngleAxisd(1.0, Vec3::UnitZ()));
  for (int i = 0; i < 4; ++i) {
    truth.emplace_back(Eigen::Translation3d(i, 0, 0));
    const Vec3 drift(0, 0.5 * i, 0);
    live.push_back({{i * 100'000, T_map_truth * Pose(Eigen::Translation3d(truth.back().translation() + drift))},
                    i < 2 ? "aligned" : "lost"});
  }
  const auto tracked = trackPoses(live, truth, std::nullopt);
  ASSERT_TRUE(tracked) << tracked.error;
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR((*tracked)[static_cast<std::size_t>(i)].error, 0.5 * i, 1e-9);
    EXPECT_EQ((*tracked)[static_cast<std::size_t>(i)].is_sure, i < 2);
  }
}

}  // namespace
}  // namespace hgg::recovery_eval_test
