#include "publish/ground_maker.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "region/regions.h"
#include "traversability/grid_layers.h"
#include "traversability/octomap_export.h"

namespace hgg {
namespace {

/// A command must not keep the robot's own grid waiting for long: some seconds at most.
constexpr double kMostCells = 4e6;
constexpr double kMostSamples = 2e8;
/// Of an OctoMap's data in one message: receivers have buffers of a few MB.
constexpr std::size_t kMostBytes = 1'000'000;
/// The grid around the robot follows it in steps of this. m
constexpr double kFollowStep = 2;

GridRegion around(const Vec3& p, double size) {
  const double x = kFollowStep * std::round(p.x() / kFollowStep), y = kFollowStep * std::round(p.y() / kFollowStep);
  return {x - size / 2, y - size / 2, x + size / 2, y + size / 2};
}

std::optional<GridRegion> regionOf(const Command& command) {
  const auto& r = command.region;
  return r ? std::optional(GridRegion{(*r)[0], (*r)[1], (*r)[2], (*r)[3]}) : std::nullopt;
}

}  // namespace

std::vector<CommandReply> GroundMaker::carryOut(GroundJob job) {
  copy_.apply(std::move(job.changes));
  publishAround(job);
  if (job.wants_regions) {
    send_regions_({job.utime_us, job.revision, findRegions(copy_.leaves(), *job.wants_regions, edges_)});
  }
  std::vector<CommandReply> replies;
  for (const Command& command : job.commands) {
    const auto start = std::chrono::steady_clock::now();
    replies.push_back(answer(job, command));
    replies.back().ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  }
  return replies;
}

void GroundMaker::publishAround(const GroundJob& job) {
  const GridRegion region = around(job.p_map_body, config_.publish_size);
  if (const auto shape = gridShape(region, config_.resolution); shape && (job.follows || job.wants_grid)) {
    const CostGrid& grid = around_.update(copy_.leaves(), *shape, job.p_map_body.head<2>());
    if (job.wants_grid) {
      const std::optional<double> ground = groundBelow(grid, job.p_map_body);
      send(job, grid, ground ? *ground : groundHeight(copy_.leaves(), grid));
    }
  }
  if (job.wants_octomap) {
    // An error is a place where nothing was seen yet: there is nothing to tell.
    if (const auto voxels = voxelsOf(copy_.leaves(), {config_.octomap_resolution, region, kMostSamples})) {
      send(job, *voxels);
    }
  }
}

CommandReply GroundMaker::answer(const GroundJob& job, const Command& command) {
  const Result<std::string> done =
      command.kind == CommandKind::kPublishTraversability ? sendGrid(job, command) : sendOctomap(job, command);
  CommandReply reply;
  reply.utime_us = job.utime_us, reply.revision = job.revision;
  reply.client = command.client, reply.request_id = command.request_id, reply.kind = command.kind;
  reply.ok = static_cast<bool>(done);
  reply.text = done ? *done : done.error;
  return reply;
}

Result<std::string> GroundMaker::sendGrid(const GroundJob& job, const Command& command) {
  const Result<GridRegion> region = regionWithin(copy_.leaves(), regionOf(command));
  if (!region) {
    return Result<std::string>::fail(region.error);
  }
  const Result<GridShape> shape =
      gridShape(*region, command.resolution == 0 ? config_.resolution : command.resolution, kMostCells);
  if (!shape) {
    return Result<std::string>::fail(shape.error);
  }
  const CostGrid grid = buildCostGrid(copy_.leaves(), *shape, config_);
  const bool is_asked = command.region && std::isfinite(command.reference_z);
  send(job, grid, is_asked ? command.reference_z : groundHeight(copy_.leaves(), grid));
  return Result<std::string>::ok(
      fmt::format("sent {} x {} cells of {} m", shape->width, shape->height, shape->resolution));
}

Result<std::string> GroundMaker::sendOctomap(const GroundJob& job, const Command& command) {
  const Result<GridRegion> region = regionWithin(copy_.leaves(), regionOf(command));
  if (!region) {
    return Result<std::string>::fail(region.error);
  }
  VoxelOptions options{command.resolution == 0 ? config_.octomap_resolution : command.resolution, std::nullopt,
                       kMostSamples};
  if (command.region) {
    options.region = *region;
  }
  const Result<VoxelGrid> voxels = voxelsOf(copy_.leaves(), options);
  if (!voxels) {
    return Result<std::string>::fail(voxels.error);
  }
  const std::size_t parts = send(job, *voxels);
  return Result<std::string>::ok(
      fmt::format("sent voxels of {} m in {} message{}", options.resolution, parts, parts == 1 ? "" : "s"));
}

void GroundMaker::send(const GroundJob& job, const CostGrid& grid, double reference_z) {
  GridLayers layers = layersOf(grid, reference_z);
  GroundGrid out;
  out.utime_us = job.utime_us, out.revision = job.revision;
  out.x = grid.shape.x, out.y = grid.shape.y, out.resolution = grid.shape.resolution;
  out.width = grid.shape.width, out.height = grid.shape.height, out.levels = layers.levels;
  out.reference_z = reference_z;
  out.cost = std::move(layers.cost);
  for (FloatLayer& layer : layers.layers) {
    out.layers.push_back({std::move(layer.name), std::move(layer.values)});
  }
  send_grid_(out);
}

std::size_t GroundMaker::send(const GroundJob& job, const VoxelGrid& voxels) {
  std::vector<std::string> parts = octomapParts(voxels, kMostBytes);
  for (std::string& part : parts) {
    send_octomap_({job.utime_us, std::move(part)});
  }
  return parts.size();
}

}  // namespace hgg
