#pragma once

#include <string>
#include <vector>

#include "core/classes.h"
#include "core/result.h"
#include "core/types.h"
#include "frame/camera.h"

namespace hgg {

/// A LiDAR whose clouds carry no labels.
struct RigLidar {
  std::string name, channel;
  Pose T_body_lidar = Pose::Identity();
  Micros offset_us = 0;  // what was measured at t is stamped t - offset
};

/// What becomes of a number in a label image.
struct LabelSet {
  static constexpr std::int32_t kForeign = -1;  // the segmenter must not send it: taken for no class, and counted
  std::vector<std::int32_t> class_of;           // by number: a ClassId, kUnknownClass for "no class", or kForeign

  std::int32_t at(std::uint16_t number) const { return number < class_of.size() ? class_of[number] : kForeign; }
};

/// A camera whose label images come from a segmenter, and maybe depth images from itself.
struct RigCamera {
  std::string name;
  std::string labels, depth;  // channels; empty: none
  CameraModel model;
  Pose T_body_camera = Pose::Identity();
  Micros offset_us = 0;  // what was exposed at t is stamped t - offset
  int margin = 2;  // pixels: nearer to the border of a mask than this, a label is taken only with the depth's consent
  LabelSet label_set;
  int depth_stride = 1;         // pixels: each how many of the depth image becomes a point
  double depth_unit = 0.001;    // m a count of the depth image
  double depth_min = 0.1;       // m along the axis: nearer is not believed
  double depth_max = 0;         // m: farther is not believed; 0: depth_noise says it
  double depth_noise = 0.0015;  // standard deviation of a depth z is this times z^2, 1/m
};

/// What a robot carries: where its clouds come from, and its cameras. Body frame: x forward, z up.
struct Rig {
  std::vector<RigLidar> lidars;
  std::vector<RigCamera> cameras;
  Micros wait_us = 200'000;     // how long a cloud waits for the images of its time
  Micros max_age_us = 500'000;  // between an image and the cloud it may label
};

/// A channel of clouds: of a LiDAR, or of a camera that measures depth.
struct CloudSource {
  std::string name, channel;
  const RigLidar* lidar = nullptr;    // one of the two
  const RigCamera* camera = nullptr;  // is set
};

/// LiDARs first, in the order of the file. The first is the one whose times frames have. Points into `rig`.
std::vector<CloudSource> cloudSources(const Rig& rig);

/// Reads a rig file (docs/rig.md). The error lists everything that is wrong with it, a line each: unknown keys, missing
/// ones, wrong types and ranges, rotations that are none, names and channels given twice, classes that are not in the
/// table.
Result<Rig> parseRig(const std::string& toml_text, const std::string& source_name, const ClassTable& classes);
Result<Rig> loadRig(const std::string& path, const ClassTable& classes);

}  // namespace hgg
