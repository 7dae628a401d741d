#include "output.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cstdio>
#include <filesystem>

#include "core/text.h"
#include "leftovers.h"
#include "map/file.h"

namespace hgg {
namespace {

/// What was said of a pose when it was published.
std::string statusWord(const StepReport& report) {
  if (report.tracking == Tracking::kLost || report.fragment != 0) {
    return "lost";
  }
  if (report.tracking != Tracking::kHeld) {
    return nameOf(report.tracking);
  }
  return report.odometry_fault != OdometryFault::kNone ? codeOf(report.odometry_fault) : nameOf(report.source);
}

}  // namespace

std::string poseText(const Pose& T) {
  const Eigen::Quaterniond q(T.linear());
  const Vec3 t = T.translation();
  return fmt::format("{:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g}", t.x(), t.y(), t.z(), q.x(), q.y(), q.z(),
                     q.w());
}

Result<OutputDirectory> OutputDirectory::open(const std::string& directory, bool is_resumed) {
  using Opened = Result<OutputDirectory>;
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  Result<DirectoryLock> lock = DirectoryLock::take(directory);
  if (!lock) {
    return Opened::fail(lock.error);
  }
  const Result<std::string> kept = keepLeftovers(directory, is_resumed);
  if (!kept) {
    return Opened::fail(kept.error);
  }
  if (!kept->empty()) {
    spdlog::warn("{}", *kept);
  }
  OutputDirectory out(directory, std::move(*lock));
  out.trajectory_.open(out.path(kTrajectoryPart), std::ios::trunc);
  out.live_.open(out.path(kLivePart), std::ios::trunc);
  if (error || !out.trajectory_ || !out.live_) {
    return Opened::fail(fmt::format("{}: cannot write into the output directory (--out)", directory));
  }
  return Opened::ok(std::move(out));
}

void OutputDirectory::add(const StepReport& report, const FrameTiming& timing, const Map& map) {
  trajectory_ << fmt::format("{}.{:06d} {} {} {}\n", report.utime_us / 1'000'000, report.utime_us % 1'000'000,
                             poseText(report.T_map_body), report.keyframe, poseText(report.T_keyframe_body));
  live_ << fmt::format("{}.{:06d} {} {}\n", report.utime_us / 1'000'000, report.utime_us % 1'000'000,
                       poseText(report.T_map_body), statusWord(report));
  stats_.add(report);
  stats_.add(timing, map.megabytes());
}

void OutputDirectory::discard() {
  trajectory_.close();
  std::remove(path(kTrajectoryPart).c_str());
  std::remove(path(kLivePart).c_str());
}

std::string OutputDirectory::finish(const Mapper& mapper, const RunCounts& counts) {
  // The map first: it is what the drive was for.
  std::vector<std::string> errors{saveMap(mapper.map(), path("map.hgg"))};
  if (errors.front().empty()) {
    std::remove(path(kSnapshotFile).c_str());
  }
  trajectory_.close();
  const std::string part = path(kTrajectoryPart), corrected = path("trajectory.tum.tmp");
  if (trajectory_ && correctTrajectory(part, corrected, mapper.map().keyframes(), false) &&
      std::rename(corrected.c_str(), path("trajectory.tum").c_str()) == 0) {
    std::remove(part.c_str());
  } else {
    std::remove(corrected.c_str());
    errors.push_back(fmt::format("{}: cannot write the trajectory (disk full?)", path("trajectory.tum")));
  }
  live_.close();
  if (!live_ || std::rename(path(kLivePart).c_str(), path("live.tum").c_str()) != 0) {
    errors.push_back(fmt::format("{}: cannot write the published poses (disk full?)", path("live.tum")));
  }
  std::ofstream stats(path("stats.json"), std::ios::trunc);
  if (!(stats << stats_.json(counts, mapper.map(), mapper.loops())) || !stats.flush()) {
    errors.push_back(fmt::format("{}: cannot write the statistics (disk full?)", path("stats.json")));
  }
  std::erase(errors, "");
  return join(errors, "\n");
}

}  // namespace hgg
