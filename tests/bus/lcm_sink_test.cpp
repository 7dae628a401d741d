#include "bus/lcm_sink.h"

#include <gtest/gtest.h>

#include "bus/codec.h"
#include "bus/log.h"
#include "tools/scratch.h"

namespace hgg::lcm_sink_test {
namespace {

using Message = std::vector<std::uint8_t>;
constexpr std::chrono::seconds kPatience(20);  // a bound for a broken bus; a working one answers at once

/// A bus that hears itself: what goes out on POSE_ODOM comes in as odometry, in order.
Result<std::unique_ptr<Bus>> openBus() {
  LcmConfig lcm;
  lcm.url = "memq://";
  return Bus::open(lcm);
}

std::vector<Message> takeOdometry(Bus& bus, std::size_t count) {
  std::vector<Message> messages;
  const auto give_up = std::chrono::steady_clock::now() + kPatience;
  while (messages.size() < count && std::chrono::steady_clock::now() < give_up) {
    for (RawMessage& message : bus.take(std::chrono::milliseconds(100)).odometry) {
      messages.push_back(std::move(message.bytes));
    }
  }
  return messages;
}

TEST(LcmSink, SendsEveryMessageOnItsChannel) {
  const auto bus = openBus();
  ASSERT_TRUE(bus) << bus.error;
  Pose T_map_body = Pose::Identity(), T_map_odom = Pose::Identity();
  T_map_body.translation() = Vec3(1, 2, 3);
  T_map_odom.translation() = Vec3(4, 5, 6);
  GraphUpdate graph;
  graph.revision = 8;
  Status status;
  status.frames = 9;
  GroundGrid grid;
  grid.width = grid.height = 1, grid.cost = {3};
  const OctomapBytes octomap{10, "bytes"};
  CommandReply reply;
  reply.request_id = 11;
  const RegionsUpdate regions{12, 13, {}};
  const std::vector<Message> expected{encodePose(7, T_map_body),          encodeRigidTransform(7, T_map_odom),
                                      encodeGraphUpdate(graph),           encodeStatus(status),
                                      encodeTraversability(grid).front(), encodeOctomap(octomap),
                                      encodeCommandReply(reply),          encodeRegions(regions)};
  // One channel at a time is the one that is heard.
  for (std::size_t heard = 0; heard < expected.size(); ++heard) {
    LcmConfig lcm;
    std::string* channels[] = {&lcm.pose_map,           &lcm.map_odom, &lcm.map_objects,   &lcm.status,
                               &lcm.map_traversability, &lcm.octomap,  &lcm.command_reply, &lcm.map_regions};
    *channels[heard] = lcm.odometry;
    const Sink sink = lcmSink(**bus, lcm);
    sink.pose({7, T_map_body, T_map_odom});
    sink.graph(graph);
    sink.status(status);
    sink.ground(grid);
    sink.octomap(octomap);
    sink.reply(reply);
    sink.regions(regions);
    EXPECT_EQ(takeOdometry(**bus, 1), std::vector<Message>{expected[heard]}) << heard;
    EXPECT_EQ(sink.take_unsent(), 0);
  }
}

TEST(LcmSink, CountsWhatCouldNotBeSentOnce) {
  const Scratch scratch;
  const std::string path = (scratch / "log.lcm").string();
  auto log = LogWriter::create(path);
  ASSERT_EQ(log->write("OTHER", 1, Message{1}), "");
  ASSERT_EQ(log->close(), "");
  LcmConfig lcm;
  lcm.url = "file://" + path;  // a log that is read takes no messages
  const auto bus = Bus::open(lcm);
  ASSERT_TRUE(bus) << bus.error;
  const Sink sink = lcmSink(**bus, lcm);
  sink.pose({});
  sink.status({});
  EXPECT_EQ(sink.take_unsent(), 3);  // two of the pose
  EXPECT_EQ(sink.take_unsent(), 0);
}

}  // namespace
}  // namespace hgg::lcm_sink_test
