#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "config.h"
#include "map/map.h"
#include "place/zero_shot.h"

namespace hgg {

/// What the things around a keyframe look like from any side: how often two classes stand at a distance, as a histogram
/// over (pair of classes, distance) of unit length.
using PlaceDescriptor = std::array<float, 128>;

/// How far around a keyframe it is described, m.
double descriptorRadius(const Config& config);
/// Of the active things believed in within `radius` (m) of a place.
PlaceDescriptor describePlace(const Map& map, const Vec3& centre, double radius);
/// Cosine, 0 (nothing in common) .. 1 (alike).
double similarityOf(const PlaceDescriptor& a, const PlaceDescriptor& b);

/// Two parts of the map that may show one place: what the robot is in, and what it left so long ago that it may have
/// drifted from it. Holds copies, so that it can be answered beside the frame work.
struct LoopCandidate {
  Map before, now;
  TimedPose keyframe_before, keyframe_now;
  KeyframeId before_id = 0, now_id = 0;
  PlacePrior prior;
  Drift drift;  // from one keyframe to the other
};

/// What comparing them came to.
struct LoopVerification {
  BetweenConstraint loop;  // when accepted
  ZeroShot alignment;
  double deviations = 0;  // between what is found and where the keyframes lay, of what drift allows; chi, 6 dimensions
};

/// The keyframe out of reach that most likely shows where the last one is: the one that looks most like it among those
/// which drift allows, the nearest where drift is small. nullopt when nothing out of reach is near enough.
std::optional<LoopCandidate> findLoopCandidate(const Map& map, const std::vector<PlaceDescriptor>& descriptors,
                                               const Config& config);

/// Verification: zero-shot alignment of the two parts within what drift allows.
LoopVerification verifyLoop(const LoopCandidate& question, std::span<const SimilarClasses> similar,
                            const Config& config);

}  // namespace hgg
