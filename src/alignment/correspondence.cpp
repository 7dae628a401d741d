#include "alignment/correspondence.h"

#include <algorithm>

#include "alignment/assignment.h"
#include "alignment/structure.h"
#include "creation/object_graph.h"

namespace hgg {
namespace {

/// The map around the robot, as a graph that can be compared with a frame's.
struct ActiveGraph {
  std::vector<const MapNode*> nodes;  // ascending by id
  std::vector<NeighborHistogram> histograms;
};

ActiveGraph activeGraph(const Map& map, const Vec3& centre, const Config& config) {
  ActiveGraph active;
  std::vector<GraphNode> nodes;
  std::vector<ClassId> labels;
  for (const NodeId id : map.near(centre, config.map.active_radius)) {
    const MapNode* node = map.find(id);
    active.nodes.push_back(node);
    nodes.push_back({node->label, &node->belief});
    labels.push_back(node->label);
  }
  active.histograms = neighborHistograms(labels, connectObjects(nodes, config.creation));
  return active;
}

std::vector<NeighborHistogram> localHistograms(const LocalGraph& local) {
  std::vector<ClassId> labels;
  for (const LocalObject& object : local.objects) {
    labels.push_back(object.label);
  }
  return neighborHistograms(labels, local.edges);
}

std::vector<Candidate> thingCandidates(const LocalGraph& local, const ActiveGraph& active, const Pose& T_map_body,
                                       const AlignmentConfig& config) {
  const std::vector<NeighborHistogram> histograms = localHistograms(local);
  // The Wasserstein distance is never below the distance of the means, so with a share of it in the cost this prunes
  // nothing that could pass the gate.
  const double reach = config.geometry_share > 0 ? config.gate / config.geometry_share : config.gate;
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < local.objects.size(); ++i) {
    const LocalObject& object = local.objects[i];
    if (object.stuff) {
      continue;
    }
    const Belief seen = transform(T_map_body, object.belief);
    for (std::size_t j = 0; j < active.nodes.size(); ++j) {
      const MapNode& node = *active.nodes[j];
      if (node.stuff || node.label != object.label || (node.belief.mean - seen.mean).squaredNorm() > reach * reach) {
        continue;
      }
      const double cost = config.geometry_share * wasserstein2(seen, node.belief) +
                          (1 - config.geometry_share) * histogramDistance(histograms[i], active.histograms[j]);
      candidates.push_back({static_cast<int>(i), static_cast<int>(j), cost});
    }
  }
  return candidates;
}

}  // namespace

std::vector<ObjectPair> coarseCorrespondence(const LocalGraph& local, const Map& map, const Pose& T_map_body,
                                             const Config& config) {
  std::vector<ObjectPair> pairs;
  for (std::size_t i = 0; i < local.objects.size(); ++i) {
    const LocalObject& object = local.objects[i];
    const MapNode* node = object.stuff ? map.findTile(object.label, object.tile) : nullptr;
    if (node != nullptr) {
      pairs.push_back({static_cast<int>(i), node->id, 0});
    }
  }
  const ActiveGraph active = activeGraph(map, T_map_body.translation(), config);
  for (const Candidate& c :
       assignSparse(thingCandidates(local, active, T_map_body, config.alignment), config.alignment.gate)) {
    pairs.push_back({c.row, active.nodes[static_cast<std::size_t>(c.column)]->id, c.cost});
  }
  std::sort(pairs.begin(), pairs.end(), [](const ObjectPair& a, const ObjectPair& b) { return a.local < b.local; });
  return pairs;
}

}  // namespace hgg
