#include "bus/lcm_sink.h"

#include <atomic>
#include <memory>

#include "bus/codec.h"

namespace hgg {

Sink lcmSink(Bus& bus, const LcmConfig& lcm) {
  const auto unsent = std::make_shared<std::atomic<std::int64_t>>(0);  // all functions of a sink share it
  const auto send = [&bus, unsent](const std::string& channel, const std::vector<std::uint8_t>& message) {
    if (!bus.publish(channel, message)) {
      ++*unsent;
    }
  };
  Sink sink;
  sink.pose = [send, lcm](const PoseUpdate& pose) {
    send(lcm.pose_map, encodePose(pose.utime_us, pose.T_map_body));
    send(lcm.map_odom, encodeRigidTransform(pose.utime_us, pose.T_map_odom));
  };
  sink.graph = [send, lcm](const GraphUpdate& update) { send(lcm.map_objects, encodeGraphUpdate(update)); };
  sink.status = [send, lcm](const Status& status) { send(lcm.status, encodeStatus(status)); };
  sink.ground = [send, lcm](const GroundGrid& grid) {
    for (const std::vector<std::uint8_t>& message : encodeTraversability(grid)) {
      send(lcm.map_traversability, message);
    }
  };
  sink.octomap = [send, lcm](const OctomapBytes& octomap) { send(lcm.octomap, encodeOctomap(octomap)); };
  sink.reply = [send, lcm](const CommandReply& reply) { send(lcm.command_reply, encodeCommandReply(reply)); };
  sink.goal = [send, lcm](const GoalReply& reply) { send(lcm.goal_reply, encodeGoalReply(reply)); };
  sink.regions = [send, lcm](const RegionsUpdate& update) { send(lcm.map_regions, encodeRegions(update)); };
  sink.take_unsent = [unsent] { return unsent->exchange(0); };
  return sink;
}

}  // namespace hgg
