#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "sim/sensor.h"
#include "truth/cloud.h"

namespace hgg {

/// A ball around a place of a surface, world frame.
struct Patch {
  Vec3 center;
  double radius = 0;  // m
};

/// Something that a segmenter takes for a thing of another class.
struct Mistake {
  std::size_t object = 0;                     // index into World::objects
  ClassId label = 0;                          // what it is taken for
  std::optional<Patch> patch = std::nullopt;  // that part of it; nullopt: the whole object
};

/// How long a common confusion lasts, frames, and how large a patch of stuff it takes, m across.
constexpr int kShortestMistake = 5, kLongestMistake = 20;
constexpr double kSmallestPatch = 1.0, kLargestPatch = 3.0;

/// Confusion with common classes, for each of `frames` frames. Every thing, and every stretch of stuff of kStretch m,
/// is wrong in `share` of the frames: it is taken for a class of things of the world that is common, drawn by how many
/// there are, for kShortestMistake to kLongestMistake frames at a time; of stuff it is a patch. `surface` are places of
/// the surfaces that can be seen, world frame: a patch is around one of them. A value depends on world and seed alone.
std::vector<std::vector<Mistake>> commonMistakes(const World& world, std::span<const CloudPoint> surface, double share,
                                                 std::uint64_t seed, std::size_t frames);

/// Classes of things at least this share of the world's things belong to are common.
constexpr double kCommonShare = 0.05;
/// m: a longer piece of stuff can be wrong in several places at once.
constexpr double kStretch = 10.0;

/// What a scan's segmenter needs to know of the mistakes of its frame.
struct FrameMistakes {
  std::vector<Mistake> patches;
  std::vector<Pose> T_world_sensor;  // one a column of the grid, or one for all

  /// The class a place of an object is taken for, if any; `p_sensor` as measured in column `x`.
  std::optional<ClassId> at(std::size_t object, int x, const Vec3& p_sensor) const;
};

/// Sorts a frame's mistakes: whole objects get their wrong name in `object_labels`, the rest is returned.
std::vector<Mistake> nameWholeObjects(std::span<const Mistake> mistakes, std::vector<ClassId>& object_labels);

}  // namespace hgg
