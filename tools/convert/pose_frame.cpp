#include "convert/pose_frame.h"

#include <cmath>
#include <fstream>
#include <sstream>

#include "truth/poses.h"

namespace hgg {
namespace {

constexpr double kShortestWay = 1.0;  // m; noise of a sensor that stands has any direction
constexpr double kAhead = 3.0;        // times as far along one axis as along the other two
constexpr double kStride = 0.5;       // m; steps shorter than this are mostly noise

}  // namespace

PoseFrame judgePoseFrame(std::span<const Pose> poses) {
  Vec3 way = Vec3::Zero();
  for (std::size_t from = 0, to = 1; to < poses.size(); ++to) {
    const Vec3 step = poses[from].linear().transpose() * (poses[to].translation() - poses[from].translation());
    if (step.norm() >= kStride) {
      way += step.cwiseAbs();
      from = to;
    }
  }
  if (way.norm() < kShortestWay) {
    return PoseFrame::kUnknown;
  }
  const auto is_along = [&](int axis) {
    return way[axis] > kAhead * way[(axis + 1) % 3] && way[axis] > kAhead * way[(axis + 2) % 3];
  };
  return is_along(0) ? PoseFrame::kLidar : is_along(2) ? PoseFrame::kCamera : PoseFrame::kUnknown;
}

Result<Pose> readCameraLidar(const std::filesystem::path& calib) {
  std::ifstream in(calib);
  if (!in) {
    return Result<Pose>::fail("cannot read " + calib.string());
  }
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string name;
    words >> name;
    if (name != "Tr:" && name != "Tr_velo_to_cam:" && name != "Tr_velo_cam:") {
      continue;
    }
    std::array<double, 12> row{};
    for (double& value : row) {
      words >> value;
    }
    const std::optional<Pose> pose = words ? poseOfRow(row) : std::nullopt;
    return pose ? Result<Pose>::ok(*pose)
                : Result<Pose>::fail(calib.string() + ": " + name + " is not followed by a 3x4 rigid transform");
  }
  return Result<Pose>::fail(calib.string() + " has no line Tr: (camera from LiDAR)");
}

std::vector<Pose> lidarPoses(std::span<const Pose> camera_poses, const Pose& T_camera_lidar) {
  std::vector<Pose> out;
  for (const Pose& T_start_camera : camera_poses) {
    out.push_back(T_camera_lidar.inverse() * T_start_camera * T_camera_lidar);
  }
  return out;
}

}  // namespace hgg
