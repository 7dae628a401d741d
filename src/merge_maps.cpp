#include "merge_maps.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>

#include "core/se3.h"
#include "correction/loop_closure.h"
#include "correction/pose_graph.h"
#include "map/fuse.h"
#include "place/consistency.h"

namespace hgg {
namespace {

/// Places of a pair of maps that are looked at in detail, at most.
constexpr std::size_t kMostPlaces = 12;
/// Nodes that are merged in one go; any number would do.
constexpr std::size_t kMergedAtOnce = 500;

const TimedPose& keyframeOf(const Map& map, KeyframeId id) {
  return map.keyframes().poses()[static_cast<std::size_t>(id)];
}

Vec3 centreOf(const Map& map) {
  Vec3 sum = Vec3::Zero();
  for (const auto& [id, node] : map.nodes()) {
    sum += node.belief.mean;
  }
  return map.nodes().empty() ? sum : Vec3(sum / static_cast<double>(map.nodes().size()));
}

std::vector<MapPair> comparePairs(const std::vector<Map>& maps, std::span<const SimilarClasses> similar) {
  std::vector<MapPair> pairs;
  for (std::size_t a = 0; a < maps.size(); ++a) {
    for (std::size_t b = a + 1; b < maps.size(); ++b) {
      pairs.push_back({a, b, alignMaps(maps[a], maps[b], similar)});
    }
  }
  return pairs;
}

/// Lays the maps out along the surest recognitions, best first; maps that none reaches stay nullopt.
std::vector<std::optional<Pose>> layOut(std::size_t count, std::vector<const MapPair*> accepted) {
  std::ranges::stable_sort(accepted, std::greater<>(), [](const MapPair* p) { return p->found.score; });
  std::vector<std::optional<Pose>> T_first_map(count);
  T_first_map[0] = Pose::Identity();
  for (bool grows = true; grows;) {
    const auto next = std::ranges::find_if(
        accepted, [&](const MapPair* p) { return T_first_map[p->a].has_value() != T_first_map[p->b].has_value(); });
    grows = next != accepted.end();
    if (grows) {
      const auto& [a, b, found] = **next;
      (T_first_map[a] ? T_first_map[b] : T_first_map[a]) =
          orthonormalized(T_first_map[a] ? *T_first_map[a] * found.T_a_b : *T_first_map[b] * found.T_a_b.inverse());
    }
  }
  return T_first_map;
}

/// What speaks against a layout; empty: nothing.
std::string objection(const std::vector<Map>& maps, const std::vector<const MapPair*>& accepted,
                      const std::vector<std::optional<Pose>>& T_first_map) {
  for (std::size_t k = 0; k < maps.size(); ++k) {
    if (!T_first_map[k]) {
      return fmt::format("map {} is recognised in none of the maps that hang together with the first", k + 1);
    }
  }
  for (const MapPair* p : accepted) {
    const Pose T_a_b = T_first_map[p->a]->inverse() * *T_first_map[p->b];
    if (areDistinct(p->found.T_a_b, T_a_b, centreOf(maps[p->b]))) {
      return fmt::format("maps {} and {} were recognised elsewhere than the other maps say", p->a + 1, p->b + 1);
    }
  }
  return {};
}

/// A map of its own of what lies around a place.
Map partAround(const Map& map, const Vec3& centre, double radius) {
  std::vector<MapNode> nodes;
  for (const NodeId id : map.nearAnywhere(centre, radius)) {
    nodes.push_back(*map.find(id));
    nodes.back().anchor = -1;
  }
  return Map::restore(std::move(nodes), {}, map.classNames(), 0);
}

/// Constraints between keyframes of two maps, numbered each in its map, where both have been in the same place.
std::vector<BetweenConstraint> constraintsOf(const Map& a, const Map& b, const Pose& T_a_b,
                                             std::span<const SimilarClasses> similar, const LoopConfig& config) {
  std::vector<BetweenConstraint> constraints;
  std::vector<Vec3> looked_at;
  for (KeyframeId kb = 0; kb <= b.keyframes().last() && looked_at.size() < kMostPlaces; ++kb) {
    const Vec3 p_b = keyframeOf(b, kb).T_map_body.translation(), p_a = T_a_b * p_b;
    const auto isNear = [&](const Vec3& p) { return (p - p_b).norm() < config.place_radius; };
    const KeyframeId ka = a.keyframes().newestAt(p_a);
    if (std::ranges::any_of(looked_at, isNear) ||
        (keyframeOf(a, ka).T_map_body.translation() - p_a).norm() > config.pass_distance) {
      continue;
    }
    looked_at.push_back(p_b);
    const PlacePrior prior{T_a_b, p_b, config.place_radius / 4, config.prior_turn_slack};
    const ZeroShot found =
        alignMaps(partAround(a, p_a, config.place_radius), partAround(b, p_b, config.place_radius), similar, prior);
    if (found.accepted) {
      const Pose T_ka_kb = keyframeOf(a, ka).T_map_body.inverse() * found.T_a_b * keyframeOf(b, kb).T_map_body;
      constraints.push_back({ka, kb, T_ka_kb, config.sigma, config.sigma_turn, true});
    }
  }
  return constraints;
}

/// The same of two maps as wholes: between the keyframes that are nearest to each other.
BetweenConstraint constraintOfWhole(const Map& a, const Map& b, const Pose& T_a_b, const LoopConfig& config) {
  BetweenConstraint best{0, 0, Pose::Identity(), config.sigma, config.sigma_turn, true};
  double nearest = std::numeric_limits<double>::infinity();
  for (KeyframeId kb = 0; kb <= b.keyframes().last(); ++kb) {
    const Vec3 p_a = T_a_b * keyframeOf(b, kb).T_map_body.translation();
    const KeyframeId ka = a.keyframes().newestAt(p_a);
    const double distance = (keyframeOf(a, ka).T_map_body.translation() - p_a).norm();
    if (distance < nearest) {
      nearest = distance;
      best.a = ka, best.b = kb;
    }
  }
  best.T_a_b = keyframeOf(a, best.a).T_map_body.inverse() * T_a_b * keyframeOf(b, best.b).T_map_body;
  return best;
}

/// Classes of later maps are those of earlier ones with the same name.
class ClassNames {
 public:
  /// The ids that a map's classes get.
  std::map<ClassId, ClassId> add(const std::map<ClassId, std::string>& names) {
    std::map<ClassId, ClassId> renamed;
    for (const auto& [id, name] : names) {
      const auto known = std::ranges::find_if(names_, [&, &n = name](const auto& entry) { return entry.second == n; });
      ClassId own = known != names_.end() ? known->first : id;
      while (known == names_.end() && names_.contains(own)) {
        ++own;
      }
      names_[own] = name;
      renamed[id] = own;
    }
    return renamed;
  }
  const std::map<ClassId, std::string>& names() const { return names_; }

 private:
  std::map<ClassId, std::string> names_;
};

void rename(const std::map<ClassId, ClassId>& renamed, MapNode& node) {
  const auto own = [&](ClassId id) {
    const auto entry = renamed.find(id);
    return entry == renamed.end() ? id : entry->second;
  };
  node.label = own(node.label);
  for (auto& [label, views] : node.classes.views) {
    label = own(label);
  }
  std::ranges::sort(node.classes.views);
  // Two ids of one name are one class from now on.
  auto& views = node.classes.views;
  std::size_t kept = 0;
  for (std::size_t k = 1; k < views.size(); ++k) {
    if (views[k].first == views[kept].first) {
      views[kept].second += views[k].second;
    } else {
      views[++kept] = views[k];
    }
  }
  views.resize(views.empty() ? 0 : kept + 1);
}

/// The keyframes of all maps, one map after the other, laid out and tied to each other.
struct AllKeyframes {
  KeyframeGraph graph;
  std::vector<KeyframeId> first;  // of each map
  std::vector<Pose> poses;        // as they come to lie
  std::size_t places = 0;
};

AllKeyframes tieTogether(const std::vector<Map>& maps, const MergedMaps& merged,
                         const std::vector<const MapPair*>& accepted, std::span<const SimilarClasses> similar,
                         const LoopConfig& config) {
  AllKeyframes all;
  for (std::size_t k = 0; k < maps.size(); ++k) {
    const KeyframeId offset = all.graph.last() + 1;
    all.first.push_back(offset);
    for (const TimedPose& pose : maps[k].keyframes().poses()) {
      all.graph.add({pose.utime_us, orthonormalized(merged.T_first_map[k] * pose.T_map_body)});
    }
    for (BetweenConstraint e : maps[k].keyframes().edges()) {
      e.a += offset, e.b += offset;
      all.graph.connect(e);
    }
  }
  for (const MapPair* p : accepted) {
    const Map &a = maps[p->a], &b = maps[p->b];
    if (a.keyframes().last() < 0 || b.keyframes().last() < 0) {
      continue;
    }
    const Pose T_a_b = merged.T_first_map[p->a].inverse() * merged.T_first_map[p->b];
    std::vector<BetweenConstraint> found = constraintsOf(a, b, T_a_b, similar, config);
    all.places += found.size();
    if (found.empty()) {
      found.push_back(constraintOfWhole(a, b, p->found.T_a_b, config));
    }
    for (BetweenConstraint e : found) {
      e.a += all.first[p->a], e.b += all.first[p->b];
      all.graph.connect(e);
    }
  }
  for (const TimedPose& pose : all.graph.poses()) {
    all.poses.push_back(pose.T_map_body);
  }
  if (!all.poses.empty()) {
    all.poses = solvePoseGraph(all.poses, all.graph.edges()).poses;
  }
  return all;
}

/// All nodes in one map, each moved with its keyframe; those that are one object still are several.
Map layTogether(const std::vector<Map>& maps, const std::vector<Pose>& T_first_map, AllKeyframes all) {
  ClassNames names;
  std::vector<MapNode> nodes;
  NodeId offset = 0;
  std::int64_t revision = 0;
  for (std::size_t m = 0; m < maps.size(); ++m) {
    const std::map<ClassId, ClassId> renamed = names.add(maps[m].classNames());
    for (const auto& [id, node] : maps[m].nodes()) {
      MapNode& own = nodes.emplace_back(node);
      rename(renamed, own);
      own.id += offset;
      Pose move = T_first_map[m];
      if (node.anchor >= 0) {
        own.anchor += all.first[m];
        move = orthonormalized(all.poses[static_cast<std::size_t>(own.anchor)] *
                               keyframeOf(maps[m], node.anchor).T_map_body.inverse());
      }
      if (move.matrix() != Pose::Identity().matrix()) {
        moveBy(move, maps[0].tileSize(), own);
      }
    }
    offset = std::max(offset + maps[m].nextId() - 1, nodes.empty() ? 0 : nodes.back().id);
    revision += maps[m].revision();
  }
  for (KeyframeId k = 0; k <= all.graph.last(); ++k) {
    all.graph.move(k, all.poses[static_cast<std::size_t>(k)]);
  }
  Map map = Map::restore(std::move(nodes), std::move(all.graph), names.names(), revision, offset + 1);
  map.setTileSize(maps[0].tileSize());
  return map;
}

/// Merges what is one object; the number of nodes that went.
std::size_t mergeNodes(Map& map, const ClassTable& classes, const Config& config) {
  const std::size_t before = map.nodes().size();
  std::vector<NodeId> all;
  for (const auto& [id, node] : map.nodes()) {
    all.push_back(id);
  }
  for (std::size_t k = 0; k < all.size(); k += kMergedAtOnce) {
    const auto first = all.begin() + static_cast<std::ptrdiff_t>(k);
    const auto last = all.begin() + static_cast<std::ptrdiff_t>(std::min(k + kMergedAtOnce, all.size()));
    map.apply(mergeDuplicates(map, {first, last}, classes, config));
  }
  return before - map.nodes().size();
}

}  // namespace

MergedMaps mergeMaps(const std::vector<Map>& maps, const ClassTable& classes, const Config& config) {
  MergedMaps merged;
  const std::vector<SimilarClasses>& similar = classes.similar();
  merged.pairs = comparePairs(maps, similar);
  std::vector<const MapPair*> accepted;
  for (const MapPair& pair : merged.pairs) {
    if (pair.found.accepted) {
      accepted.push_back(&pair);
    }
  }
  const std::vector<std::optional<Pose>> layout = layOut(maps.size(), accepted);
  merged.reason = objection(maps, accepted, layout);
  if (!merged.reason.empty()) {
    return merged;
  }
  for (const std::optional<Pose>& T_first_map : layout) {
    merged.T_first_map.push_back(*T_first_map);
  }
  AllKeyframes all = tieTogether(maps, merged, accepted, similar,
                                 loopConfigOf(maps[0].tileSize(), config.map.leaf_size, config.alignment.gate));
  merged.places = all.places;
  merged.map = layTogether(maps, merged.T_first_map, std::move(all));
  merged.joined = mergeNodes(merged.map, classes, config);
  merged.map.setEdgeModel({config.creation.sigma_floor, config.creation.edge_geometry_share});
  merged.accepted = true;
  merged.reason = fmt::format("{} maps, {} of {} pairs recognised", maps.size(), accepted.size(), merged.pairs.size());
  return merged;
}

}  // namespace hgg
