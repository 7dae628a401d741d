#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/belief.h"
#include "core/result.h"
#include "truth/cloud.h"
#include "truth/queries.h"
#include "truth/rooms.h"
#include "truth/walk_grid.h"

namespace hgg {

/// A true object: all of its points that the sensor saw, placed with the true poses (map frame). `belief.kappa` =
/// points.
struct TruthObject {
  std::int64_t id = 0;
  ClassId label = 0;
  bool dynamic = false;     // moved while it was seen: no single true position
  bool gone = false;        // taken away before the end: a map may keep it or not
  std::int64_t frames = 0;  // frames with at least one of its points
  Belief belief = {};
  std::vector<Vec3> track = {};  // the middle of its points in each of those frames; kept in files of dynamic ones
  std::vector<std::int64_t> track_points = {};  // how many these were; empty: not known
  std::vector<std::int64_t> track_frames = {};  // which frames these were, ascending, from 0 on; empty: not known
};

/// Collects the points of each object over the frames.
class TruthAccumulator {
 public:
  /// Adds a point of object `id` seen in frame `frame`; frames come in ascending order.
  void add(std::int64_t id, ClassId label, std::size_t frame, const Vec3& p_map);
  /// The objects by ascending id, none of them dynamic.
  std::vector<TruthObject> objects() const;

 private:
  struct Entry {
    ClassId label;
    Moments moments;
    std::int64_t frames = 0;
    std::size_t last_frame = 0;
    std::vector<Vec3> sums = {};  // of its points, by frame
    std::vector<double> counts = {};
    std::vector<std::int64_t> which = {};
  };
  std::map<std::int64_t, Entry> entries_;
};

/// gt_objects.json: a list of {"id","label","dynamic","points","frames","centroid":[3],"covariance":[9 row-major]}, and
/// "gone":true, and "track":[[3],...] with "track_points":[...]
/// and "track_frames":[...], where that is so. An id that appears twice is an
/// error.
Result<std::vector<TruthObject>> readTruthObjects(const std::filesystem::path& path);
/// Returns an error line, empty when done.
std::string writeTruthObjects(const std::vector<TruthObject>& objects, const std::filesystem::path& path);

/// What is true of a drive through a made-up world. Map frame = the first pose's.
struct WorldTruth {
  std::vector<TruthObject> objects;
  std::vector<Pose> T_map_body;
  std::vector<CloudPoint> cloud;
  std::vector<TruthQuery> queries;
  std::string classes_toml;  // the class table the labels are of
  std::optional<WalkGrid> walk_grid = std::nullopt;
  TruthRooms rooms = {};
};
/// Makes the directory where it is missing, checks that files can be written there, and removes an older truth, so that
/// it never stands beside what a later run leaves behind. Returns an error line, empty when done.
std::string prepareTruth(const std::filesystem::path& dir);
/// Writes a truth directory (created when missing): gt_objects.json, poses.txt, cloud.ply, queries.jsonl,
/// classes.toml, and the walk grid and rooms.json where there are any. Returns an error line, empty when done.
std::string writeTruth(const WorldTruth& truth, const std::filesystem::path& dir);
/// The part a dataset has: gt_objects.json and poses.txt.
std::string writeTruth(const std::vector<TruthObject>& objects, const std::vector<Pose>& T_map_body,
                       const std::filesystem::path& dir);

}  // namespace hgg
