#include "place/comparison.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>

#include "alignment/align.h"
#include "core/position_uncertainty.h"
#include "core/spd.h"

namespace hgg {
namespace {

// Chosen by hand; the figures of docs/experiments.md, "Zero-shot alignment", were measured with them.
constexpr double kSurveyGrains = 5;  // survey_distance in grains: leaves of one surface lie about two grains apart
constexpr double kLevel = 0.8;       // cosine to the vertical (37 degrees) from which on a surface may be ground
constexpr double kFlat = 0.1;        // least variance over the middle one below which a leaf is flat

Landmark landmarkOf(const MapNode& node, ClassId label) {
  const Mat3& cov = node.belief.cov;
  const double middle = 0.5 * (cov(0, 0) + cov(1, 1));
  const double spread = std::hypot(0.5 * (cov(0, 0) - cov(1, 1)), cov(0, 1));
  Landmark l;
  l.mean = node.belief.mean;
  l.size = Vec3(std::sqrt(std::max(middle - spread, 0.0)), std::sqrt(middle + spread), std::sqrt(cov(2, 2)));
  l.sigma = commonDeviation(kPositionBetweenDrives, std::sqrt(middle));
  l.label = label;
  return l;
}

Surface surfaceOf(const Belief& leaf, ClassId label) {
  const Eigen3 e = eigenSymmetric(leaf.cov);
  Surface s;
  s.mean = leaf.mean;
  s.cov = regularized(leaf.cov);
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

/// The label to compare by of every label of a map; itself where it is not in here.
using Relabelling = std::map<ClassId, ClassId>;

/// Labels that a map uses or names.
std::set<ClassId> labelsOf(const Map& map) {
  std::set<ClassId> labels;
  for (const auto& [id, node] : map.nodes()) {
    labels.insert(node.label);
  }
  for (const auto& [id, name] : map.classNames()) {
    labels.insert(id);
  }
  return labels;
}

/// For a and for b, where both carry names: classes of one name get one label, the lowest id that a has for it. A name
/// that a lacks gets a label that neither map uses. An id that neither map names stays what it is.
std::pair<Relabelling, Relabelling> relabel(const Map& a, const Map& b) {
  std::pair<Relabelling, Relabelling> result;
  const auto &names_a = a.classNames(), &names_b = b.classNames();
  if (names_a.empty() || names_b.empty()) {
    return result;
  }
  std::map<std::string, ClassId> by_name;
  for (const auto& [id, name] : names_a) {
    result.first[id] = by_name.emplace(name, id).first->second;
  }
  const std::set<ClassId> used_a = labelsOf(a), used_b = labelsOf(b);
  ClassId spare = 65535;
  const auto nextSpare = [&] {
    while (spare > 0 && (used_a.contains(spare) || used_b.contains(spare))) {
      --spare;
    }
    return spare > 0 ? spare-- : spare;
  };
  for (const ClassId id : used_b) {
    const auto name = names_b.find(id);
    if (name != names_b.end()) {
      const auto [same, is_new] = by_name.try_emplace(name->second, 0);
      same->second = is_new ? nextSpare() : same->second;
      result.second[id] = same->second;
    } else if (names_a.contains(id)) {
      result.second[id] = nextSpare();
    }
  }
  return result;
}

ClassId relabelled(const Relabelling& relabelling, ClassId label) {
  const auto other = relabelling.find(label);
  return other == relabelling.end() ? label : other->second;
}

ComparisonSide sideOf(const Map& map, const Relabelling& relabelling) {
  ComparisonSide side;
  std::vector<double> sizes;
  for (const auto& [id, node] : map.nodes()) {
    const ClassId label = relabelled(relabelling, node.label);
    if (!node.stuff) {
      side.things.push_back(side.nodes.size());
      side.landmarks.push_back(landmarkOf(node, label));
      side.trust.push_back(existenceOf(node));
    }
    side.nodes.push_back(&node);
    const std::size_t first = side.surfaces.size();
    for (const Leaf& leaf : leavesOf(node)) {
      const Belief belief = transform(node.T_map_object, unpackLeaf(leaf));
      sizes.push_back(std::sqrt(belief.cov.trace()));
      side.surfaces.push_back(surfaceOf(belief, label));
    }
    side.surfaces_of.emplace_back(first, side.surfaces.size());
  }
  side.grain = medianOf(std::move(sizes));
  side.outline = outlineOf(side.landmarks);
  return side;
}

/// The similarity of every pair of labels that `similar` names, whichever map carries which name.
std::map<std::pair<ClassId, ClassId>, double> similarities(const std::map<ClassId, std::string>& names_a,
                                                           const std::map<ClassId, std::string>& names_b,
                                                           const std::pair<Relabelling, Relabelling>& relabellings,
                                                           std::span<const SimilarClasses> similar) {
  std::map<std::pair<ClassId, ClassId>, double> table;
  for (const auto& [id_a, name_a] : names_a) {
    for (const auto& [id_b, name_b] : names_b) {
      for (const SimilarClasses& s : similar) {
        const bool is_this = (s.a == name_a && s.b == name_b) || (s.a == name_b && s.b == name_a);
        if (is_this) {
          table[{relabelled(relabellings.first, id_a), relabelled(relabellings.second, id_b)}] = s.similarity;
        }
      }
    }
  }
  return table;
}

}  // namespace

Comparison::Comparison(const Map& map_a, const Map& map_b, std::span<const SimilarClasses> similar) {
  const auto relabellings = relabel(map_a, map_b);
  a = sideOf(map_a, relabellings.first);
  b = sideOf(map_b, relabellings.second);
  similarity = [table = similarities(map_a.classNames(), map_b.classNames(), relabellings, similar)](ClassId x,
                                                                                                     ClassId y) {
    const auto entry = table.find({x, y});
    return x == y ? 1.0 : entry == table.end() ? 0.0 : entry->second;
  };
  by_things = a.surfaces.empty() || b.surfaces.empty();
  const double distance = kSurveyGrains * std::max(a.grain, b.grain);
  if (by_things || !(distance > 0)) {
    return;
  }
  survey_distance = distance;
  index_a.emplace(a.surfaces);
  index_b.emplace(b.surfaces);
}

}  // namespace hgg
