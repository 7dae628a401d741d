#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "alignment/registration.h"
#include "core/classes.h"
#include "map/map.h"
#include "place/evidence.h"

namespace hgg {

/// The result of aligning two maps, whether accepted or not.
struct ZeroShot {
  bool accepted = false;
  Pose T_a_b = Pose::Identity();  // maps b's coordinates into a's: of the best place, if there is any
  /// Matched things (a, b), ascending by a; of maps without leaves also those that are of one place and size under
  /// different names, which are no evidence.
  std::vector<std::pair<NodeId, NodeId>> pairs;
  double score = 0;      // nats: log odds that both maps show one place and lie so, against two different places
  double threshold = 0;  // nats, what the score has to exceed: ln of the number of places looked at, plus ln 1000
  double runner_up = 0;  // nats: score of the best place elsewhere; 0 at least
  PlaceEvidence evidence;
  std::string reason;
};

/// What is known beforehand: the true transform lies within these bounds of `T_a_b`. The distance is taken at
/// `centre_b`, because far from it a small turn would already exceed it.
struct PlacePrior {
  Pose T_a_b = Pose::Identity();
  Vec3 centre_b = Vec3::Zero();
  double distance = 0;  // m
  double turn = 0;      // rad
};

/// Aligns map b with map a, both upright to 5 degrees, without any initial pose. Cliques of consistent pairs of things
/// give places to look at; each is registered coarse to fine and weighed by all that both maps have surveyed. The best
/// one is accepted when its score is above the threshold and twice that of any other place, four things or more are
/// matched, neither things nor surfaces speak against it, and the pairs determine it in every direction. With a prior,
/// places outside of it are not considered, and the prior's own transform is looked at too. Where a map has no leaves
/// at all (hggmap import), things are all that is registered and weighed; not so within a prior.
ZeroShot alignMaps(const Map& a, const Map& b, std::span<const SimilarClasses> similar = {},
                   const std::optional<PlacePrior>& prior = std::nullopt);

}  // namespace hgg
