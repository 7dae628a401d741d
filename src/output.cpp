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

constexpr char kMovingPart[] = "moving.jsonl.part";

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

std::string listOf(const double* values, int number) {
  std::string text;
  for (int k = 0; k < number; ++k) {
    text += fmt::format("{}{:.6g}", k == 0 ? '[' : ',', values[k]);
  }
  return text + "]";
}

/// A line of moving.jsonl: where a mover is at a frame that sees it, as it was published.
std::string lineOf(const Mover& mover) {
  const Vec3 p = mover.motion.position(), v = mover.motion.velocity();
  const Mat3 extent = mover.belief.cov, velocity_cov = mover.motion.velocityCov();
  return fmt::format(
      R"({{"utime":{},"id":{},"label":{},"first_us":{},"views":{},"position":{},"velocity":{},"velocity_cov":{},"cov":{}}})",
      mover.last_us, mover.id, mover.label, mover.first_us, mover.views, listOf(p.data(), 3), listOf(v.data(), 3),
      listOf(velocity_cov.data(), 9), listOf(extent.data(), 9));
}

/// Puts a file that has grown in its place; an error line, empty when done.
std::string settle(std::ofstream& file, const std::string& part, const std::string& path, const char* what) {
  file.close();
  const bool is_good = file && std::rename(part.c_str(), path.c_str()) == 0;
  return is_good ? "" : fmt::format("{}: cannot write {} (disk full?)", path, what);
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
  out.moving_.open(out.path(kMovingPart), std::ios::trunc);
  if (error || !out.trajectory_ || !out.live_ || !out.moving_) {
    return Opened::fail(fmt::format("{}: cannot write into the output directory (--out)", directory));
  }
  return Opened::ok(std::move(out));
}

void OutputDirectory::add(const StepReport& report, const FrameTiming& timing, const Map& map) {
  trajectory_ << fmt::format("{}.{:06d} {} {} {}\n", report.utime_us / 1'000'000, report.utime_us % 1'000'000,
                             poseText(report.T_map_body), report.keyframe, poseText(report.T_keyframe_body));
  live_ << fmt::format("{}.{:06d} {} {}\n", report.utime_us / 1'000'000, report.utime_us % 1'000'000,
                       poseText(report.T_map_body), statusWord(report));
  for (const Mover& mover : report.moving) {
    if (mover.last_us == report.utime_us) {
      moving_ << lineOf(mover) << '\n';
    }
  }
  // A run that is killed keeps its way: lines that wait in memory would be lost with it.
  trajectory_.flush();
  live_.flush();
  moving_.flush();
  stats_.add(report);
  stats_.add(timing, map.megabytes());
}

void OutputDirectory::discard() {
  trajectory_.close();
  std::remove(path(kTrajectoryPart).c_str());
  std::remove(path(kLivePart).c_str());
  std::remove(path(kMovingPart).c_str());
}

std::string OutputDirectory::finish(const Mapper& mapper, const RunCounts& counts) {
  // The map first: it is what the drive was for.
  std::vector<std::string> errors{saveMap(mapper.map(), path("map.hgg"), mapper.pageReader())};
  trajectory_.close();
  const std::string part = path(kTrajectoryPart), corrected = path("trajectory.tum.tmp");
  if (trajectory_ && correctTrajectory(part, corrected, mapper.map().keyframes(), false) &&
      std::rename(corrected.c_str(), path("trajectory.tum").c_str()) == 0) {
    std::remove(part.c_str());
  } else {
    std::remove(corrected.c_str());
    errors.push_back(fmt::format("{}: cannot write the trajectory (disk full?)", path("trajectory.tum")));
  }
  errors.push_back(settle(live_, path(kLivePart), path("live.tum"), "the published poses"));
  errors.push_back(settle(moving_, path(kMovingPart), path("moving.jsonl"), "what moved"));
  std::ofstream stats(path("stats.json"), std::ios::trunc);
  if (!(stats << stats_.json(counts, mapper.map(), mapper.loops())) || !stats.flush()) {
    errors.push_back(fmt::format("{}: cannot write the statistics (disk full?)", path("stats.json")));
  }
  std::erase(errors, "");
  return join(errors, "\n");
}

}  // namespace hgg
