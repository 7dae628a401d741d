#include "sim/odometry_faults.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sim/odometry.h"

namespace hgg::odometry_faults_test {
namespace {

constexpr double kRate_hz = 10.0;

double yawOf(const Pose& T) { return std::atan2(T.linear()(1, 0), T.linear()(0, 0)) * 180 / M_PI; }

/// 60 s at 0.5 m a frame, level, with a turn by 90 degrees over 2 s every 10 s; the later, the sharper.
std::vector<Pose> drive() {
  std::vector<Pose> poses{Pose::Identity()};
  for (int i = 1; i < 600; ++i) {
    const bool turns = i % 100 >= 40 && i % 100 < 60;
    const double rate_deg = turns ? 2.0 + 0.5 * (i / 100) : 0.0;  // a frame
    Pose step = Pose::Identity();
    step.translation().x() = 0.5;
    step.linear() = Eigen::AngleAxisd(rate_deg * M_PI / 180, Vec3::UnitZ()).toRotationMatrix();
    poses.push_back(poses.back() * step);
  }
  return poses;
}

std::vector<std::size_t> everyNth(std::size_t frames, std::size_t n) {
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < frames; i += n) {
    kept.push_back(i);
  }
  return kept;
}

std::vector<Pose> faulty(const OdometryFaults& faults, std::uint64_t seed = 1) {
  return withFaults(drive(), kRate_hz, everyNth(600, 1), faults, seed);
}

/// How far each frame's motion is from the true one.
struct StepErrors {
  std::vector<double> m, deg;
};
StepErrors stepErrors(const std::vector<Pose>& poses, const std::vector<Pose>& truth = drive()) {
  StepErrors errors;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const Pose error = (truth[i - 1].inverse() * truth[i]).inverse() * (poses[i - 1].inverse() * poses[i]);
    errors.m.push_back(error.translation().norm());
    errors.deg.push_back(yawOf(error));
  }
  return errors;
}

std::vector<std::size_t> framesOff(const StepErrors& errors) {
  std::vector<std::size_t> frames;
  for (std::size_t i = 0; i < errors.m.size(); ++i) {
    if (errors.m[i] > 1e-9 || std::abs(errors.deg[i]) > 1e-9) {
      frames.push_back(i + 1);
    }
  }
  return frames;
}

OdometryFaults atTime(const std::string& text) {
  const auto fault = parseFault(text);
  EXPECT_TRUE(fault) << fault.error;
  return {.timed = {*fault}};
}

TEST(OdometryFaults, WithoutAnyThePosesAreUntouched) {
  const auto truth = drive(), poses = faulty({});
  ASSERT_EQ(poses.size(), truth.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_EQ(poses[i].matrix(), truth[i].matrix());
  }
  const auto half = withFaults(truth, kRate_hz, everyNth(600, 2), {}, 1);
  ASSERT_EQ(half.size(), 300u);
  EXPECT_EQ(half[7].matrix(), truth[14].matrix());
}

TEST(OdometryFaults, ALateSampleIsAnEarlierPoseAndAnEarlyOneALater) {
  const auto truth = drive();
  const auto late = faulty({.delay = 0.1}), early = faulty({.delay = -0.2}), between = faulty({.delay = 0.05});
  for (std::size_t i = 2; i + 2 < truth.size(); ++i) {
    EXPECT_EQ(late[i].matrix(), truth[i - 1].matrix());
    EXPECT_EQ(early[i].matrix(), truth[i + 2].matrix());
    const Vec3 middle = 0.5 * (truth[i - 1].translation() + truth[i].translation());
    EXPECT_LT((between[i].translation() - middle).norm(), 1e-9);
  }
  EXPECT_EQ(late.front().matrix(), truth.front().matrix());
  EXPECT_EQ(early.back().matrix(), truth.back().matrix());
  const auto late_half = withFaults(truth, kRate_hz, everyNth(600, 2), {.delay = 0.1}, 1);
  EXPECT_EQ(late_half[5].matrix(), truth[9].matrix());  // of the full rate, not of the frames that are kept
}

TEST(OdometryFaults, ABurstLeavesTheTrackInItsTurnAndComesBack) {
  const auto truth = drive();
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto poses = faulty({.bursts = 1}, seed);
    const StepErrors errors = stepErrors(poses);
    const auto frames = framesOff(errors);
    ASSERT_GE(frames.size(), 5u);
    ASSERT_LE(frames.size(), 8u);
    EXPECT_EQ(frames.back() - frames.front() + 1, frames.size());
    EXPECT_GE(frames.front(), 540u);  // the last turn is the sharpest
    EXPECT_LE(frames.back(), 560u);
    double peak_deg = 0, peak_m = 0;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      peak_deg = std::max(peak_deg, std::abs(yawOf(truth[i].inverse() * poses[i])));
      peak_m = std::max(peak_m, (truth[i].translation() - poses[i].translation()).norm());
    }
    EXPECT_NEAR(peak_deg, 6.0, 1e-6);
    EXPECT_GE(peak_m, 0.3 - 1e-9);
    EXPECT_LE(peak_m, 1.0);
    for (const std::size_t frame : frames) {
      EXPECT_GT(std::abs(errors.deg[frame - 1]), 0.9);
      EXPECT_LT(std::abs(errors.deg[frame - 1]), 4.1);
    }
    EXPECT_TRUE(poses.back().isApprox(truth.back(), 1e-9));
  }
}

TEST(OdometryFaults, BurstsThatStayTurnTheRestOfTheDrive) {
  const auto poses = faulty({.bursts = 1, .bursts_stay = true});
  EXPECT_NEAR(std::abs(yawOf(drive().back().inverse() * poses.back())), 6.0, 1e-6);
  const StepErrors errors = stepErrors(poses);
  EXPECT_NEAR(std::abs(std::accumulate(errors.deg.begin(), errors.deg.end(), 0.0)), 6.0, 1e-6);
  EXPECT_LE(framesOff(errors).size(), 8u);
}

TEST(OdometryFaults, EveryBurstHasATurnOfItsOwn) {
  const auto frames = framesOff(stepErrors(faulty({.bursts = 5})));
  for (const std::size_t turn : {150u, 250u, 350u, 450u, 550u}) {
    EXPECT_TRUE(std::ranges::any_of(frames, [&](std::size_t i) { return i >= turn - 10 && i <= turn + 10; })) << turn;
  }
  EXPECT_TRUE(std::ranges::none_of(frames, [&](std::size_t i) { return i < 100; }));
}

TEST(OdometryFaults, AJumpIsOneStepOfItsSizeAndTheRestIsTrue) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const StepErrors jump = stepErrors(faulty(atTime("jump@20"), seed));
    ASSERT_EQ(framesOff(jump), std::vector<std::size_t>{200});
    EXPECT_GE(jump.m[199], 4.0);
    EXPECT_LE(jump.m[199], 8.0);
    const StepErrors turn = stepErrors(faulty(atTime("yaw-jump@20"), seed));
    ASSERT_EQ(framesOff(turn), std::vector<std::size_t>{200});
    EXPECT_GE(std::abs(turn.deg[199]), 30.0);
    EXPECT_LE(std::abs(turn.deg[199]), 120.0);
  }
  EXPECT_NEAR(stepErrors(faulty(atTime("jump:50@20"))).m[199], 50.0, 1e-6);
  EXPECT_NEAR(std::abs(stepErrors(faulty(atTime("yaw-jump:45@20"))).deg[199]), 45.0, 1e-6);
}

TEST(OdometryFaults, SlippingWheelsReportAnotherWayForFiveSeconds) {
  const auto poses = faulty(atTime("slip@20"));
  const StepErrors errors = stepErrors(poses);
  const auto frames = framesOff(errors);
  ASSERT_EQ(frames.size(), 50u);
  EXPECT_EQ(frames.front(), 201u);
  const double way = (poses[200].inverse() * poses[201]).translation().norm();
  EXPECT_TRUE(std::abs(way - 0.2) < 1e-9 || std::abs(way - 0.8) < 1e-9) << way;
  EXPECT_LT(std::abs(errors.deg[220]), 1e-9);
  EXPECT_NEAR(stepErrors(faulty(atTime("slip:1.1@20"))).m[220], 0.05, 1e-9);
}

TEST(OdometryFaults, FrozenOdometryRepeatsItsPoseAndThenGoesOnFromIt) {
  const auto truth = drive(), poses = faulty(atTime("frozen@20"));
  for (std::size_t i = 200; i <= 250; ++i) {
    EXPECT_TRUE(poses[i].isApprox(poses[200], 1e-12)) << i;
  }
  EXPECT_TRUE((poses[250].inverse() * poses[599]).isApprox(truth[250].inverse() * truth[599], 1e-9));
  EXPECT_EQ(framesOff(stepErrors(faulty(atTime("frozen:2@20")))).size(), 20u);
}

TEST(OdometryFaults, ARestartIsAtZeroAndGoesOnFromThere) {
  const auto truth = drive(), poses = faulty(atTime("restart@20"));
  EXPECT_TRUE(poses[199].isApprox(truth[199], 1e-9));
  EXPECT_TRUE(poses[200].isApprox(Pose::Identity(), 1e-12));
  EXPECT_TRUE(poses[599].isApprox(truth[200].inverse() * truth[599], 1e-9));
}

TEST(OdometryFaults, QuaternionsInTheOtherOrderAreReadAsOtherRotations) {
  const auto truth = drive(), poses = faulty({.quaternion_xyzw = true});
  const Eigen::Quaterniond q(truth[150].linear()), read(poses[150].linear());
  const Eigen::Quaterniond expected(q.x(), q.y(), q.z(), q.w());
  EXPECT_NEAR(std::abs(read.dot(expected)), 1.0, 1e-12);
  EXPECT_EQ(poses[150].translation(), truth[150].translation());
}

TEST(OdometryFaults, AreTheSameForASeedAndCombine) {
  OdometryFaults faults = atTime("jump@20");
  faults.bursts = 2, faults.delay = 0.1;
  EXPECT_EQ(faulty(faults, 3).back().matrix(), faulty(faults, 3).back().matrix());
  EXPECT_NE(faulty(faults, 3).back().matrix(), faulty(faults, 4).back().matrix());
}

TEST(OdometryFaults, WhatCannotBeReadIsAnErrorThatSaysWhatCan) {
  for (const char* text : {"jump", "leap@3", "jump@", "jump@-1", "jump@x", "jump:@3", "jump:-1@3", "jump:0@3",
                           "jump:nan@3", "restart:2@3", "@3", "", "jump@3:5"}) {
    const auto fault = parseFault(text);
    EXPECT_FALSE(fault) << text;
    EXPECT_NE(fault.error.find("KIND"), std::string::npos);
  }
  const auto fault = parseFault("yaw-jump:45@12.5");
  ASSERT_TRUE(fault);
  EXPECT_EQ(fault->kind, FaultKind::kYawJump);
  EXPECT_EQ(fault->time, 12.5);
  EXPECT_EQ(fault->size, 45.0);
}

TEST(OdometryFaults, WheelsKnowNoHeight) {
  std::vector<Pose> slope(200, Pose::Identity());
  for (std::size_t i = 0; i < slope.size(); ++i) {
    slope[i].translation() = Vec3(0.5, 0, 0.05) * static_cast<double>(i);
    slope[i].linear() =
        Eigen::AngleAxisd(0.02 * std::sin(0.1 * static_cast<double>(i)), Vec3::UnitX()).toRotationMatrix();
  }
  double turned_deg = 0;
  constexpr int kSeeds = 40;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const auto poses = disturbOdometry(slope, *odometryPreset("wheel"), seed);
    for (const Pose& pose : poses) {
      ASSERT_EQ(pose.translation().z(), 0.0);
      ASSERT_NEAR(pose.linear()(2, 2), 1.0, 1e-12);
    }
    turned_deg += std::abs(yawOf(poses.back())) / kSeeds;
  }
  EXPECT_NEAR(turned_deg, 10.0, 2.0);  // 1 degree in 10 m over 100 m
}

}  // namespace
}  // namespace hgg::odometry_faults_test
