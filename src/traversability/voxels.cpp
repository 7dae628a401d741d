#include "traversability/voxels.h"

#include <fmt/format.h>

#include <algorithm>

#include "traversability/columns.h"
#include "traversability/obsolete.h"
#include "traversability/point_density.h"

namespace hgg {
namespace {

// OctoMap's own values for beams: log-odds of a hit (0.7), of a pass (0.4), and where they are cut off (0.97).
constexpr float kHit = 0.8473F, kPass = -0.4055F, kMostOccupied = 3.5F;
/// Weakest hit: a sheet between whose points a voxel lies.
constexpr float kLeastHit = 0.2F;
/// Views of a node that free space is cast from: more of them see the same space again.
constexpr std::size_t kEyes = 3;
/// Most bricks, of 2 KiB each.
constexpr std::size_t kMaxBricks = 1'000'000;
/// Rays end this far apart on a sheet: free space is wider than surfaces are thick. m
constexpr double kRaySpacing = 0.4;
/// Edge of the columns in which coarse leaves are held against finer ones. m
constexpr double kLeastColumn = 0.2;
/// A ray ends this many voxels before its sheet, which is as thick as its voxels.
constexpr double kShortOf = 1;

std::int32_t floorDiv(std::int32_t a) { return a >= 0 ? a / VoxelGrid::kEdge : -((-a - 1) / VoxelGrid::kEdge) - 1; }

bool isWithin(const VoxelOptions& options, const Vec3& p) {
  const std::optional<GridRegion>& r = options.region;
  return !r || (p.x() >= r->x_min && p.x() < r->x_max && p.y() >= r->y_min && p.y() < r->y_max);
}

/// A sheet with the places it was seen from.
struct SeenSheet {
  LeafSheet sheet;
  std::uint32_t eyes = 0;  // index into the lists of eyes
  ClassId label = 0;
};

struct Scene {
  std::vector<SeenSheet> sheets;
  std::vector<std::vector<Vec3>> eyes;  // map frame; one list a node
};

/// The keyframe a node was made from, the one of its time nearest to it, and the last one of its time.
std::vector<Vec3> eyesOf(const MapLeaves& map, const MapNode& node) {
  const std::vector<TimedPose>& poses = map.keyframes;
  const auto first = std::ranges::lower_bound(poses, node.first_us, {}, &TimedPose::utime_us);
  const auto end = std::ranges::upper_bound(poses, node.last_us, {}, &TimedPose::utime_us);
  std::vector<Vec3> eyes;
  const auto add = [&](const TimedPose& pose) {
    const Vec3 p = pose.T_map_body.translation();
    if (eyes.size() < kEyes && std::ranges::find(eyes, p) == eyes.end()) {
      eyes.push_back(p);
    }
  };
  if (node.anchor >= 0 && static_cast<std::size_t>(node.anchor) < poses.size()) {
    add(poses[static_cast<std::size_t>(node.anchor)]);
  }
  if (first < end) {
    add(*std::ranges::min_element(first, end, {}, [&](const TimedPose& pose) {
      return (pose.T_map_body.translation() - node.belief.mean).squaredNorm();
    }));
    add(*(end - 1));
  }
  return eyes;
}

Scene sceneOf(const MapLeaves& map, const VoxelOptions& options) {
  Scene scene;
  PointDensity density;
  std::vector<PlacedSheet> placed;
  for (const auto& [id, node] : map.nodes) {
    if (!isSolid(node)) {
      continue;
    }
    scene.eyes.push_back(eyesOf(map, node));
    const NodeView view = viewOf(map, node);
    for (const Leaf& leaf : leavesOf(node)) {
      placed.push_back(placeLeaf(leaf, view));
      density.add(placed.back().sheet);
      scene.sheets.push_back({placed.back().sheet, static_cast<std::uint32_t>(scene.eyes.size() - 1), node.label});
    }
  }
  const auto is_out = [&](const LeafSheet& sheet) {
    const Vec3 half = halfBox(sheet), low = sheet.centre - half, high = sheet.centre + half;
    const std::optional<GridRegion>& r = options.region;
    return !density.believes(sheet) ||
           (r && (low.x() >= r->x_max || high.x() < r->x_min || low.y() >= r->y_max || high.y() < r->y_min));
  };
  std::erase_if(scene.sheets, [&](const SeenSheet& s) { return is_out(s.sheet); });
  std::erase_if(placed, [&](const PlacedSheet& p) { return is_out(p.sheet); });
  const std::vector<bool> obsolete = obsoleteSheets(placed, std::max(kLeastColumn, options.resolution));
  std::size_t k = 0;
  std::erase_if(scene.sheets, [&](const SeenSheet&) { return obsolete[k++]; });
  return scene;
}

void markHits(const SeenSheet& seen, const VoxelOptions& options, VoxelGrid& grid) {
  const LeafSheet& sheet = seen.sheet;
  // Points in a voxel's share of the sheet; each is worth a hit.
  const double points = densityOf(sheet) * grid.resolution() * grid.resolution() / kFootArea;
  const float hit = std::clamp(kHit * static_cast<float>(points), kLeastHit, kMostOccupied);
  forEachSample(sheet, grid.resolution() / 2, [&](const Vec3& p) {
    if (isWithin(options, p)) {
      const Voxel v = grid.voxelOf(p);
      float& log_odds = grid.at(v);
      if (log_odds == VoxelGrid::kUnknown || log_odds < hit) {
        log_odds = hit;
        if (options.classes) {
          grid.setLabel(v, seen.label);
        }
      }
    }
  });
}

/// Marks what lies between the eye and a sheet as free, from the eye on, up to the first surface (Amanatides and Woo's
/// walk through a grid). A hit that weighs less than a pass is no surface: between the few points of a distant sheet
/// beams went through.
void castFree(const Vec3& eye, const Vec3& p, const VoxelOptions& options, VoxelGrid& grid) {
  const Vec3 line = p - eye;
  const double length = line.norm(), r = grid.resolution();
  Voxel v = grid.voxelOf(eye), step{};
  std::array<double, 3> next{}, stride{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double d = line[static_cast<Eigen::Index>(k)] / length, from = eye[static_cast<Eigen::Index>(k)];
    step[k] = d > 0 ? 1 : -1;
    stride[k] = d == 0 ? std::numeric_limits<double>::infinity() : r / std::abs(d);
    next[k] = d == 0 ? stride[k] : (r * (v[k] + (d > 0 ? 1 : 0)) - from) / d;
  }
  for (double at = 0; at < length - kShortOf * r;) {
    const Vec3 centre = grid.centreOf(v);
    if (isWithin(options, centre)) {
      float& log_odds = grid.at(v);
      if (log_odds == VoxelGrid::kUnknown) {
        log_odds = kPass;
      } else if (log_odds + kPass > 0) {
        return;
      } else {
        log_odds = std::max(kPass, log_odds + kPass);
      }
    }
    const std::size_t axis = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
    at = next[axis];
    v[axis] += step[axis], next[axis] += stride[axis];
  }
}

}  // namespace

std::uint64_t VoxelGrid::keyOf(const Voxel& v) {
  std::uint64_t key = 0;
  for (const std::int32_t index : v) {
    key = key << 21 | (static_cast<std::uint64_t>(floorDiv(index) + kVoxelOffset) & 0x1FFFFF);
  }
  return key;
}

std::size_t VoxelGrid::insideOf(const Voxel& v) {
  std::size_t inside = 0;
  for (const std::int32_t index : v) {
    inside = inside * kEdge + static_cast<std::size_t>(index - floorDiv(index) * kEdge);
  }
  return inside;
}

float& VoxelGrid::at(const Voxel& v) {
  const std::uint64_t key = keyOf(v);
  if (key != last_key_) {
    const auto [it, is_new] = bricks_.try_emplace(key);
    if (is_new) {
      it->second.fill(kUnknown);
    }
    last_key_ = key, last_ = &it->second;
  }
  return (*last_)[insideOf(v)];
}

ClassId VoxelGrid::labelOf(const Voxel& v) const {
  const auto it = labels_.find(keyOf(v));
  return it == labels_.end() ? ClassId{0} : it->second[insideOf(v)];
}

void VoxelGrid::setLabel(const Voxel& v, ClassId label) { labels_[keyOf(v)][insideOf(v)] = label; }

std::vector<std::uint64_t> VoxelGrid::sortedBricks() const {
  std::vector<std::uint64_t> keys;
  keys.reserve(bricks_.size());
  for (const auto& [key, brick] : bricks_) {
    keys.push_back(key);
  }
  std::ranges::sort(keys);
  return keys;
}

Result<VoxelGrid> voxelsOf(const MapLeaves& map, const VoxelOptions& options, const ShareDone& progress) {
  using Voxels = Result<VoxelGrid>;
  if (!(options.resolution >= kMinResolution && options.resolution <= kMaxResolution)) {
    return Voxels::fail(
        fmt::format("a resolution of {} m is outside {} .. {} m", options.resolution, kMinResolution, kMaxResolution));
  }
  const Scene scene = sceneOf(map, options);
  if (scene.sheets.empty()) {
    return Voxels::fail("the map has no surface there");
  }
  double samples = 0;
  for (const SeenSheet& s : scene.sheets) {
    samples += areaOf(s.sheet, options.resolution) / (options.resolution * options.resolution / 4);
  }
  const auto too_fine = [&] {
    return Voxels::fail(
        fmt::format("the surfaces there have too many voxels of {} m: ask for a smaller region or a "
                    "coarser resolution",
                    options.resolution));
  };
  if (samples > options.most_samples) {
    return too_fine();
  }
  VoxelGrid grid(options.resolution);
  double done = 0;
  const auto tell = [&] {
    done += 1;
    if (progress) {
      progress(done / (2 * static_cast<double>(scene.sheets.size())));
    }
    return grid.bricks() <= kMaxBricks;
  };
  for (const SeenSheet& s : scene.sheets) {
    markHits(s, options, grid);
    if (!tell()) {
      return too_fine();
    }
  }
  for (const SeenSheet& s : scene.sheets) {
    for (const Vec3& eye : scene.eyes[s.eyes]) {
      forEachSample(s.sheet, std::max(kRaySpacing, 2 * options.resolution),
                    [&](const Vec3& p) { castFree(eye, p, options, grid); });
    }
    if (!tell()) {
      return too_fine();
    }
  }
  return Voxels::ok(std::move(grid));
}

}  // namespace hgg
