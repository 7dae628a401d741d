#include "creation/instances.h"

#include <cmath>
#include <numbers>
#include <unordered_map>

namespace hgg {
namespace {

/// Points that may belong together: one class, and one segmenter instance (things) or one tile (stuff).
struct Group {
  const ClassInfo* info = nullptr;
  std::uint32_t instance = 0;
  Tile tile;
  std::size_t begin = 0, end = 0;
};

/// Kept points and the group of each, in the order of the frame.
struct Grouping {
  std::vector<PackedPoint> points;
  std::vector<std::uint32_t> group_of;
  std::vector<Group> groups;  // by first appearance
};

std::uint64_t groupKey(const ClassInfo& info, std::uint32_t instance, const Tile& tile) {
  const auto lane = [](std::int32_t v) { return static_cast<std::uint64_t>(v) & 0x7FFF; };
  const std::uint64_t low =
      info.kind == ClassKind::kStuff ? lane(tile.x) << 30 | lane(tile.y) << 15 | lane(tile.z) : instance;
  return static_cast<std::uint64_t>(info.id) << 48 | low;
}

class GroupTable {
 public:
  explicit GroupTable(std::vector<Group>& groups) : groups_(groups) {}
  std::uint32_t find(const ClassInfo& info, std::uint32_t instance, const Tile& tile) {
    const std::uint64_t key = groupKey(info, instance, tile);
    if (key == last_key_) {  // scans run along surfaces: most points follow one of their own group
      return last_;
    }
    const auto [it, fresh] = index_.try_emplace(key, static_cast<std::uint32_t>(groups_.size()));
    if (fresh) {
      groups_.push_back({&info, instance, tile, 0, 0});
    }
    last_key_ = key;
    return last_ = it->second;
  }

 private:
  std::vector<Group>& groups_;
  std::unordered_map<std::uint64_t, std::uint32_t> index_;
  std::uint64_t last_key_ = ~0ULL;
  std::uint32_t last_ = 0;
};

Grouping groupPoints(const Frame& frame, const Pose& T_map_body, const ClassTable& classes, const Config& config,
                     Instances& out) {
  const Eigen::Matrix3f R = T_map_body.linear().cast<float>();
  const Vec3 origin = T_map_body.translation() / config.creation.tile_size + Vec3::Constant(0.5);
  const auto per_tile = static_cast<float>(1 / config.creation.tile_size);
  const auto range_min = static_cast<float>(config.frame.range_min),
             range_max = static_cast<float>(config.frame.range_max);
  const Eigen::Vector3f sensor = frame.p_body_sensor.cast<float>();
  Grouping g;
  g.points.reserve(frame.points.size());
  g.group_of.reserve(frame.points.size());
  GroupTable table(g.groups);
  for (const Point& p : frame.points) {
    const Eigen::Vector3f v(p.x, p.y, p.z);
    const float square = (v - sensor).squaredNorm();
    if (!std::isfinite(square)) {
      ++out.nonfinite_points;
      continue;
    }
    if (square < range_min * range_min || square > range_max * range_max) {
      ++out.out_of_range_points;
      continue;
    }
    const ClassInfo* info = classes.find(p.label);
    if (info == nullptr || info->kind == ClassKind::kIgnore) {
      ++(info == nullptr ? out.unknown_labels : out.ignored_points);
      continue;
    }
    Tile tile;
    if (info->kind == ClassKind::kStuff) {
      const Eigen::Array3i t = ((R * v * per_tile).cast<double>() + origin).array().floor().cast<int>();
      tile = {t[0], t[1], t[2]};
    }
    g.group_of.push_back(table.find(*info, info->kind == ClassKind::kStuff ? 0 : p.instance, tile));
    g.points.emplace_back(p.x, p.y, p.z, 0.0F);
  }
  return g;
}

/// Points sorted by group, keeping their order inside it; fills the ranges of the groups.
std::vector<PackedPoint> sortByGroup(Grouping& g) {
  for (const std::uint32_t k : g.group_of) {
    ++g.groups[k].end;
  }
  std::size_t offset = 0;
  for (Group& group : g.groups) {
    group.begin = offset;
    offset += group.end;
    group.end = group.begin;
  }
  std::vector<PackedPoint> sorted(g.points.size());
  for (std::size_t i = 0; i < g.points.size(); ++i) {
    sorted[g.groups[g.group_of[i]].end++] = g.points[i];
  }
  return sorted;
}

/// Sorts a thing group's points by cluster in place and appends the clusters, those that are too small apart.
void splitIntoClusters(const Group& group, const RadiusLaw& law, Instances& out) {
  const std::span<PackedPoint> points = std::span(out.points).subspan(group.begin, group.end - group.begin);
  const std::vector<std::int32_t> cluster = clusterEuclidean(points, law);
  std::vector<std::size_t> end;
  for (const std::int32_t c : cluster) {
    end.resize(std::max(end.size(), static_cast<std::size_t>(c) + 1));
    ++end[static_cast<std::size_t>(c)];
  }
  std::size_t offset = 0;
  std::vector<std::size_t> cursor;
  for (const std::size_t count : end) {
    cursor.push_back(offset);
    std::vector<Instance>& list = count >= static_cast<std::size_t>(group.info->min_points) ? out.list : out.small;
    list.push_back({group.info->id, group.instance, false, {}, group.begin + offset, group.begin + offset + count});
    offset += count;
  }
  const std::vector<PackedPoint> unsorted(points.begin(), points.end());
  for (std::size_t i = 0; i < unsorted.size(); ++i) {
    points[cursor[static_cast<std::size_t>(cluster[i])]++] = unsorted[i];
  }
}

}  // namespace

RadiusLaw radiusLaw(const CreationConfig& config, double radius_min) {
  const double slope = config.beam_factor * config.beam_spacing_deg * std::numbers::pi / 180;
  return {static_cast<float>(radius_min), static_cast<float>(slope)};
}

Instances segmentInstances(const Frame& frame, const Pose& T_map_body, const ClassTable& classes,
                           const Config& config) {
  Instances out;
  Grouping grouping = groupPoints(frame, T_map_body, classes, config, out);
  out.points = sortByGroup(grouping);
  for (const Group& group : grouping.groups) {
    if (group.info->kind == ClassKind::kThing) {
      splitIntoClusters(group, radiusLaw(config.creation, group.info->cluster_radius), out);
    } else if (group.end - group.begin >= static_cast<std::size_t>(group.info->min_points)) {
      out.list.push_back({group.info->id, 0, true, group.tile, group.begin, group.end});
    }
  }
  return out;
}

}  // namespace hgg
