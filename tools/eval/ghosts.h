#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "eval/objects.h"
#include "truth/cloud.h"

namespace hgg {

/// Why a prediction that matches nothing is there.
enum class GhostCause : std::uint8_t {
  kSecond,   // on a true thing of its class, which has a node of its own: a second node, or a piece
  kMover,    // on the track of something that moves
  kGone,     // where a thing of its class was until it was taken away
  kSurface,  // on a surface of another class: a thing, stuff
  kNothing   // none of these: noise
};
inline constexpr std::array kGhostCauses{GhostCause::kSecond, GhostCause::kMover, GhostCause::kGone,
                                         GhostCause::kSurface, GhostCause::kNothing};
/// "second", "mover", "gone", "surface", "nothing".
std::string nameOf(GhostCause cause);

struct Ghost {
  NodeId prediction = 0;
  GhostCause cause = GhostCause::kNothing;
  std::int64_t of = 0;  // the true object it is about (stuff has ids too); 0: none
};

/// Two predictions of one class that are one true thing.
struct Twins {
  NodeId a = 0, b = 0;
  std::int64_t truth = 0;
  double distance = 0;  // m between their means
};
/// m: means of one class farther apart are no twins.
constexpr double kTwinReach = 0.5;

/// All pairs of predictions of the same class of things with means within kTwinReach of each other, whose nearest true
/// object of that class, within `radius`, is the same. By ascending ids.
std::vector<Twins> findTwins(std::span<const MappedObject> predictions, std::span<const TruthObject> truth,
                             double radius);

/// What the map calls dynamic beside what moves.
struct MovingScore {
  std::size_t truth = 0;  // true objects that move and were seen in at least kSeenFrames
  std::size_t said = 0;   // of them, those with a dynamic prediction of their class on their track
  std::optional<std::size_t> soon = std::nullopt;  // of them, by their kSeenFrames-th frame; needs moving.jsonl
  std::vector<NodeId> parked;     // dynamic predictions that are a true thing of their class that stays
  std::vector<NodeId> elsewhere;  // and those that are neither
};
constexpr std::int64_t kSeenFrames = 10;
/// A frame with fewer points of an object does not count as one that sees it here: no class that moves makes an object
/// of fewer.
constexpr std::int64_t kSeenPoints = 20;
MovingScore scoreMoving(std::span<const MappedObject> predictions, std::span<const TruthObject> truth, double radius);

/// A track that the mapper told of while it drove, in order of time.
struct ToldMover {
  NodeId id = 0;
  ClassId label = 0;
  std::vector<Vec3> places = {};
  std::vector<Micros> times_us = {};
  std::vector<std::int64_t> frames = {};  // of the truth; empty: not known
};
/// The same of such tracks. A track is that of the thing of its class that most of its places are on, at the same
/// frames where these are known. In time (`soon`) is what was told of before or at the kSeenFrames-th frame that saw
/// it; without frames, the first place belongs to the frame of the nearest point of the true track.
MovingScore scoreMoving(std::span<const ToldMover> told, std::span<const TruthObject> truth, double radius);
/// moving.jsonl of a run (docs/file-format.md), each track under the class it had in the end.
Result<std::vector<ToldMover>> readMoving(const std::filesystem::path& path);

/// The cause of each ghost of the evaluation, by the first of these that holds: it lies on a true thing of its class
/// that stays; on the track of something of its class that moves; on a thing of its class that is gone; most of its
/// leaves lie on surface of the reference cloud that is of its own class (a piece), or of another; on any thing's
/// track; on a true thing of another class. A place is on a thing when it is within two deviations of its points,
/// widened by radius / 6, and on a track or a surface when within `radius` (horizontally) or radius / 5 of it. `cloud`
/// may be empty, and predictions without leaves are judged by their means.
std::vector<Ghost> explainGhosts(std::span<const MappedObject> predictions, std::span<const TruthObject> truth,
                                 const ObjectEvaluation& evaluation, std::span<const CloudPoint> cloud, double radius);

}  // namespace hgg
