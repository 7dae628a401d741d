#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "core/types.h"

namespace hgg {

/// What the rows of a pose file are the poses of.
enum class PoseFrame : std::uint8_t { kUnknown, kLidar, kCamera };

/// Judges by the way driven, as seen from the sensor: along x for a LiDAR (x ahead, z up), along z for KITTI's camera
/// (z ahead, y down). kUnknown where it is less than a metre, or along neither.
PoseFrame judgePoseFrame(std::span<const Pose> poses);

/// T_camera_lidar of a KITTI calib.txt: the line "Tr:" (odometry, SemanticKITTI), "Tr_velo_to_cam:" or "Tr_velo_cam:".
/// Errors name the file.
Result<Pose> readCameraLidar(const std::filesystem::path& calib);

/// The poses of the LiDAR, in the frame it had at the first, of those of a camera: T^-1 P T with T = T_camera_lidar.
std::vector<Pose> lidarPoses(std::span<const Pose> camera_poses, const Pose& T_camera_lidar);

}  // namespace hgg
