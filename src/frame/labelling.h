#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/classes.h"
#include "frame/frame.h"
#include "frame/image.h"
#include "frame/rig.h"
#include "frame/rig_counts.h"

namespace hgg {

/// A label image and where it was taken from, as seen from a cloud. `T_camera_body`: from the body at the cloud's time
/// to the camera at the image's.
struct LabelView {
  const RigCamera* camera = nullptr;
  const LabelImage* image = nullptr;  // of the camera's size
  std::size_t number = 0;             // of the camera in its rig: keeps the instances of two cameras apart
  Pose T_camera_body = Pose::Identity();
  double baseline = 0;  // m between the camera and where the cloud was measured from: nothing hides a point without one
};

struct LabellingOptions {
  double beam_spacing = 0;    // rad between beams: how dense the cloud is in the image, 0: denser than the pixels
  double min_confidence = 0;  // pixels below this share have no say
};

/// The counts of a cloud, and those of each view, where `points` and `labelled` say nothing.
struct LabelReport {
  LabelCounts all;
  std::vector<LabelCounts> views;
};

/// Gives each point the label of the pixel it falls on, and its instance; kUnknownClass where there is none. What the
/// points had before is forgotten.
///
/// * A point that has nearer points on all sides in the image is hidden where the baseline allows it: it takes no label
///   from there.
/// * Near the border of a mask (RigCamera::margin) a label may have bled from one surface to the one behind it. There
///   the depth has a say (LabelDepths::judge).
/// * Of several cameras the label with the most confidence wins, summed up; labels near borders count half.
/// * Instances that an image cuts off at its edge are left to the clustering where there are several views.
LabelReport labelPoints(std::span<Point> points, std::span<const LabelView> views, const LabellingOptions& options);

}  // namespace hgg
