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
  counts.frames = 10, counts.drops = {1, 1, 1, {{"cloud: late or twice", 1}}}, counts.restarts = 2,
  counts.decode_errors = {{"cloud: truncated", 3}};
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

TEST(Health, RejectedSamplesAndDroppedCloudsAreToldByCause) {
  RunCounts before, now;
  now.drops = {0, 2, 1, {{"cloud: late or twice", 1}, {"odometry: begins after the cloud", 2}}};
  now.odometry_rejected = 3, now.odometry_outliers = 1, now.odometry_anew = 1;
  EXPECT_EQ(describeTroubles(before, now),
            (std::vector<std::string>{"1 clouds dropped: cloud: late or twice (1 in all)",
                                      "2 clouds dropped: odometry: begins after the cloud (2 in all)",
                                      "3 odometry samples rejected, 1 of them with stamps out of line (3 in all)",
                                      "the odometry began anew: its clock went back, or it paused"}));
  const Status status = describeHealth({}, {0, before}, {1'000'000, now}, Map(), "POSE_ODOM");
  using Drops = std::vector<std::pair<std::string, std::int64_t>>;
  EXPECT_EQ(status.drops, (Drops{{"cloud: late or twice", 1},
                                 {"odometry: begins after the cloud", 2},
                                 {"odometry: sample late or twice", 2},
                                 {"odometry: sample with a stamp out of line", 1}}));
}

TEST(Health, OddInputsAreToldOnce) {
  RunCounts before, now;
  now.oddities = {"the clocks differ"};
  EXPECT_EQ(describeTroubles(before, now), now.oddities);
  EXPECT_TRUE(describeTroubles(now, now).empty());
}

/// A frame that is as it should be.
LatestFrame goodFrame() {
  LatestFrame latest;
  latest.alignment = "aligned";
  latest.pose_cov.diagonal() << 0.01, 0.04, 0.0025, 1e-4, 1e-4, 4e-4;
  return latest;
}

Status statusOf(const LatestFrame& latest, double delay_s = 0) {
  RunCounts counts;
  counts.odometry_delay_s = delay_s;
  return describeHealth(latest, {0, counts}, {1'000'000, counts}, Map(), "POSE_ODOM");
}

std::vector<std::string> codesOf(const Status& status) {
  std::vector<std::string> codes;
  for (const Alarm& alarm : status.alarms) {
    EXPECT_FALSE(alarm.text.empty()) << alarm.code;
    codes.push_back(alarm.code);
  }
  return codes;
}
using Codes = std::vector<std::string>;

TEST(Health, WhereNothingIsWrongItIsOk) {
  const Status status = statusOf(goodFrame());
  EXPECT_EQ(status.state, HealthState::kOk);
  EXPECT_EQ(codesOf(status), Codes{});
  EXPECT_EQ(status.fragment, 0);
}

TEST(Health, ACameraThatGivesNoLabelsDegrades) {
  RunCounts counts;
  counts.rig.emplace();
  counts.rig->troubles["front: no image in time"] = 7;
  counts.rig->standing = {{"front", "camera_out", "camera front gives no labels: no image in time"}};
  const Status status = describeHealth(goodFrame(), {0, {}}, {1'000'000, counts}, Map(), "POSE_ODOM");
  EXPECT_EQ(status.state, HealthState::kDegraded);
  EXPECT_EQ(codesOf(status), Codes{"camera_out"});
  EXPECT_EQ(status.alarms[0].subject, "front");
  EXPECT_EQ(status.drops, (std::vector<std::pair<std::string, std::int64_t>>{{"front: no image in time", 7}}));
  EXPECT_EQ(describeTroubles({}, counts).size(), 1U);
  EXPECT_TRUE(describeTroubles(counts, counts).empty());
}

TEST(Health, HowWellThePlaceIsKnownIsThatOfTheWorstAxis) {
  const Status status = statusOf(goodFrame());
  EXPECT_DOUBLE_EQ(status.position_sigma, 0.2);
  EXPECT_DOUBLE_EQ(status.heading_sigma, 0.02);
}

TEST(Health, BeforeTheFirstFrameNothingIsKnown) {
  const Status status = statusOf({});
  EXPECT_EQ(status.state, HealthState::kUnknown);
  EXPECT_EQ(codesOf(status), Codes{});
  EXPECT_EQ(status.position_sigma, 0);
}

TEST(Health, InAFragmentOfItsOwnTheRobotIsLost) {
  LatestFrame latest = goodFrame();
  latest.fragment = 17;
  const Status status = statusOf(latest);
  EXPECT_EQ(status.state, HealthState::kLost);
  ASSERT_EQ(codesOf(status), Codes{"lost"});
  EXPECT_TRUE(status.alarms[0].is_serious);
  EXPECT_EQ(status.fragment, 17);
  latest.fragment = 0, latest.tracking = Tracking::kLost;
  EXPECT_EQ(statusOf(latest).state, HealthState::kLost) << "the frame that loses it already";
}

TEST(Health, DoubtIsDegradedAndARecoveryIsNot) {
  LatestFrame latest = goodFrame();
  latest.tracking = Tracking::kDoubtful;
  EXPECT_EQ(statusOf(latest).state, HealthState::kDegraded);
  EXPECT_EQ(codesOf(statusOf(latest)), Codes{"doubtful"});
  latest.tracking = Tracking::kRecovered;
  EXPECT_EQ(statusOf(latest).state, HealthState::kOk);
}

TEST(Health, AFaultOfOdometryIsDegradedAndNamesItsChannel) {
  for (const auto fault : {OdometryFault::kJump, OdometryFault::kFrozen, OdometryFault::kSlip, OdometryFault::kAxes}) {
    LatestFrame latest = goodFrame();
    latest.odometry_fault = fault;
    const Status status = statusOf(latest);
    EXPECT_EQ(status.state, HealthState::kDegraded);
    EXPECT_EQ(codesOf(status), Codes{codeOf(fault)});
    EXPECT_EQ(status.alarms.at(0).subject, "POSE_ODOM");
    EXPECT_FALSE(status.alarms.at(0).is_serious);
  }
}

TEST(Health, ADelayOfOdometryIsToldInMilliseconds) {
  const Status status = statusOf(goodFrame(), 0.104);
  EXPECT_EQ(status.state, HealthState::kDegraded);
  ASSERT_EQ(codesOf(status), Codes{"odometry_lag"});
  EXPECT_EQ(status.alarms[0].text, "odometry's stamps lag 104 ms behind the clouds': undone");
  EXPECT_EQ(status.alarms[0].subject, "POSE_ODOM");
}

TEST(Health, EverythingThatIsWrongIsToldAndTheWorstOfItIsTheState) {
  LatestFrame latest = goodFrame();
  latest.fragment = 3, latest.odometry_fault = OdometryFault::kSlip;
  const Status status = statusOf(latest, -0.06);
  EXPECT_EQ(codesOf(status), (Codes{"lost", "odometry_slip", "odometry_lag"}));
  EXPECT_EQ(status.state, HealthState::kLost);
}

}  // namespace
}  // namespace hgg::health_test
