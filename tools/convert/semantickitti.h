#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "convert/pose_frame.h"
#include "core/result.h"
#include "core/types.h"
#include "progress.h"

namespace hgg {

struct KittiOptions {
  std::filesystem::path dir;
  std::string labels = "labels";               // folder of .label files below dir
  std::filesystem::path poses;                 // 3x4 rows; empty: dir/odometry.txt, else dir/poses.txt
  PoseFrame pose_frame = PoseFrame::kUnknown;  // of these rows; kUnknown: judged by the way they go
  std::optional<double> rate_hz;               // unset: dir/times.txt, else 10 Hz
  bool learning_ids = false;                   // labels are SemanticKITTI's training ids: turned into raw ones
  double elevation_deg = 0;                    // points are lifted by this angle: a mistake of the sensor's calibration
};

struct KittiFrame {
  std::filesystem::path cloud, labels;
  Micros utime_us = 0;
  Pose T_world_body = Pose::Identity();  // body = LiDAR
  bool pose_was_cameras = false;         // its row was that of the camera
  bool learning_ids = false;             // as in KittiOptions
  double elevation_deg = 0;              // as in KittiOptions
};

/// KITTI's HDL-64 measures all beams this much too low (known from LiDAR odometry on it); uncorrected, the ground ahead
/// never fits the ground passed and a map of it bends upwards, by 0.8 degrees in 100 m.
inline constexpr double kKittiElevation_deg = 0.205;

/// A folder in the SemanticKITTI layout: velodyne/NNNNNN.bin (x, y, z, intensity as f32) and <labels>/NNNNNN.label
/// (u32), in order of NNNNNN. Row NNNNNN (from 0) of the poses and of times.txt belongs to the frame. Errors: missing
/// folder or file, no frames, torn records, another number of labels than points, too few rows, times that do not
/// increase, poses of the camera without a calib.txt that takes them to the LiDAR, and poses of which it cannot be
/// told.
Result<std::vector<KittiFrame>> listKittiFrames(const KittiOptions& options);

/// Points with label = low 16 bits and instance = high 16 bits of the label word, elevation corrected, training ids
/// made raw ones where the frame says so.
Result<std::vector<Point>> readKittiPoints(const KittiFrame& frame);

/// Writes the frames as an LCM log stamped with the times of measurement. Labels stay raw: folding is the class table's
/// business. Returns an error line, empty when done.
std::string convertKitti(const std::vector<KittiFrame>& frames, const std::filesystem::path& log,
                         const Progress& progress);

}  // namespace hgg
