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

/// What aligning two maps came to, accepted or not.
struct ZeroShot {
  bool accepted = false;
  Pose T_a_b = Pose::Identity();                 // maps b's coordinates into a's: of the best place, if there is any
  std::vector<std::pair<NodeId, NodeId>> pairs;  // matched things (a, b), ascending by a
  double score = 0;      // nats: how much likelier the two maps are of one place that lies so, than of two places
  double threshold = 0;  // nats: ln of the places looked at, and ln 1000
  double runner_up = 0;  // nats: score of the best place elsewhere; 0 at least
  PlaceEvidence evidence;
  std::string reason;
};

/// What is known beforehand: T_a_b lies within these bounds of `T_a_b` (the distance where it matters: at `centre_b`).
struct PlacePrior {
  Pose T_a_b = Pose::Identity();
  Vec3 centre_b = Vec3::Zero();
  double distance = 0;  // m
  double turn = 0;      // rad
};

/// Aligns map b with map a, both upright to 5 degrees, without any initial pose: cliques of consistent pairs of things
/// give places to look at; each is registered coarse to fine and weighed by all that both maps have surveyed. Accepted
/// when the best one's score is above the threshold and twice that of any other, four things or more are matched,
/// neither things nor surfaces speak against it, and the pairs hold it in every direction. With a prior, places outside
/// of it are neither found nor rivals, and its own middle is looked at too.
ZeroShot alignMaps(const Map& a, const Map& b, std::span<const SimilarClasses> similar = {},
                   const std::optional<PlacePrior>& prior = std::nullopt);

}  // namespace hgg
