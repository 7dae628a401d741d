#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "config.h"
#include "map/object_graph.h"
#include "publish/messages.h"
#include "traversability/cost_grid.h"
#include "traversability/leaf_copy.h"
#include "traversability/live_grid.h"
#include "traversability/voxels.h"

namespace hgg {

/// What to make, and of which state of the map.
struct GroundJob {
  LeafChanges changes;  // since the last job
  Micros utime_us = 0;  // of the newest frame
  std::int64_t revision = 0;
  Vec3 p_map_body = Vec3::Zero();
  bool follows = false;                            // the grid around the robot follows the map, sent or not
  bool wants_grid = false, wants_octomap = false;  // around the robot, to be sent
  std::optional<std::map<ClassId, std::string>> wants_regions;  // class names of the map whose regions are to be sent
  std::vector<Command> commands;                                // PUBLISH_TRAVERSABILITY, PUBLISH_OCTOMAP
};

/// Makes grids, OctoMaps and regions of a copy of the map and hands them to its sinks. Slow: for a thread of its own.
class GroundMaker {
 public:
  using GridSink = std::function<void(const GroundGrid&)>;
  using OctomapSink = std::function<void(const OctomapBytes&)>;
  using RegionsSink = std::function<void(const RegionsUpdate&)>;
  /// Of the grid around the robot (LiveGrid): an update takes a third of the time between two frames.
  static constexpr int kTurns = 64;

  GroundMaker(const TraversabilityConfig& config, const EdgeModel& edges, GridSink grid, OctomapSink octomap,
              RegionsSink regions)
      : config_(config),
        edges_(edges),
        send_grid_(std::move(grid)),
        send_octomap_(std::move(octomap)),
        send_regions_(std::move(regions)),
        around_(config, kTurns) {}

  /// Returns the answers to the job's commands, in their order.
  std::vector<CommandReply> carryOut(GroundJob job);

 private:
  void publishAround(const GroundJob& job);
  CommandReply answer(const GroundJob& job, const Command& command);
  /// What was sent, or an error.
  Result<std::string> sendGrid(const GroundJob& job, const Command& command);
  Result<std::string> sendOctomap(const GroundJob& job, const Command& command);
  void send(const GroundJob& job, const CostGrid& grid, double reference_z);
  /// Returns how many messages it took.
  std::size_t send(const GroundJob& job, const VoxelGrid& voxels);

  TraversabilityConfig config_;
  EdgeModel edges_;  // of the regions
  GridSink send_grid_;
  OctomapSink send_octomap_;
  RegionsSink send_regions_;
  LeafCopy copy_;
  LiveGrid around_;
};

}  // namespace hgg
