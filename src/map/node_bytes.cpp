#include "map/node_bytes.h"

#include <algorithm>
#include <cmath>

namespace hgg {
namespace {

ClassBelief getClasses(ByteReader& r) {
  ClassBelief classes;
  classes.views.resize(r.count(r.get<std::uint16_t>(), 6));
  int last = -1;
  for (auto& [label, views] : classes.views) {
    label = r.get<ClassId>(), views = r.get<float>();
    r.require(label > last && views >= 0 && views <= 1e4F);
    last = label;
  }
  return classes;
}

void getLooks(ByteReader& r, std::uint32_t version, MapNode& node) {
  Looks& looks = node.looks;
  const auto bits = r.get<std::uint8_t>();
  const int more = version > kMapVersionWithoutFreeSpace ? kHasFreeSpace : 0;
  r.require(bits <= (kHasColour | kHasFront | more));
  if ((bits & kHasColour) != 0) {
    std::array<std::uint8_t, 3> rgb{};
    for (std::uint8_t& v : rgb) {
      v = r.get<std::uint8_t>();
    }
    looks.rgb = rgb;
  }
  if ((bits & kHasFront) != 0) {
    Vec3 front;
    for (Eigen::Index i = 0; i < 3; ++i) {
      front[i] = static_cast<double>(r.get<float>());
    }
    r.require(std::abs(front.norm() - 1) < 1e-3);
    looks.front_object = front;
  }
  if ((bits & kHasFreeSpace) != 0) {
    for (float* views : {&node.classes.seen_through, &node.classes.passed}) {
      *views = r.get<float>();
      r.require(*views >= 0 && *views <= 1e4F);
    }
  }
}

void putLooks(ByteWriter& w, const MapNode& node) {
  const Looks& looks = node.looks;
  w.put(static_cast<std::uint8_t>((looks.rgb ? kHasColour : 0) | (looks.front_object ? kHasFront : 0) |
                                  (hasFreeSpace(node) ? kHasFreeSpace : 0)));
  if (looks.rgb) {
    for (const std::uint8_t v : *looks.rgb) {
      w.put(v);
    }
  }
  if (looks.front_object) {
    for (Eigen::Index i = 0; i < 3; ++i) {
      w.put(static_cast<float>((*looks.front_object)[i]));
    }
  }
  if (hasFreeSpace(node)) {
    w.put(node.classes.seen_through), w.put(node.classes.passed);
  }
}

bool isWithin(double sigma, const SigmaLimits& limits) { return sigma >= limits.least && sigma <= limits.most; }

}  // namespace

bool hasLooks(const MapNode& node) { return node.looks.rgb || node.looks.front_object; }

bool hasFreeSpace(const MapNode& node) { return node.classes.seen_through > 0 || node.classes.passed > 0; }

void putNode(ByteWriter& w, const MapNode& node, std::uint32_t version) {
  w.put(node.id);
  w.put(node.label);
  w.put(static_cast<std::uint8_t>(node.stuff));
  w.put(node.tile.x), w.put(node.tile.y), w.put(node.tile.z);
  w.put(node.belief);
  w.put(node.T_map_object);
  w.put(node.views);
  w.put(node.first_us), w.put(node.last_us);
  w.put(node.anchor);
  w.put(static_cast<std::uint32_t>(leavesOf(node).size()));
  for (const Leaf& leaf : leavesOf(node)) {
    for (const float v : leaf.mean) {
      w.put(v);
    }
    for (const float v : leaf.cov) {
      w.put(v);
    }
    w.put(leaf.kappa);
  }
  w.put(static_cast<std::uint16_t>(node.classes.views.size()));
  for (const auto& [label, views] : node.classes.views) {
    w.put(label), w.put(views);
  }
  if (version > kMapVersionWithoutLooks) {
    putLooks(w, node);
  }
}

MapNode getNode(ByteReader& r, std::uint32_t version) {
  MapNode node;
  node.id = r.get<NodeId>();
  node.label = r.get<ClassId>();
  node.stuff = r.get<std::uint8_t>() != 0;
  node.tile.x = r.get<std::int32_t>(), node.tile.y = r.get<std::int32_t>(), node.tile.z = r.get<std::int32_t>();
  node.belief = r.belief();
  node.T_map_object = r.pose();
  node.views = r.get<std::int32_t>();
  node.first_us = r.get<Micros>(), node.last_us = r.get<Micros>();
  node.anchor = version > kVersionWithoutConstraints ? r.get<KeyframeId>() : -1;
  Leaves leaves(r.count(r.get<std::uint32_t>(), sizeof(Leaf)));
  for (Leaf& leaf : leaves) {
    for (float& v : leaf.mean) {
      v = r.get<float>();
    }
    for (float& v : leaf.cov) {
      v = r.get<float>();
    }
    leaf.kappa = r.get<float>();
  }
  node.geometry = shareLeaves(std::move(leaves));
  if (version != kVersionWithoutClasses) {
    node.classes = getClasses(r);
  } else if (!node.stuff) {
    addViews(node.classes, {{node.label, static_cast<float>(std::max(node.views, 0))}});
  }
  if (version > kMapVersionWithoutLooks) {
    getLooks(r, version, node);
  }
  return node;
}

void putConstraint(ByteWriter& w, const BetweenConstraint& e) {
  w.put(e.a), w.put(e.b);
  w.put(e.T_a_b);
  w.put(std::clamp(e.sigma, kSigmaLimits.least, kSigmaLimits.most));
  w.put(std::clamp(e.sigma_turn, kSigmaTurnLimits.least, kSigmaTurnLimits.most));
  w.put(static_cast<std::uint8_t>(e.is_loop));
  w.put(std::clamp(e.expected, kSigmaLimits.least, kSigmaLimits.most));
  w.put(std::clamp(e.expected_turn, kSigmaTurnLimits.least, kSigmaTurnLimits.most));
}

BetweenConstraint getConstraint(ByteReader& r, std::uint32_t version) {
  BetweenConstraint e;
  e.a = r.get<KeyframeId>(), e.b = r.get<KeyframeId>();
  e.T_a_b = r.pose();
  e.sigma = r.get<double>(), e.sigma_turn = r.get<double>();
  e.is_loop = r.get<std::uint8_t>() != 0;
  e.expected = version <= kVersionWithoutExpected ? e.sigma : r.get<double>();
  e.expected_turn = version <= kVersionWithoutExpected ? e.sigma_turn : r.get<double>();
  r.require(e.a >= 0 && e.b >= 0 && e.a != e.b && isWithin(e.sigma, kSigmaLimits) &&
            isWithin(e.sigma_turn, kSigmaTurnLimits) && isWithin(e.expected, kSigmaLimits) &&
            isWithin(e.expected_turn, kSigmaTurnLimits));
  return e;
}

}  // namespace hgg
