// An OctoMap from the graph beside one from all raw points (octomap's insertPointCloud) of the same log. Needs a log
// with true-sized clouds:
//   HGG_BENCH_LOG=kitti_0001.lcm HGG_BENCH_CONFIG=firmware_cfg/semantickitti/hggmap.toml hgg_bench
//   --benchmark_filter=Octomap
#include <benchmark/benchmark.h>
#include <octomap/OcTree.h>

#include <atomic>
#include <cstdlib>
#include <ctime>
#include <map>
#include <memory>
#include <set>

#include "bus/codec.h"
#include "bus/log.h"
#include "replay.h"
#include "traversability/octomap_export.h"

namespace hgg::octomap_bench {
namespace {

/// Of this thread's work: what else the machine does is no part of the comparison.
double cpuSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// The log as it was mapped: the map, and the pose of every frame.
struct Drive {
  std::string log, error;
  std::unique_ptr<Mapper> mapper;
  std::map<Micros, Pose> T_map_body;
};

const Drive& drive() {
  static const Drive kDrive = [] {
    Drive d;
    const char* log = std::getenv("HGG_BENCH_LOG");
    const char* file = std::getenv("HGG_BENCH_CONFIG");
    const Result<LoadedConfig> config = loadConfig(file == nullptr ? "" : file);
    if (log == nullptr || !config) {
      d.error = log == nullptr ? "HGG_BENCH_LOG names no log" : config.error;
      return d;
    }
    d.log = log;
    d.mapper = std::make_unique<Mapper>(config->config, config->classes);
    const std::atomic<bool> stop{false};
    d.error =
        replayLog(
            log, *d.mapper,
            [&](const StepReport& report, const FrameTiming&) { d.T_map_body[report.utime_us] = report.T_map_body; },
            nullptr, stop)
            .error;
    return d;
  }();
  return kDrive;
}

/// All clouds of the log, inserted ray by ray.
std::unique_ptr<octomap::OcTree> rawTree(const Drive& d, double resolution, double& seconds) {
  auto tree = std::make_unique<octomap::OcTree>(resolution);
  auto log = LogReader::open(d.log);
  while (const auto event = log->next()) {
    if (event->channel != d.mapper->config().lcm.lidar_semantic) {
      continue;
    }
    const auto cloud = decodeSemanticCloud(event->data, 0);
    const auto pose = cloud ? d.T_map_body.find(cloud->utime_us) : d.T_map_body.end();
    if (pose == d.T_map_body.end()) {
      continue;
    }
    octomap::Pointcloud points;
    for (const Point& p : cloud->points) {
      const double range = std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
      if (range >= d.mapper->config().frame.range_min && range <= d.mapper->config().frame.range_max) {
        const Vec3 q = pose->second * Vec3(p.x, p.y, p.z);
        points.push_back(static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z()));
      }
    }
    const Vec3 eye = pose->second.translation();
    const double start = cpuSeconds();
    tree->insertPointCloud(points, octomap::point3d(static_cast<float>(eye.x()), static_cast<float>(eye.y()),
                                                    static_cast<float>(eye.z())));
    seconds += cpuSeconds() - start;
  }
  return tree;
}

constexpr double kNear = 20;  // m from the way, horizontally: where a map is asked for

bool isNear(const Drive& d, const Vec3& p) {
  for (const TimedPose& pose : d.mapper->map().keyframes().poses()) {
    if ((pose.T_map_body.translation() - p).head<2>().squaredNorm() < kNear * kNear) {
      return true;
    }
  }
  return false;
}

using Voxels = std::set<Voxel>;

double shareWithin(const Voxels& a, const Voxels& b) {
  double near = 0;
  for (const Voxel& v : a) {
    bool found = false;
    for (int k = 0; k < 27 && !found; ++k) {
      found = b.contains({v[0] + k % 3 - 1, v[1] + k / 3 % 3 - 1, v[2] + k / 9 - 1});
    }
    near += found ? 1 : 0;
  }
  return near / std::max(1.0, static_cast<double>(a.size()));
}

Voxels occupiedOf(const Drive& d, const octomap::OcTree& tree, const VoxelGrid& grid) {
  Voxels out;
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
    if (!tree.isNodeOccupied(*leaf)) {
      continue;
    }
    const double half = leaf.getSize() / 2, r = grid.resolution();
    for (double x = leaf.getX() - half + r / 2; x < leaf.getX() + half; x += r) {
      for (double y = leaf.getY() - half + r / 2; y < leaf.getY() + half; y += r) {
        for (double z = leaf.getZ() - half + r / 2; z < leaf.getZ() + half; z += r) {
          if (isNear(d, {x, y, z})) {
            out.insert(grid.voxelOf({x, y, z}));
          }
        }
      }
    }
  }
  return out;
}

void OctomapBesideRaw(benchmark::State& state) {
  const Drive& d = drive();
  if (!d.error.empty()) {
    state.SkipWithError(d.error.c_str());
    return;
  }
  const double resolution = static_cast<double>(state.range(0)) * 1e-3;
  for (auto _ : state) {
    const double start = cpuSeconds();
    const Result<VoxelGrid> voxels = voxelsOf(d.mapper->map(), {resolution, std::nullopt});
    const double voxels_s = cpuSeconds() - start;
    const std::string bytes = octomapBinary(*voxels);
    const double graph_s = cpuSeconds() - start;
    double raw_s = 0;
    const auto raw = rawTree(d, resolution, raw_s);
    octomap::OcTree graph(resolution);
    std::istringstream in(bytes);
    graph.readBinary(in);
    const Voxels ours = occupiedOf(d, graph, *voxels), theirs = occupiedOf(d, *raw, *voxels);
    const double precision = shareWithin(ours, theirs), recall = shareWithin(theirs, ours);
    const auto frames = static_cast<double>(d.T_map_body.size());
    state.counters["graph_ms_frame"] = 1e3 * graph_s / frames;
    state.counters["of_it_voxels_ms"] = 1e3 * voxels_s / frames;
    state.counters["raw_ms_frame"] = 1e3 * raw_s / frames;
    state.counters["times_less"] = raw_s / graph_s;
    state.counters["precision"] = precision, state.counters["recall"] = recall;
    state.counters["F1"] = 2 * precision * recall / (precision + recall);
    state.counters["graph_tree_MB"] = static_cast<double>(graph.memoryUsage()) * 1e-6;
    state.counters["raw_tree_MB"] = static_cast<double>(raw->memoryUsage()) * 1e-6;
    state.counters["map_MB"] = d.mapper->map().megabytes();
  }
}
BENCHMARK(OctomapBesideRaw)->Arg(200)->Arg(100)->Iterations(1)->Unit(benchmark::kSecond);

}  // namespace
}  // namespace hgg::octomap_bench
