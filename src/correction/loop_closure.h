#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "map/paging.h"
#include "place/zero_shot.h"

namespace hgg {

/// Sizes and bounds that loop closing goes by. Made by loopConfigOf().
struct LoopConfig {
  double descriptor_radius = 0;  // m, around a keyframe: what its place descriptor covers
  double place_radius = 0;       // m, around a keyframe: the part of the map that verification compares
  double pass_distance = 0;      // m, farthest that two passes of one place are apart, drift aside
  double prior_slack = 0;        // m, that verification looks beyond what drift allows
  double prior_turn_slack = 0;   // rad, likewise
  double sigma = 0;              // m, per axis: what verification leaves open
  double sigma_turn = 0;         // rad, likewise
  double agree_distance = 0;     // m, the most by which two loops that confirm each other differ
  double agree_turn = 0;         // rad, likewise
};

/// Lengths follow from the scales of a map. The size of a place follows from `tile_size` (m), the edge of the tiles
/// of its stuff: what verification compares are four tiles to every side. How well a loop is known follows from
/// `leaf_size` (m), the size of the leaves that it is registered by. `gate` (m) is that of alignment: beyond drift,
/// verification looks as far as half of it.
LoopConfig loopConfigOf(double tile_size, double leaf_size, double gate);

/// What the things around a keyframe look like from any side: how often two classes stand at a distance, as a histogram
/// over (pair of classes, distance) of unit length.
using PlaceDescriptor = std::array<float, 128>;

/// Descriptor of the active, confirmed things within `radius` (m) of a place.
PlaceDescriptor describePlace(const Map& map, const Vec3& centre, double radius);
/// Cosine, 0 (nothing in common) .. 1 (alike).
double similarityOf(const PlaceDescriptor& a, const PlaceDescriptor& b);

/// Two parts of the map that may show one place: the one the robot is in, and one it left so long ago that it may have
/// drifted from it. Holds copies, so that it can be verified beside the frame work.
struct LoopCandidate {
  Map before, now;
  TimedPose keyframe_before, keyframe_now;
  KeyframeId before_id = 0, now_id = 0;
  PlacePrior prior;
  Drift drift;  // from one keyframe to the other
};

/// What verifying a candidate found.
struct LoopVerification {
  BetweenConstraint loop;  // from keyframe_before to keyframe_now; meaningful when the alignment is accepted
  ZeroShot alignment;
  double deviations =
      0;  // from where the keyframes lay, in standard deviations of the drift; chi, 6 degrees of freedom
};

/// A keyframe that may show the place of the last one.
struct LoopKeyframe {
  KeyframeId id = -1;
  Drift drift;  // from it to the last one
};

/// What finding loops keeps in mind, so that looking at a keyframe costs the same however many there are: the drift
/// from a keyframe of some time ago, and which of the far keyframes come next.
struct LoopSearch {
  KeyframeId from = -1;
  std::vector<Drift> drift;  // from it
  std::size_t next = 0;
};

/// The inactive keyframes that most likely show the place of the current one, of those that drift allows, best first:
/// the nearest one where drift is small, else up to three that look most alike, all half a place apart. `descriptors`
/// are those of the keyframes. Empty when drift allows none. Reads keyframes only: nodes need not be in memory. Of more
/// than some thousand keyframes those that lie near are looked at, and a share of the others in turn; the drift is then
/// at most that of the way by way of `search.from`.
std::vector<LoopKeyframe> findLoopKeyframes(const Map& map, const std::vector<PlaceDescriptor>& descriptors,
                                            const LoopConfig& config, LoopSearch& search);

/// Copies the two parts of the map out, of `place_radius` around each keyframe. The one around the current keyframe
/// must be in memory; of the other, what is paged out is read by `pages`, and stays where it is. nullopt when either
/// has too few things.
std::optional<LoopCandidate> cutLoopCandidate(const Map& map, const LoopKeyframe& keyframe, const LoopConfig& config,
                                              const PageReader& pages = nullptr);

/// Aligns the two parts of a candidate without an initial pose, within what drift allows.
LoopVerification verifyLoop(const LoopCandidate& candidate, std::span<const SimilarClasses> similar,
                            const LoopConfig& config);

}  // namespace hgg
