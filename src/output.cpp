#include "output.h"

#include <fmt/format.h>

#include <filesystem>

#include "map/file.h"

namespace hgg {

Result<OutputDirectory> OutputDirectory::open(const std::string& directory) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  OutputDirectory out(directory);
  out.trajectory_.open(out.path("trajectory.tum"), std::ios::trunc);
  if (error || !out.trajectory_) {
    return Result<OutputDirectory>::fail(fmt::format("{}: cannot write into the output directory (--out)", directory));
  }
  return Result<OutputDirectory>::ok(std::move(out));
}

void OutputDirectory::add(const StepReport& report, const FrameTiming& timing, const Map& map) {
  const Eigen::Quaterniond q(report.T_map_body.linear());
  const Vec3 t = report.T_map_body.translation();
  trajectory_ << fmt::format("{}.{:06d} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g}\n", report.utime_us / 1'000'000,
                             report.utime_us % 1'000'000, t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
  stats_.add(timing, map.megabytes());
}

std::string OutputDirectory::finish(const Mapper& mapper, const RunCounters& counters) {
  trajectory_.flush();
  if (!trajectory_) {
    return fmt::format("{}: cannot write the trajectory (disk full?)", path("trajectory.tum"));
  }
  std::ofstream stats(path("stats.json"), std::ios::trunc);
  if (!(stats << stats_.json(counters, mapper.map())) || !stats.flush()) {
    return fmt::format("{}: cannot write the statistics (disk full?)", path("stats.json"));
  }
  return saveMap(mapper.map(), mapper.edges(), path("map.hgg"));
}

}  // namespace hgg
