#include "alignment/correspondence.h"

#include <algorithm>
#include <cmath>

#include "alignment/assignment.h"
#include "alignment/pair_cost.h"
#include "alignment/structure.h"
#include "core/neighborhood.h"

namespace hgg {
namespace {

/// A thing of the map that one of the frame's may be, as its neighbours see it.
struct KnownThing {
  const MapNode* node = nullptr;
  NeighborHistogram histogram;
};

/// Means farther apart than this (m) are no pair. A cost in metres is never below the distance of the means, so with a
/// share of it in the cost this prunes nothing that could pass the gate.
double largestPairDistance(const AlignmentConfig& config) {
  return config.geometry_share > 0 ? config.gate / config.geometry_share : config.gate;
}

std::vector<Vec3> thingMeans(const LocalGraph& local, const Pose& T_map_body) {
  std::vector<Vec3> means;
  for (const LocalObject& object : local.objects) {
    if (!object.stuff) {
      means.push_back(T_map_body * object.belief.mean);
    }
  }
  return means;
}

/// The classes around a node in the map's object graph, or, of a node that is not confirmed, around its place.
NeighborHistogram histogramIn(const ObjectGraph& graph, const MapNode& node) {
  std::vector<ClassId> labels;
  const auto add = [&](const ObjectGraph::Neighbor& neighbor) { labels.push_back(neighbor.label); };
  if (graph.holds(node.id)) {
    std::ranges::for_each(graph.neighborsOf(node.id), add);
  } else {
    std::ranges::for_each(graph.neighborsAt(node.belief.mean), add);
  }
  return histogramOf(labels);
}

/// Active things of the map near one of the frame's, ascending by id.
std::vector<KnownThing> knownThings(const LocalGraph& local, const Map& map, const Pose& T_map_body,
                                    const Config& config) {
  std::vector<KnownThing> known;
  const std::vector<Vec3> seen = thingMeans(local, T_map_body);
  const double square_gate = std::pow(largestPairDistance(config.alignment), 2);
  for (const NodeId id : map.near(T_map_body.translation(), config.map.active_radius)) {
    const MapNode* node = map.find(id);
    const auto isNear = [&](const Vec3& p) { return (p - node->belief.mean).squaredNorm() <= square_gate; };
    if (!node->stuff && std::ranges::any_of(seen, isNear)) {
      known.push_back({node, histogramIn(map.graph(), *node)});
    }
  }
  return known;
}

std::vector<NeighborHistogram> localHistograms(const LocalGraph& local) {
  std::vector<ClassId> labels;
  for (const LocalObject& object : local.objects) {
    labels.push_back(object.label);
  }
  return neighborHistograms(labels, local.edges);
}

std::vector<Candidate> thingCandidates(const LocalGraph& local, const std::vector<KnownThing>& known,
                                       const Pose& T_map_body, const Config& all) {
  const AlignmentConfig& config = all.alignment;
  const std::vector<NeighborHistogram> histograms = localHistograms(local);
  const double farthest = largestPairDistance(config);
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < local.objects.size(); ++i) {
    const LocalObject& object = local.objects[i];
    if (object.stuff) {
      continue;
    }
    const Belief seen = transform(T_map_body, object.belief);
    for (std::size_t j = 0; j < known.size(); ++j) {
      const MapNode& node = *known[j].node;
      if (node.label != object.label || (node.belief.mean - seen.mean).squaredNorm() > farthest * farthest) {
        continue;
      }
      const double apart = pairCost(seen, node.belief, all.ablation.cost, all.creation.sigma_floor, farthest);
      const double cost = config.geometry_share * apart +
                          (1 - config.geometry_share) * histogramDistance(histograms[i], known[j].histogram);
      candidates.push_back({static_cast<int>(i), static_cast<int>(j), cost});
    }
  }
  return candidates;
}

/// A leaf is matched to one of this many nearest leaves, so that the assignment has a choice where two want the same
/// one. Chosen by hand, not measured.
constexpr std::size_t kNearestLeaves = 4;

/// Candidates (row of the frame's leaf, column of the node's): the nearest within the gate of `mean_node`.
void addLeafCandidates(const std::vector<Leaf>& leaves, const Eigen::Vector3f& mean_node, float gate, int row,
                       int first_column, std::vector<Candidate>& candidates) {
  const auto first = static_cast<std::ptrdiff_t>(candidates.size());
  const auto isNearer = [](const Candidate& a, const Candidate& b) { return a.cost < b.cost; };
  double farthest = static_cast<double>(gate * gate);
  for (std::size_t v = 0; v < leaves.size(); ++v) {
    const std::array<float, 3>& mean = leaves[v].mean;
    const float dx = mean[0] - mean_node.x(), dy = mean[1] - mean_node.y(), dz = mean[2] - mean_node.z();
    const auto square = static_cast<double>(dx * dx + dy * dy + dz * dz);
    if (square >= farthest) {
      continue;
    }
    candidates.push_back({row, first_column + static_cast<int>(v), square});
    if (candidates.size() - static_cast<std::size_t>(first) > kNearestLeaves) {
      std::iter_swap(std::max_element(candidates.begin() + first, candidates.end(), isNearer), candidates.end() - 1);
      candidates.pop_back();
      farthest = std::max_element(candidates.begin() + first, candidates.end(), isNearer)->cost;
    }
  }
}

/// Rounds h of the Weisfeiler-Lehman features. Chosen by hand: docs/experiments.md, "Weisfeiler-Lehman features in the
/// cost of leaves", finds that the features change nothing.
constexpr int kStructureRounds = 2;

Eigen::MatrixXd featuresOf(const MapNode& node, double sigma_floor) {
  std::vector<Belief> leaves;
  for (const Leaf& leaf : leavesOf(node)) {
    leaves.push_back(unpackLeaf(leaf));
  }
  return wlFeatures(leaves, geometryEdges(leaves), kStructureRounds, sigma_floor);
}

/// The structural part of the leaves' cost: D_WL as the mean squared difference D of the features, worth
/// gate^2 D / (1 + D) so that it can be weighed against a squared distance below the gate.
class StructureCost {
 public:
  StructureCost(const LocalObject& object, const MapNode& node, const AlignmentConfig& config, double sigma_floor)
      : square_gate_(config.leaf_gate * config.leaf_gate), share_(config.leaf_geometry_share) {
    if (share_ < 1) {
      local_ = wlFeatures(object.leaves, geometryEdges(object.leaves), kStructureRounds, sigma_floor);
      map_ = featuresOf(node, sigma_floor);
    }
  }

  /// alpha_r |du|^2 + (1 - alpha_r) D_WL.
  double operator()(std::size_t local, int map, double square) const {
    if (share_ >= 1) {
      return square;
    }
    const auto row = static_cast<Eigen::Index>(local);
    const double d = (local_.row(row) - map_.row(map)).squaredNorm() / static_cast<double>(map_.cols());
    return share_ * square + (1 - share_) * square_gate_ * d / (1 + d);
  }

 private:
  double square_gate_, share_;
  Eigen::MatrixXd local_, map_;
};

}  // namespace

std::size_t leafStride(const LocalGraph& local, const std::vector<ObjectPair>& pairs, int at_most) {
  std::size_t leaves = 0;
  for (const ObjectPair& pair : pairs) {
    leaves += local.objects[static_cast<std::size_t>(pair.local)].leaves.size();
  }
  const auto most = static_cast<std::size_t>(at_most);
  return std::max<std::size_t>(1, (leaves + most - 1) / most);
}

std::vector<LeafPair> fineCorrespondence(const LocalGraph& local, const Map& map, const std::vector<ObjectPair>& pairs,
                                         const Pose& T_map_body, const AlignmentConfig& config, double sigma_floor) {
  const auto gate = static_cast<float>(config.leaf_gate);
  const std::size_t stride = leafStride(local, pairs, config.max_leaf_pairs);
  std::vector<LeafPair> rows;      // leaves of the frame that take part
  std::vector<int> first_columns;  // of a pair's node: a column stands for one leaf
  std::vector<Candidate> candidates;
  std::size_t leaf = 0;
  int columns = 0;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const LocalObject& object = local.objects[static_cast<std::size_t>(pairs[p].local)];
    const MapNode& node = *map.find(pairs[p].map);
    const Pose T_node_object = node.T_map_object.inverse() * T_map_body * object.T_body_object;
    const StructureCost costOf(object, node, config, sigma_floor);
    for (std::size_t u = 0; u < object.leaves.size(); ++u, ++leaf) {
      if (leaf % stride == 0) {
        const std::size_t first = candidates.size();
        addLeafCandidates(leavesOf(node), (T_node_object * object.leaves[u].mean).cast<float>(), gate,
                          static_cast<int>(rows.size()), columns, candidates);
        rows.push_back({static_cast<int>(p), static_cast<int>(u), 0});
        for (std::size_t k = first; k < candidates.size(); ++k) {
          candidates[k].cost = costOf(u, candidates[k].column - columns, candidates[k].cost);
        }
      }
    }
    first_columns.push_back(columns);
    columns += static_cast<int>(leavesOf(node).size());
  }
  std::vector<LeafPair> found;
  for (const Candidate& c : assignSparse(candidates, static_cast<double>(gate * gate))) {
    LeafPair pair = rows[static_cast<std::size_t>(c.row)];
    pair.map = c.column - first_columns[static_cast<std::size_t>(pair.pair)];
    found.push_back(pair);
  }
  return found;
}

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
  const std::vector<KnownThing> known = knownThings(local, map, T_map_body, config);
  for (const Candidate& c : assignSparse(thingCandidates(local, known, T_map_body, config), config.alignment.gate)) {
    pairs.push_back({c.row, known[static_cast<std::size_t>(c.column)].node->id, c.cost});
  }
  std::sort(pairs.begin(), pairs.end(), [](const ObjectPair& a, const ObjectPair& b) { return a.local < b.local; });
  return pairs;
}

}  // namespace hgg
