#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "convert/semantickitti.h"
#include "frame/image.h"
#include "frame/rig.h"

namespace hgg {

/// Four cameras around a spinning LiDAR, that see all that it sees: 100 degrees wide each, a hand's breadth below it
/// and 0.27 m out to their side, as KITTI's are.
Rig virtualRig();

/// What a segmenter would say of the image of a camera in which labelled points are seen: the nearest point of each
/// pixel, between points the label of the nearest of them up to a few pixels away, and no class beyond. Masks then
/// bleed as those of segmenters do: what is nearer covers `bleed` pixels more of what is behind it. Body frame.
LabelImage paintLabels(const RigCamera& camera, const std::vector<Point>& points, int bleed);

/// Writes the frames as an LCM log of a rig: clouds without labels, and label images of virtualRig(); and its rig file
/// beside it, <stem>.rig.toml. Returns an error line, empty when done.
std::string convertKittiToRig(const std::vector<KittiFrame>& frames, int bleed, const std::filesystem::path& log,
                              const Progress& progress);

/// A rig file (docs/rig.md). Returns an error line, empty when done.
std::string writeRigFile(const Rig& rig, const std::string& about, const std::filesystem::path& path);

}  // namespace hgg
