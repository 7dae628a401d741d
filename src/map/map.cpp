#include "map/map.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace hgg {
namespace {

constexpr double kCellSize = 10.0;         // m, of the index over node means
constexpr double kKeyframeDistance = 2.0;  // m
constexpr double kKeyframeAngle = 20.0 * M_PI / 180;

/// Columns: places spread over the ground, and a robot looks farther than a house is high.
Tile cellOf(const Vec3& mean) {
  const Eigen::Array3d c = (mean / kCellSize).array().floor().max(-1e9).min(1e9);  // so that neighbours of it exist too
  return {static_cast<std::int32_t>(c[0]), static_cast<std::int32_t>(c[1]), 0};
}

double cellsBetween(const Tile& low, const Tile& high) {
  return (high.x - low.x + 1.0) * (high.y - low.y + 1.0) * (high.z - low.z + 1.0);
}

bool isNewKeyframe(const std::vector<TimedPose>& keyframes, const Pose& T_map_body) {
  if (keyframes.empty()) {
    return true;
  }
  const Pose step = keyframes.back().T_map_body.inverse() * T_map_body;
  return step.translation().norm() >= kKeyframeDistance || Eigen::AngleAxisd(step.linear()).angle() >= kKeyframeAngle;
}

}  // namespace

std::size_t Map::CellHash::operator()(const Cell& c) const {
  const auto mix = [](std::int32_t v) { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(v)); };
  return (mix(c.x) * 73856093ULL) ^ (mix(c.y) * 19349669ULL) ^ (mix(c.z) * 83492791ULL);
}

MapDelta Map::apply(MapUpdate update) {
  MapDelta delta;
  delta.revision = ++revision_;
  for (const NodeId id : update.removed) {
    erase(id);
  }
  for (MapNode& node : update.changed) {
    delta.changed.push_back(node.id);
    erase(node.id);
    insert(std::move(node));
  }
  for (const ClassEvidence& evidence : update.evidence) {
    addViews(nodes_.at(evidence.id).classes, evidence.views);
    delta.changed.push_back(evidence.id);
  }
  for (MapNode& node : update.created) {
    node.id = next_id_++;
    delta.changed.push_back(node.id);
    insert(std::move(node));
  }
  delta.removed = std::move(update.removed);
  std::sort(delta.changed.begin(), delta.changed.end());
  std::sort(delta.removed.begin(), delta.removed.end());
  if (isNewKeyframe(keyframes_, update.pose.T_map_body)) {
    keyframes_.push_back(update.pose);
  }
  return delta;
}

const MapNode* Map::find(NodeId id) const {
  const auto it = nodes_.find(id);
  return it == nodes_.end() ? nullptr : &it->second;
}

const MapNode* Map::findTile(ClassId label, const Tile& tile) const {
  const auto it = tiles_.find({label, tile});
  return it == tiles_.end() ? nullptr : find(it->second);
}

std::vector<NodeId> Map::near(const Vec3& centre, double radius) const {
  std::vector<NodeId> ids;
  const auto take = [&](NodeId id, const MapNode& node) {
    if ((node.belief.mean - centre).squaredNorm() <= radius * radius) {
      ids.push_back(id);
    }
  };
  const Vec3 reach = Vec3::Constant(radius);
  const Tile low = cellOf(centre - reach), high = cellOf(centre + reach);
  if (cellsBetween(low, high) > static_cast<double>(nodes_.size())) {
    for (const auto& [id, node] : nodes_) {
      take(id, node);
    }
    return ids;
  }
  Cell c;
  for (c.x = low.x; c.x <= high.x; ++c.x) {
    for (c.y = low.y; c.y <= high.y; ++c.y) {
      for (c.z = low.z; c.z <= high.z; ++c.z) {
        if (const auto it = cells_.find(c); it != cells_.end()) {
          for (const NodeId id : it->second) {
            take(id, *find(id));
          }
        }
      }
    }
  }
  std::sort(ids.begin(), ids.end());
  return ids;
}

std::size_t Map::believedCount() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(nodes_, [](const auto& entry) { return isBelieved(entry.second); }));
}

double Map::megabytes() const {
  // A tree node, its index entries and its class views cost about 150 B beside the payload.
  const std::size_t bytes =
      nodes_.size() * (sizeof(MapNode) + 150) + leaf_count_ * sizeof(Leaf) + keyframes_.size() * sizeof(TimedPose);
  return static_cast<double>(bytes) / 1e6;
}

Map Map::restore(std::vector<MapNode> nodes, std::vector<TimedPose> keyframes, std::map<ClassId, std::string> names,
                 std::int64_t revision, NodeId next_id) {
  Map map;
  map.next_id_ = std::max<NodeId>(next_id, 1);
  for (MapNode& node : nodes) {
    map.next_id_ = std::max(map.next_id_, node.id + 1);
    map.insert(std::move(node));
  }
  map.keyframes_ = std::move(keyframes);
  map.class_names_ = std::move(names);
  map.revision_ = revision;
  return map;
}

void Map::insert(MapNode node) {
  cells_[cellOf(node.belief.mean)].push_back(node.id);
  if (node.stuff) {
    tiles_[{node.label, node.tile}] = node.id;
  }
  leaf_count_ += node.leaves.size();
  const NodeId id = node.id;
  if (!nodes_.emplace(id, std::move(node)).second) {
    std::abort();  // a caller inserted an id twice
  }
}

void Map::erase(NodeId id) {
  const auto it = nodes_.find(id);
  if (it == nodes_.end()) {
    std::abort();  // a caller changed or removed a node the map does not have
  }
  const MapNode& node = it->second;
  const auto cell = cells_.find(cellOf(node.belief.mean));
  std::erase(cell->second, id);
  if (cell->second.empty()) {
    cells_.erase(cell);
  }
  if (node.stuff) {
    tiles_.erase({node.label, node.tile});
  }
  leaf_count_ -= node.leaves.size();
  nodes_.erase(it);
}

}  // namespace hgg
