#include "inputs.h"

#include <gtest/gtest.h>

#include "bus/codec.h"

namespace hgg::inputs_test {
namespace {

constexpr Micros kStart_us = 1'317'042'145'964'000;
constexpr Micros kPeriod_us = 100'000;
const LcmConfig kLcm;

using Message = std::vector<std::uint8_t>;

Message pose(Micros utime_us) { return encodePose(utime_us, Pose::Identity()); }
Message cloud(Micros utime_us) { return encodeSemanticCloud(utime_us, {}); }

Micros timeOf(int i) { return kStart_us + i * kPeriod_us; }

/// What a drive of `frames` leaves, the stamps of the clouds as `stamp` makes them of the true ones.
template <typename Stamp>
InputWatch drive(int frames, Stamp stamp, const std::string& cloud_channel = kLcm.lidar_semantic) {
  InputWatch watch;
  for (int i = 0; i < frames; ++i) {
    watch.add(kLcm.odometry, timeOf(i), pose(timeOf(i)));
    watch.add(cloud_channel, timeOf(i), cloud(stamp(timeOf(i))));
  }
  return watch;
}

void expectSays(const std::string& line, std::initializer_list<const char*> parts) {
  for (const char* part : parts) {
    EXPECT_NE(line.find(part), std::string::npos) << "'" << part << "' in\n" << line;
  }
  EXPECT_EQ(line.find('\n'), std::string::npos) << line;
}

TEST(InputWatch, GoodInputsHaveNoFaultAndNothingOdd) {
  for (const int frames : {1, 4, 40, 4000}) {
    const InputWatch watch = drive(frames, [](Micros t) { return t - 60'000; });
    EXPECT_TRUE(watch.faults(kLcm).empty()) << watch.faults(kLcm)[0];
    EXPECT_TRUE(watch.oddities(kLcm).empty()) << watch.oddities(kLcm)[0];
  }
}

TEST(InputWatch, UnitsThatAreNotMicrosecondsAreNamed) {
  const auto unitOf = [](auto stamp) {
    const auto faults = drive(100, stamp).faults(kLcm);
    return faults.empty() ? "" : faults[0];
  };
  expectSays(unitOf([](Micros t) { return t / 1'000'000; }), {"LIDAR_SEMANTIC", "look like seconds"});
  expectSays(unitOf([](Micros t) { return t / 1000; }), {"look like milliseconds"});
  expectSays(unitOf([](Micros t) { return t * 1000; }), {"look like nanoseconds"});
  expectSays(unitOf([](Micros t) { return (t - kStart_us) * 1000 + 7; }), {"look like nanoseconds"});
}

TEST(InputWatch, AFewWrongStampsAreNoOtherUnit) {
  for (const Micros off_us : {Micros{3'600'000'000}, Micros{500'000}, -kStart_us}) {
    for (const int wrong : {0, 10, 30, 39}) {
      const auto faults = drive(40, [&](Micros t) { return t == timeOf(wrong) ? t + off_us : t; }).faults(kLcm);
      EXPECT_TRUE(faults.empty()) << off_us << ": " << faults[0];
      EXPECT_TRUE(drive(40, [&](Micros t) { return t == timeOf(wrong) ? t + off_us : t; }).oddities(kLcm).empty());
    }
  }
}

TEST(InputWatch, StampsThatAreAllTheSameAreAFault) {
  const auto faults = drive(40, [](Micros) { return 0; }).faults(kLcm);
  ASSERT_EQ(faults.size(), 1U);
  expectSays(faults[0], {"all 40 stamps of LIDAR_SEMANTIC are the same, 0"});
}

TEST(InputWatch, ClocksThatDifferAreToldWithTheDifference) {
  const auto odd = drive(40, [](Micros t) { return t + 37'000'000; }).oddities(kLcm);
  ASSERT_EQ(odd.size(), 1U);
  expectSays(odd[0], {"LIDAR_SEMANTIC", "37.0 s ahead of", "POSE_ODOM"});
}

TEST(InputWatch, WithoutFramesItSaysWhatThereIs) {
  const auto explained = [](const InputWatch& watch) { return watch.explainNoFrames(kLcm, {}); };
  expectSays(explained(drive(
                 40, [](Micros t) { return t; }, "VELODYNE")),
             {"nothing came on LIDAR_SEMANTIC (lcm.lidar_semantic", "VELODYNE: 40 bot_core.pointcloud2_t",
              "POSE_ODOM: 40 bot_core.pose_t"});
  expectSays(explained(drive(40, [](Micros t) { return t - kStart_us + 5'000'000; })),
             {"the stamps of LIDAR_SEMANTIC (5000000 .. 8900000)", "lie 41.7 years before", "POSE_ODOM"});
  InputWatch swapped;
  swapped.add(kLcm.lidar_semantic, 0, pose(1));
  swapped.add(kLcm.odometry, 0, cloud(1));
  expectSays(explained(swapped),
             {"none of the 1 messages on LIDAR_SEMANTIC (lcm.lidar_semantic) is a bot_core.pointcloud2_t",
              "none of the 1 messages on POSE_ODOM (lcm.odometry) is a bot_core.pose_t"});
}

TEST(InputWatch, WithoutFramesItSaysWhatBecameOfTheMessages) {
  RunCounts counts;
  counts.decode_errors["cloud: truncated"] = 7;
  counts.drops.causes["odometry: begins after the cloud"] = 3;
  expectSays(drive(1, [](Micros t) { return t; }).explainNoFrames(kLcm, counts),
             {"7 messages unreadable (cloud: truncated)", "3 clouds dropped (odometry: begins after the cloud)"});
}

TEST(InputWatch, StampsBeyondAllReasonAreTakenAsTheyCome) {
  InputWatch watch;
  for (int i = 0; i < 10; ++i) {
    watch.add(kLcm.odometry, std::numeric_limits<Micros>::min() + i, pose(std::numeric_limits<Micros>::max() - i));
    watch.add(kLcm.lidar_semantic, std::numeric_limits<Micros>::max(), cloud(std::numeric_limits<Micros>::min() + i));
  }
  EXPECT_TRUE(watch.faults(kLcm).empty());
  EXPECT_FALSE(watch.explainNoFrames(kLcm, {}).empty());
}

TEST(InputWatch, ShortAndForeignMessagesAreCountedOnly) {
  InputWatch watch;
  EXPECT_TRUE(watch.isEmpty());
  watch.add("EMPTY", 0, {});
  watch.add("EMPTY", 0, Message(30, 7));
  EXPECT_FALSE(watch.isEmpty());
  expectSays(watch.explainNoFrames(kLcm, {}), {"channels: EMPTY: 2"});
}

}  // namespace
}  // namespace hgg::inputs_test
