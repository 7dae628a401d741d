#pragma once

#include <optional>
#include <string>
#include <vector>

#include "frame/image.h"
#include "sim/confusion.h"
#include "sim/sensor.h"

namespace hgg {

/// How a segmenter goes wrong; all rates are shares.
struct LabelErrors {
  double speckle = 0;    // of pixels: another class of the world, at random
  double unknown = 0;    // of pixels: label 0
  double bleed = 0;      // of pixels beside another object: they take its label, in clumps
  double bleed_deg = 0;  // what counts as beside
  double confused = 0;   // of (confusable object, frame) pairs: the whole object is taken for its `confused_with`
  double common = 0;     // of (thing or stretch of stuff, frame) pairs: taken for another common class, see confusion.h
  double missed = 0;     // of (thing, frame) pairs: the whole object is unknown
  double mixed = 0;      // of returns between two surfaces (clouds only): they get a label, not unknown
  int stretch_frames = 1;  // how long an object stays confused or missed
};

/// "perfect", "good" or "poor"; images bleed more than clouds. nullopt for other names.
enum class Segmented { kCloud, kImage };
std::optional<LabelErrors> labelPreset(const std::string& name, Segmented what);

/// What each object of the world is taken for in a frame. Confusion and misses come in stretches of frames that begin
/// at another frame for each object; one object is never both.
std::vector<ClassId> objectLabels(const World& world, const LabelErrors& errors, std::uint64_t seed, std::size_t frame);

/// Classes of the world, ascending: what speckle draws from.
std::vector<ClassId> worldLabels(const World& world);

/// A segmenter's work on a world.
struct Segmentation {
  const World* world = nullptr;
  LabelErrors errors;
  std::vector<ClassId> palette;  // worldLabels()
  bool instances = false;        // ids of things on their pixels; else none
};

/// The labels of what each ray of the grid met; 0 where it met nothing. An object that is missed has no instance, nor
/// has speckle, nor has a patch of stuff that is taken for a thing. Confidence is high where the label is right, lower
/// and overlapping where it is wrong.
LabelImage segment(const Segmentation& segmentation, const RayGrid& grid, const Scan& scan,
                   const std::vector<ClassId>& object_labels, const RandomKey& key, int threads,
                   const FrameMistakes& mistakes = {});

}  // namespace hgg
