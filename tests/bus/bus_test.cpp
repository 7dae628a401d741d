#include "bus/bus.h"

#include <gtest/gtest.h>

namespace hgg::bus_test {
namespace {

using Message = std::vector<std::uint8_t>;
constexpr std::chrono::seconds kPatience(20);  // a bound for a broken bus; a working one answers at once

LcmConfig inProcess() {
  LcmConfig lcm;
  lcm.url = "memq://";
  return lcm;
}

/// Takes until the odometry message `last` has come; receiving is in order, so everything sent before it has come too.
std::vector<Inbox> takeUntil(Bus& bus, const Message& last) {
  std::vector<Inbox> inboxes;
  const auto give_up = std::chrono::steady_clock::now() + kPatience;
  while (std::chrono::steady_clock::now() < give_up) {
    inboxes.push_back(bus.take(std::chrono::milliseconds(100)));
    const auto& odometry = inboxes.back().odometry;
    if (!odometry.empty() && odometry.back().bytes == last) {
      return inboxes;
    }
  }
  ADD_FAILURE() << "messages did not arrive";
  return inboxes;
}

TEST(Bus, OdometryArrivesCompleteAndInOrder) {
  const auto bus = Bus::open(inProcess());
  ASSERT_TRUE(bus) << bus.error;
  for (std::uint8_t i = 0; i < 200; ++i) {
    EXPECT_TRUE((*bus)->publish("POSE_ODOM", Message{i}));
  }
  std::vector<Message> got;
  for (const auto& inbox : takeUntil(**bus, {199})) {
    for (const RawMessage& message : inbox.odometry) {
      got.push_back(message.bytes);
    }
  }
  ASSERT_EQ(got.size(), 200u);
  for (std::uint8_t i = 0; i < 200; ++i) {
    EXPECT_EQ(got[i], Message{i});
  }
}

TEST(Bus, TheNewestCloudIsKeptAndTheOthersCounted) {
  const auto bus = Bus::open(inProcess());
  ASSERT_TRUE(bus) << bus.error;
  const int clouds = 20;
  for (std::uint8_t i = 0; i < clouds; ++i) {
    (*bus)->publish("LIDAR_SEMANTIC", Message(1000, i));
  }
  (*bus)->publish("POSE_ODOM", Message{1});
  std::int64_t taken = 0, replaced = 0;
  Message newest;
  for (const auto& inbox : takeUntil(**bus, {1})) {
    replaced += inbox.clouds_replaced;
    if (!inbox.cloud) {
      continue;
    }
    ++taken;
    newest = inbox.cloud->bytes;
  }
  EXPECT_EQ(taken + replaced, clouds);
  EXPECT_EQ(newest, Message(1000, clouds - 1));
}

TEST(Bus, CommandsArriveInOrderAndNoMoreThanItCanHold) {
  const auto bus = Bus::open(inProcess());
  ASSERT_TRUE(bus) << bus.error;
  for (std::uint8_t i = 0; i < 100; ++i) {
    (*bus)->publish("HGG_COMMAND", Message(2000, i));
  }
  (*bus)->publish("POSE_ODOM", Message{1});
  std::vector<Message> got;
  for (const auto& inbox : takeUntil(**bus, {1})) {
    for (const RawMessage& message : inbox.commands) {
      got.push_back(message.bytes);
    }
  }
  ASSERT_GE(got.size(), 64U);
  for (std::uint8_t i = 0; i < 64; ++i) {
    EXPECT_EQ(got[i], Message(1024, i)) << "no command is longer";
  }
}

TEST(Bus, OverlongOdometryIsCut) {
  const auto bus = Bus::open(inProcess());
  ASSERT_TRUE(bus) << bus.error;
  (*bus)->publish("POSE_ODOM", Message(1 << 20, 5));
  EXPECT_EQ(takeUntil(**bus, Message(1024, 5)).back().odometry.size(), 1u);
}

TEST(Bus, ChannelNamesAreNotExpressions) {
  LcmConfig lcm = inProcess();
  lcm.odometry = "robot[1].POSE+";
  const auto bus = Bus::open(lcm);
  ASSERT_TRUE(bus) << bus.error;
  (*bus)->publish("robot1xPOSEE", Message{1});
  (*bus)->publish("robot[1].POSE+", Message{2});
  const auto inboxes = takeUntil(**bus, {2});
  ASSERT_EQ(inboxes.back().odometry.size(), 1u);
  EXPECT_EQ(inboxes.back().odometry.front().bytes, Message{2});
}

TEST(Bus, AnInvalidUrlIsAClearError) {
  for (const std::string url :
       {"garbage", "carrier-pigeon://coop", "udpm://999.1.1.1:7667", "file:///nonexistent/log"}) {
    LcmConfig lcm;
    lcm.url = url;
    const auto bus = Bus::open(lcm);
    ASSERT_FALSE(bus);
    EXPECT_NE(bus.error.find("cannot open LCM url '" + url + "'"), std::string::npos);
  }
}

TEST(ReceiveBuffer, IsWarnedAboutWhenItHoldsLessThanTwoClouds) {
  constexpr std::int64_t kEnough = 4 << 20;
  const std::string asks = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304",
                    asks_not = "udpm://239.255.76.67:7667";
  const auto has = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  EXPECT_EQ(receiveBufferWarning(asks, {kEnough, 212992}), "");
  EXPECT_EQ(receiveBufferWarning(asks_not, {kEnough, kEnough}), "");
  const auto capped = receiveBufferWarning(asks, {212992, 212992});
  EXPECT_TRUE(has(capped, "holds 212992 bytes") && has(capped, "sysctl -w net.core.rmem_max=4194304")) << capped;
  EXPECT_FALSE(has(capped, "in the LCM url")) << capped;
  const auto unasked = receiveBufferWarning(asks_not, {kEnough, 212992});
  EXPECT_TRUE(has(unasked, "recv_buf_size=4194304 in the LCM url") && !has(unasked, "sysctl")) << unasked;
  EXPECT_EQ(receiveBufferWarning("memq://", {212992, 212992}), "");
  EXPECT_EQ(receiveBufferWarning(asks, {0, 0}), "");  // the kernel does not say
}

}  // namespace
}  // namespace hgg::bus_test
