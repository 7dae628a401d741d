#include "convert/semantickitti.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <numbers>

#include "convert/label_ids.h"
#include "frame_log.h"
#include "truth/poses.h"

namespace hgg {
namespace {

namespace fs = std::filesystem;

constexpr double kDefaultRateHz = 10.0;
constexpr std::size_t kPointBytes = 16, kLabelBytes = 4;

struct NumberedFile {
  std::size_t number;
  fs::path path;
};

std::optional<std::size_t> frameNumber(const fs::path& path) {
  const std::string stem = path.stem().string();
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(stem.data(), stem.data() + stem.size(), number);
  const bool is_number = error == std::errc() && end == stem.data() + stem.size();
  return path.extension() == ".bin" && is_number ? std::optional(number) : std::nullopt;
}

Result<std::vector<NumberedFile>> listClouds(const fs::path& dir) {
  using Files = Result<std::vector<NumberedFile>>;
  std::error_code error;
  std::vector<NumberedFile> files;
  for (fs::directory_iterator it(dir, error), end; !error && it != end; it.increment(error)) {
    if (const auto number = frameNumber(it->path())) {
      files.push_back({*number, it->path()});
    }
  }
  if (error) {
    return Files::fail("cannot read folder " + dir.string() + ": " + error.message());
  }
  if (files.empty()) {
    return Files::fail("no frames: " + dir.string() + " holds no NNNNNN.bin");
  }
  std::ranges::sort(files, {}, &NumberedFile::number);
  return Files::ok(std::move(files));
}

fs::path posesPath(const KittiOptions& options) {
  if (!options.poses.empty()) {
    return options.poses;
  }
  const fs::path odometry = options.dir / "odometry.txt";
  return fs::exists(odometry) ? odometry : options.dir / "poses.txt";
}

std::string tooFewRows(const fs::path& path, std::size_t rows, const NumberedFile& file) {
  return path.string() + " has " + std::to_string(rows) + " rows, but frame " + file.path.stem().string() +
         " needs row " + std::to_string(file.number + 1);
}

/// Poses of the LiDAR, and whether the file had those of the camera.
struct SensorPoses {
  std::vector<Pose> T_world_lidar;
  bool were_cameras = false;
};

/// Takes the poses of the file to the LiDAR where they are the camera's, as those of KITTI's downloads are.
Result<SensorPoses> toLidar(std::vector<Pose> poses, const KittiOptions& options, const fs::path& path) {
  const fs::path calib = options.dir / "calib.txt";
  const bool is_given = options.pose_frame != PoseFrame::kUnknown;
  const PoseFrame frame = is_given ? options.pose_frame : judgePoseFrame(poses);
  if (frame == PoseFrame::kCamera) {
    const auto T_camera_lidar = readCameraLidar(calib);
    return T_camera_lidar
               ? Result<SensorPoses>::ok({lidarPoses(poses, *T_camera_lidar), true})
               : Result<SensorPoses>::fail(path.string() + " holds poses of the camera (they go along z); " +
                                           T_camera_lidar.error +
                                           (is_given ? "" : " (--pose-frame lidar if they are the LiDAR's)"));
  }
  if (frame == PoseFrame::kUnknown && path.filename() != "odometry.txt" && fs::exists(calib)) {
    return Result<SensorPoses>::fail(
        "it cannot be told whether " + path.string() +
        " holds poses of the camera or of the LiDAR: --pose-frame camera or lidar says it");
  }
  return Result<SensorPoses>::ok({std::move(poses), false});
}

/// One pose per row, for at least all rows up to the last frame.
Result<SensorPoses> framePoses(const KittiOptions& options, const std::vector<NumberedFile>& files) {
  const fs::path path = posesPath(options);
  auto poses = readPoses(path);
  if (!poses) {
    return Result<SensorPoses>::fail(poses.error);
  }
  if (poses->size() <= files.back().number) {
    return Result<SensorPoses>::fail(tooFewRows(path, poses->size(), files.back()));
  }
  return toLidar(std::move(*poses), options, path);
}

std::vector<Micros> evenTimes(std::size_t count, double rate_hz) {
  std::vector<Micros> times(count);
  for (std::size_t i = 0; i < count; ++i) {
    times[i] = std::llround(static_cast<double>(i) * 1e6 / rate_hz);
  }
  return times;
}

/// One time per row, for at least all rows up to the last frame.
Result<std::vector<Micros>> frameTimes(const KittiOptions& options, const std::vector<NumberedFile>& files) {
  const fs::path path = options.dir / "times.txt";
  if (options.rate_hz || !fs::exists(path)) {
    return Result<std::vector<Micros>>::ok(
        evenTimes(files.back().number + 1, options.rate_hz.value_or(kDefaultRateHz)));
  }
  auto times = readTimes(path);
  if (times && times->size() <= files.back().number) {
    return Result<std::vector<Micros>>::fail(tooFewRows(path, times->size(), files.back()));
  }
  return times;
}

/// Checks the files of a frame by their sizes, so that a bad folder fails before anything is written.
std::string checkFiles(const KittiFrame& frame) {
  std::error_code cloud_error, labels_error;
  const std::uintmax_t cloud = fs::file_size(frame.cloud, cloud_error);
  const std::uintmax_t labels = fs::file_size(frame.labels, labels_error);
  if (cloud_error || labels_error) {
    return "cannot read " + (cloud_error ? frame.cloud : frame.labels).string();
  }
  if (cloud % kPointBytes != 0) {
    return frame.cloud.string() + " is cut: " + std::to_string(cloud) + " bytes are not whole points of 16";
  }
  if (labels != cloud / kPointBytes * kLabelBytes) {
    return frame.labels.string() + " holds " + std::to_string(labels / kLabelBytes) + " labels for the " +
           std::to_string(cloud / kPointBytes) + " points of " + frame.cloud.filename().string();
  }
  return "";
}

template <typename T>
std::optional<std::vector<T>> readAll(const fs::path& path, std::size_t count) {
  std::vector<T> values(count);
  std::ifstream in(path, std::ios::binary);
  in.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(count * sizeof(T)));
  return in ? std::optional(std::move(values)) : std::nullopt;
}

/// Turns the point's direction up by an angle given by its cosine and sine; its range stays.
void lift(Point& p, float cosine, float sine) {
  const float across = std::hypot(p.x, p.y);
  const float scale = across > 0 ? (across * cosine - p.z * sine) / across : cosine;
  p.z = p.z * cosine + across * sine;
  p.x *= scale, p.y *= scale;
}

}  // namespace

Result<std::vector<KittiFrame>> listKittiFrames(const KittiOptions& options) {
  using Frames = Result<std::vector<KittiFrame>>;
  const auto files = listClouds(options.dir / "velodyne");
  if (!files) {
    return Frames::fail(files.error);
  }
  const fs::path labels = options.dir / options.labels;
  if (!fs::is_directory(labels)) {
    return Frames::fail("no label folder " + labels.string() + " (--labels chooses another one)");
  }
  const auto poses = framePoses(options, *files);
  const auto times = frameTimes(options, *files);
  if (!poses || !times) {
    return Frames::fail(poses ? times.error : poses.error);
  }
  std::vector<KittiFrame> frames;
  for (const NumberedFile& file : *files) {
    const std::string stem = file.path.stem().string();
    frames.push_back({file.path, labels / (stem + ".label"), (*times)[file.number], poses->T_world_lidar[file.number],
                      poses->were_cameras, options.learning_ids, options.elevation_deg});
    if (const std::string error = checkFiles(frames.back()); !error.empty()) {
      return Frames::fail(error);
    }
    if (frames.size() > 1 && frames.back().utime_us <= frames[frames.size() - 2].utime_us) {
      return Frames::fail("the time of frame " + stem +
                          " in times.txt is not after the one before it (--rate replaces times.txt)");
    }
  }
  return Frames::ok(std::move(frames));
}

Result<std::vector<Point>> readKittiPoints(const KittiFrame& frame) {
  const auto count = static_cast<std::size_t>(fs::file_size(frame.cloud)) / kPointBytes;
  const auto cloud = readAll<float>(frame.cloud, 4 * count);
  const auto words = readAll<std::uint32_t>(frame.labels, count);
  if (!cloud || !words) {
    return Result<std::vector<Point>>::fail("cannot read " + (cloud ? frame.labels : frame.cloud).string());
  }
  const double lift_rad = frame.elevation_deg * std::numbers::pi / 180;
  const auto cosine = static_cast<float>(std::cos(lift_rad)), sine = static_cast<float>(std::sin(lift_rad));
  std::vector<Point> points(count);
  for (std::size_t i = 0; i < count; ++i) {
    const float* xyz = &(*cloud)[4 * i];
    const std::uint32_t word = (*words)[i];
    const auto label = static_cast<ClassId>(word & 0xffff);
    points[i] = {xyz[0], xyz[1], xyz[2], word >> 16, frame.learning_ids ? rawOfLearningId(label) : label};
    lift(points[i], cosine, sine);
  }
  return Result<std::vector<Point>>::ok(std::move(points));
}

std::string convertKitti(const std::vector<KittiFrame>& frames, const fs::path& log, const Progress& progress) {
  auto writer = LogWriter::create(log.string());
  if (!writer) {
    return writer.error;
  }
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto points = readKittiPoints(frames[i]);
    if (!points) {
      return points.error;
    }
    std::string error = writeFrame(*writer, frames[i].utime_us, frames[i].T_world_body, *points);
    if (!error.empty()) {
      return error;
    }
    progress(i + 1, frames.size());
  }
  return writer->close();
}

}  // namespace hgg
