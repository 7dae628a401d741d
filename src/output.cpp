#include "output.h"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>

#include "core/text.h"
#include "map/file.h"

namespace hgg {
namespace {

/// The trajectory while it grows; an earlier run's stays whole until this one ends.
constexpr char kTrajectoryPart[] = "trajectory.tum.part";

}  // namespace

Result<OutputDirectory> OutputDirectory::open(const std::string& directory) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  OutputDirectory out(directory);
  out.trajectory_.open(out.path(kTrajectoryPart), std::ios::trunc);
  if (error || !out.trajectory_) {
    return Result<OutputDirectory>::fail(fmt::format("{}: cannot write into the output directory (--out)", directory));
  }
  return Result<OutputDirectory>::ok(std::move(out));
}

void OutputDirectory::add(const StepReport& report, const FrameTiming& timing, const Map& map) {
  const Eigen::Quaterniond q(report.T_map_body.linear());
  const Vec3 t = report.T_map_body.translation();
  trajectory_ << fmt::format("{}.{:06d} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g}\n",
                             report.utime_us / 1'000'000, report.utime_us % 1'000'000, t.x(), t.y(), t.z(), q.x(),
                             q.y(), q.z(), q.w());
  stats_.add(timing, map.megabytes());
}

std::string OutputDirectory::finish(const Mapper& mapper, const RunCounters& counters) {
  // The map first: it is what the drive was for.
  std::vector<std::string> errors{saveMap(mapper.map(), mapper.edges(), path("map.hgg"))};
  trajectory_.close();
  if (!trajectory_ || std::rename(path(kTrajectoryPart).c_str(), path("trajectory.tum").c_str()) != 0) {
    errors.push_back(fmt::format("{}: cannot write the trajectory (disk full?)", path("trajectory.tum")));
  }
  std::ofstream stats(path("stats.json"), std::ios::trunc);
  if (!(stats << stats_.json(counters, mapper.map())) || !stats.flush()) {
    errors.push_back(fmt::format("{}: cannot write the statistics (disk full?)", path("stats.json")));
  }
  std::erase(errors, "");
  return join(errors, "\n");
}

}  // namespace hgg
