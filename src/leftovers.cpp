#include "leftovers.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "core/text.h"
#include "map/file.h"
#include "map/map_store.h"
#include "output.h"

namespace hgg {
namespace {

namespace fs = std::filesystem;

/// Maps of killed runs that one directory holds at most: so many say that something is wrong.
constexpr int kMostRecovered = 20;

Pose readPose(std::istream& in) {
  Eigen::Quaterniond q;
  Vec3 t;
  in >> t.x() >> t.y() >> t.z() >> q.x() >> q.y() >> q.z() >> q.w();
  Pose T = Pose::Identity();
  T.linear() = q.normalized().toRotationMatrix();
  T.translation() = t;
  return T;
}

/// Removes what a killed save was writing.
void removeTemporaries(const std::string& directory) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(directory, error)) {
    const std::string name = entry.path().filename().string();
    const bool is_ours =
        name.starts_with("map.hgg.") || name.starts_with("recovered") || name.starts_with("trajectory.tum.");
    if (is_ours && name.ends_with(".tmp")) {
      fs::remove(entry.path(), error);
    }
  }
}

/// recovered, recovered-2, ...: the first that nothing has; empty when all are taken.
std::string freeName(const std::string& directory) {
  for (int k = 1; k <= kMostRecovered; ++k) {
    std::string name = directory + (k == 1 ? "/recovered" : fmt::format("/recovered-{}", k));
    if (!fs::exists(name + ".hgg") && !fs::exists(name + ".tum") && !fs::exists(name + ".db")) {
      return name;
    }
  }
  return {};
}

}  // namespace

bool correctTrajectory(const std::string& part, const std::string& corrected, const KeyframeGraph& keyframes,
                       bool is_cut) {
  std::ifstream in(part);
  std::ofstream out(corrected, std::ios::trunc);
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string time;
    KeyframeId keyframe = -1;
    words >> time;
    readPose(words);
    words >> keyframe;
    const Pose T_keyframe_body = readPose(words);
    if (!words || keyframe < 0 || keyframe > keyframes.last()) {
      if (is_cut) {
        continue;
      }
      return false;
    }
    const Pose& T_map_keyframe = keyframes.poses()[static_cast<std::size_t>(keyframe)].T_map_body;
    out << time << ' ' << poseText(T_map_keyframe * T_keyframe_body) << '\n';
  }
  return in.eof() && out.flush().good();
}

Result<std::string> keepLeftovers(const std::string& directory, bool is_resumed) {
  using Kept = Result<std::string>;
  removeTemporaries(directory);
  const std::string journal = fmt::format("{}/{}", directory, kJournalFile);
  if (!fs::exists(journal) || isEmptyMapStore(journal)) {
    removeMapStore(journal);
    return Kept::ok({});
  }
  const std::string name = freeName(directory);
  if (name.empty()) {
    return Kept::fail(fmt::format("{}: {} runs that were killed left recovered*.hgg and .tum here; move them away",
                                  directory, kMostRecovered));
  }
  const Result<StoredMap> stored = loadMap(journal);
  if (stored) {
    correctTrajectory(fmt::format("{}/{}", directory, kTrajectoryPart), name + ".tum", stored->map.keyframes(), true);
  }
  if (is_resumed) {
    return Kept::ok(fmt::format("an earlier run into {} was killed: going on from what it had mapped", directory));
  }
  const std::string error = stored ? saveMap(stored->map, name + ".hgg") : moveMapStore(journal, name + ".db");
  if (!error.empty()) {
    return Kept::fail(fmt::format("what a killed run left in {} cannot be kept: {}", journal, error));
  }
  removeMapStore(journal);
  return Kept::ok(fmt::format("an earlier run into {} was killed: what it had mapped is kept as {}", directory,
                              stored ? fmt::format("{}.hgg ({} nodes)", name, stored->map.nodes().size())
                                     : fmt::format("{}.db, damaged: {}", name, stored.error)));
}

std::string lastMapIn(const std::string& directory) {
  std::string journal = fmt::format("{}/{}", directory, kJournalFile), map = directory + "/map.hgg";
  if (fs::exists(journal) && !isEmptyMapStore(journal)) {
    return journal;
  }
  return fs::exists(map) ? map : std::string();
}

}  // namespace hgg
