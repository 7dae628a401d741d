#include "alignment/comparison.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "alignment/align.h"
#include "core/spd.h"

namespace hgg {
namespace {

constexpr double kPartialView = 0.3;  // a thing's mean moves with the view by this share of its extent
constexpr double kThingNoise = 0.08;  // m, of a thing's mean, however small it is
constexpr double kReach = 5;          // grains: leaves of a surface lie about two apart
constexpr double kLevel = 0.8;        // cosine
constexpr double kFlat = 0.1;         // ratio of variances

Landmark landmarkOf(const MapNode& node, ClassId label) {
  const Mat3& cov = node.belief.cov;
  const double middle = 0.5 * (cov(0, 0) + cov(1, 1));
  const double spread = std::hypot(0.5 * (cov(0, 0) - cov(1, 1)), cov(0, 1));
  Landmark l;
  l.mean = node.belief.mean;
  l.size = Vec3(std::sqrt(std::max(middle - spread, 0.0)), std::sqrt(middle + spread), std::sqrt(cov(2, 2)));
  l.sigma = std::hypot(kThingNoise, kPartialView * std::sqrt(middle));
  l.label = label;
  return l;
}

Surface surfaceOf(const Belief& leaf, ClassId label) {
  const Eigen3 e = eigenSymmetric(leaf.cov);
  Surface s;
  s.mean = leaf.mean;
  s.cov = loosened(leaf.cov);
  s.normal = e.vectors.col(0);
  s.is_level = std::abs(s.normal.z()) > kLevel && e.values[0] < kFlat * e.values[1];
  s.label = label;
  return s;
}

double medianOf(std::vector<double> values) {
  if (values.empty()) {
    return 0;
  }
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The label in map a of every label in map b; itself where it is not in here.
using Relabelling = std::map<ClassId, ClassId>;

/// Names that a does not have get labels that neither map uses.
Relabelling relabel(const std::map<ClassId, std::string>& names_a, const std::map<ClassId, std::string>& names_b) {
  Relabelling relabelling;
  if (names_a.empty() || names_b.empty()) {
    return relabelling;
  }
  std::map<std::string, ClassId> by_name;
  for (const auto& [id, name] : names_a) {
    by_name.emplace(name, id);
  }
  ClassId spare = 65535;
  for (const auto& [id, name] : names_b) {
    if (const auto same = by_name.find(name); same != by_name.end()) {
      relabelling[id] = same->second;
      continue;
    }
    while (names_a.contains(spare) || names_b.contains(spare)) {
      --spare;
    }
    relabelling[id] = spare--;
  }
  return relabelling;
}

MapView viewOf(const Map& map, const Relabelling& relabelling) {
  MapView view;
  std::vector<double> sizes;
  for (const auto& [id, node] : map.nodes()) {
    const auto other = relabelling.find(node.label);
    const ClassId label = other == relabelling.end() ? node.label : other->second;
    if (!node.stuff) {
      view.things.push_back(view.nodes.size());
      view.landmarks.push_back(landmarkOf(node, label));
      view.trust.push_back(existence(node.classes, node.label, node.belief.kappa));
    }
    view.nodes.push_back(&node);
    const std::size_t first = view.surfaces.size();
    for (const Leaf& leaf : node.leaves) {
      const Belief belief = transform(node.T_map_object, unpackLeaf(leaf));
      sizes.push_back(std::sqrt(belief.cov.trace()));
      view.surfaces.push_back(surfaceOf(belief, label));
    }
    view.surfaces_of.emplace_back(first, view.surfaces.size());
  }
  view.grain = medianOf(std::move(sizes));
  return view;
}

/// Both ways round, in labels of map a.
std::map<std::pair<ClassId, ClassId>, double> similarities(const std::map<ClassId, std::string>& names_a,
                                                           const std::map<ClassId, std::string>& names_b,
                                                           const Relabelling& relabelling,
                                                           std::span<const SimilarClasses> similar) {
  std::map<std::pair<ClassId, ClassId>, double> table;
  for (const auto& [id_a, name_a] : names_a) {
    for (const auto& [id_b, name_b] : names_b) {
      for (const SimilarClasses& s : similar) {
        const bool is_this = (s.a == name_a && s.b == name_b) || (s.a == name_b && s.b == name_a);
        const auto other = relabelling.find(id_b);
        if (is_this) {
          table[{id_a, other == relabelling.end() ? id_b : other->second}] = s.similarity;
        }
      }
    }
  }
  return table;
}

}  // namespace

Comparison::Comparison(const Map& map_a, const Map& map_b, std::span<const SimilarClasses> similar) {
  const Relabelling relabelling = relabel(map_a.classNames(), map_b.classNames());
  a = viewOf(map_a, {});
  b = viewOf(map_b, relabelling);
  similarity = [table = similarities(map_a.classNames(), map_b.classNames(), relabelling, similar)](ClassId x,
                                                                                                    ClassId y) {
    const auto entry = table.find({x, y});
    return x == y ? 1.0 : entry == table.end() ? 0.0 : entry->second;
  };
  if (a.surfaces.empty() || b.surfaces.empty()) {
    return;
  }
  reach = kReach * std::max(a.grain, b.grain);
  index_a.emplace(a.surfaces, reach);
  index_b.emplace(b.surfaces, reach);
  wide_index_a.emplace(a.surfaces, 2 * reach);
}

}  // namespace hgg
