#include "region/regions.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <span>

#include "core/neighborhood.h"
#include "region/floor_plan.h"
#include "region/groups.h"
#include "region/region_name.h"

namespace hgg {
namespace {

/// Offsets of the cells within a reach, the nearest first.
std::vector<std::pair<int, int>> cellsWithin(int reach) {
  std::vector<std::pair<int, int>> offsets;
  for (int y = -reach; y <= reach; ++y) {
    for (int x = -reach; x <= reach; ++x) {
      offsets.emplace_back(x, y);
    }
  }
  std::ranges::stable_sort(offsets, {}, [](const auto& o) { return o.first * o.first + o.second * o.second; });
  return offsets;
}

/// Finds the space that a place is in: that of the nearest ground below it which is in one.
class SpaceFinder {
 public:
  explicit SpaceFinder(const FloorPlan& plan)
      : plan_(plan), offsets_(cellsWithin(static_cast<int>(kReach / plan.shape.resolution))) {}

  /// -1 where there is none.
  std::int32_t at(const Vec3& p) const {
    const std::int32_t column = plan_.shape.columnOf(p.x()), row = plan_.shape.rowOf(p.y());
    for (const auto& [x, y] : offsets_) {
      std::int32_t space = -1;
      for (const PlanCell& cell : plan_.at(column + x, row + y)) {  // the highest that is below
        const double above = p.z() - static_cast<double>(cell.height);
        const bool is_it = cell.space >= 0 && isPlace(plan_, cell.space) && above > -kBelow && above < kAbove;
        space = is_it ? cell.space : space;
      }
      if (space >= 0) {
        return space;
      }
    }
    return -1;
  }

 private:
  static constexpr double kReach = 1.5;              // m
  static constexpr double kBelow = 0.5, kAbove = 4;  // m: a thing is no lower than its ground, and in its storey

  const FloorPlan& plan_;
  std::vector<std::pair<int, int>> offsets_;
};

/// The space that most of a thing's points are in; -1 where no ground is near. What hangs in a wall is on the side it
/// was first seen from.
std::int32_t spaceOf(const MapLeaves& map, const MapNode& node, const SpaceFinder& finder) {
  constexpr double kTowardsEye = 0.2;  // m: out of a wall
  std::map<std::int32_t, double> points;
  for (const Leaf& leaf : leavesOf(node)) {
    const Belief b = transform(node.T_map_object, unpackLeaf(leaf));
    Vec3 to_eye = Vec3::Zero();
    if (node.anchor >= 0 && static_cast<std::size_t>(node.anchor) < map.keyframes.size()) {
      to_eye = map.keyframes[static_cast<std::size_t>(node.anchor)].T_map_body.translation() - b.mean;
      to_eye.z() = 0;
    }
    const double distance = to_eye.norm();
    points[finder.at(b.mean + (distance > kTowardsEye ? kTowardsEye / distance : 0) * to_eye)] += b.kappa;
  }
  points.erase(-1);
  const auto most = std::ranges::max_element(points, {}, [](const auto& entry) { return entry.second; });
  return most == points.end() ? -1 : most->first;
}

/// How much of each class's things a region holds.
using Shares = std::map<ClassId, double>;

Shares sharesOf(const MapLeaves& map, const Region& region) {
  Shares shares;
  for (const NodeId id : region.objects) {
    shares[map.nodes.at(id).label] += 1.0 / static_cast<double>(region.objects.size());
  }
  return shares;
}

/// S2 of eq. rel_weights for nodes of many classes: 0 for equal shares, 1 for none in common.
double disagreement(const Shares& a, const Shares& b) {
  double common = 0;
  for (const auto& [label, share] : a) {
    const auto it = b.find(label);
    common += it == b.end() ? 0 : std::min(share, it->second);
  }
  return 1 - common;
}

std::vector<Edge> edgesOf(const MapLeaves& map, const std::vector<Region>& regions, const EdgeModel& model) {
  std::vector<Vec3> means;
  std::vector<Shares> shares;
  for (const Region& region : regions) {
    means.push_back(region.belief.mean);
    shares.push_back(sharesOf(map, region));
  }
  const auto pairs = relativeNeighborhood(means);
  std::vector<double> s1;
  for (const auto& [i, j] : pairs) {
    s1.push_back(edgeDistance(regions[static_cast<std::size_t>(i)].belief, regions[static_cast<std::size_t>(j)].belief,
                              model.sigma_floor));
  }
  const double largest = s1.empty() ? 1 : std::max(*std::ranges::max_element(s1), 1e-12);
  std::vector<Edge> edges;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto i = static_cast<std::size_t>(pairs[k].first), j = static_cast<std::size_t>(pairs[k].second);
    const double c = model.geometry_share;
    edges.push_back({regions[i].id, regions[j].id,
                     static_cast<float>(c * s1[k] / largest + (1 - c) * disagreement(shares[i], shares[j]))});
  }
  return edges;
}

Region regionOf(const MapLeaves& map, const ClassNames& names, std::vector<NodeId> objects) {
  Region region;
  std::ranges::sort(objects);
  region.id = objects.front();
  for (const NodeId id : objects) {
    region.belief = merge(region.belief, map.nodes.at(id).belief);
  }
  region.objects = std::move(objects);
  region.name = regionName(map, names, region);
  return region;
}

/// A thing without ground of its own, as where no floor was seen below it, with the nearest thing of a room that no
/// wall hides from it.
std::optional<std::int32_t> spaceInSight(const Vec3& mean, const FloorPlan& plan,
                                         std::span<const std::pair<Vec3, std::int32_t>> placed) {
  constexpr double kReach = 5;  // m: across a room
  std::optional<std::int32_t> space;
  double nearest = kReach;
  for (const auto& [other, of] : placed) {
    const double distance = (other - mean).norm();
    if (distance < nearest && !isWallBetween(plan, mean, other)) {
      nearest = distance;
      space = of;
    }
  }
  return space;
}

using Groups = std::vector<std::vector<NodeId>>;

/// Things under one roof are one group; things in the open are grouped by how they stand.
Groups groupsOf(const MapLeaves& map, const FloorPlan& plan) {
  const SpaceFinder finder(plan);
  std::map<std::int32_t, std::vector<NodeId>> rooms;
  std::vector<std::pair<Vec3, std::int32_t>> placed;
  std::vector<NodeId> others;
  for (const auto& [id, node] : map.nodes) {
    if (node.stuff || !isConfirmed(node)) {
      continue;
    }
    const std::int32_t space = spaceOf(map, node, finder);
    if (space >= 0 && isRoom(plan, space)) {
      rooms[space].push_back(id);
      placed.emplace_back(node.belief.mean, space);
    } else {
      others.push_back(id);
    }
  }
  std::vector<NodeId> open;
  std::vector<Belief> beliefs;
  for (const NodeId id : others) {
    const Belief& belief = map.nodes.at(id).belief;
    if (const auto space = spaceInSight(belief.mean, plan, placed)) {
      rooms[*space].push_back(id);
    } else {
      open.push_back(id);
      beliefs.push_back(belief);
    }
  }
  Groups groups;
  for (auto& [space, ids] : rooms) {
    groups.push_back(std::move(ids));
  }
  for (const std::vector<int>& members : groupInTheOpen(beliefs)) {
    groups.emplace_back();
    for (const int k : members) {
      groups.back().push_back(open[static_cast<std::size_t>(k)]);
    }
  }
  return groups;
}

}  // namespace

Regions findRegions(const MapLeaves& map, const ClassNames& names, const EdgeModel& model) {
  FloorPlan plan = buildFloorPlan(map);
  cutIntoSpaces(plan);
  Regions found;
  for (std::vector<NodeId>& objects : groupsOf(map, plan)) {
    found.regions.push_back(regionOf(map, names, std::move(objects)));
  }
  std::ranges::sort(found.regions, {}, &Region::id);
  found.edges = edgesOf(map, found.regions, model);
  return found;
}

Regions findRegions(const Map& map, const EdgeModel& model) { return findRegions(map, map.classNames(), model); }

}  // namespace hgg
