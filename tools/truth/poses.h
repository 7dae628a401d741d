#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <vector>

#include "core/result.h"
#include "map/map.h"

namespace hgg {

/// Text files of numbers, one record a line; blank lines and lines that start with '#' are skipped. Errors name file
/// and line.

/// The pose of a row of twelve numbers, as readPoses() takes it; nullopt where it is none.
std::optional<Pose> poseOfRow(const std::array<double, 12>& row);

/// 3x4 row-major pose rows. Rotations are orthonormalised; a row more than 1e-2 away from a rotation is an error.
Result<std::vector<Pose>> readPoses(const std::filesystem::path& path);
/// Times in seconds, one a row, rounded to microseconds.
Result<std::vector<Micros>> readTimes(const std::filesystem::path& path);
/// A TUM trajectory: rows t x y z qx qy qz qw, t in seconds.
Result<std::vector<TimedPose>> readTum(const std::filesystem::path& path);

/// Writes 3x4 rows with every digit, so that reading gives the same numbers. Returns an error line, empty when done.
std::string writePoses(const std::vector<Pose>& poses, const std::filesystem::path& path);

}  // namespace hgg
