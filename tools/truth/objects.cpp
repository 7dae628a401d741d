#include "truth/objects.h"

#include <array>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <system_error>

#include "truth/poses.h"

namespace hgg {
namespace {

using nlohmann::json;
using RowMat3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

constexpr const char *kObjects = "gt_objects.json", *kPoses = "poses.txt", *kCloud = "cloud.ply",
                     *kQueries = "queries.jsonl", *kClasses = "classes.toml", *kRooms = "rooms.json";

std::string writeFile(const std::string& text, const std::filesystem::path& path) {
  std::ofstream out(path, std::ios::binary);
  out << text;
  out.close();
  return out ? "" : "cannot write " + path.string();
}

std::string makeDirectory(const std::filesystem::path& dir) {
  std::error_code error;
  std::filesystem::create_directories(dir, error);
  return error ? "cannot create " + dir.string() + ": " + error.message() : "";
}

json toJson(const TruthObject& object) {
  const RowMat3 cov = object.belief.cov;
  json entry = {{"id", object.id},
                {"label", object.label},
                {"dynamic", object.dynamic},
                {"points", static_cast<std::int64_t>(object.belief.kappa)},
                {"frames", object.frames},
                {"centroid", std::vector<double>(object.belief.mean.begin(), object.belief.mean.end())},
                {"covariance", std::vector<double>(cov.data(), cov.data() + 9)}};
  if (object.gone) {
    entry["gone"] = true;
  }
  for (const Vec3& p : object.dynamic ? object.track : std::vector<Vec3>()) {
    constexpr double kDigits = 1000;  // mm
    const Vec3 rounded = (p * kDigits).array().round() / kDigits;
    entry["track"].push_back(std::vector<double>(rounded.begin(), rounded.end()));
  }
  if (object.dynamic && !object.track_points.empty()) {
    entry["track_points"] = object.track_points;
    entry["track_frames"] = object.track_frames;
  }
  return entry;
}

TruthObject fromJson(const json& entry) {
  const auto centroid = entry.at("centroid").get<std::array<double, 3>>();
  const auto covariance = entry.at("covariance").get<std::array<double, 9>>();
  TruthObject object;
  object.id = entry.at("id").get<std::int64_t>();
  object.label = entry.at("label").get<ClassId>();
  object.dynamic = entry.at("dynamic").get<bool>();
  object.gone = entry.value("gone", false);
  object.frames = entry.at("frames").get<std::int64_t>();
  for (const json& p : entry.value("track", json::array())) {
    object.track.emplace_back(p.get<std::array<double, 3>>().data());
  }
  object.track_points = entry.value("track_points", std::vector<std::int64_t>());
  object.track_frames = entry.value("track_frames", std::vector<std::int64_t>());
  object.belief.kappa = entry.at("points").get<double>();
  object.belief.mean = Vec3(centroid.data());
  object.belief.cov = Eigen::Map<const RowMat3>(covariance.data());
  return object;
}

}  // namespace

void TruthAccumulator::add(std::int64_t id, ClassId label, std::size_t frame, const Vec3& p_map) {
  // The first point is the origin of the sums: large coordinates keep their digits.
  Entry& entry = entries_.try_emplace(id, Entry{label, Moments(p_map)}).first->second;
  if (entry.frames == 0 || entry.last_frame != frame) {
    ++entry.frames;
    entry.sums.push_back(Vec3::Zero());
    entry.counts.push_back(0);
    entry.which.push_back(static_cast<std::int64_t>(frame));
  }
  entry.last_frame = frame;
  entry.sums.back() += p_map;
  entry.counts.back() += 1;
  entry.moments.add(p_map.x(), p_map.y(), p_map.z());
}

std::vector<TruthObject> TruthAccumulator::objects() const {
  std::vector<TruthObject> objects;
  for (const auto& [id, entry] : entries_) {
    objects.push_back({.id = id, .label = entry.label, .frames = entry.frames, .belief = entry.moments.belief()});
    for (std::size_t i = 0; i < entry.sums.size(); ++i) {
      objects.back().track.emplace_back(entry.sums[i] / entry.counts[i]);
      objects.back().track_points.push_back(static_cast<std::int64_t>(entry.counts[i]));
    }
    objects.back().track_frames = entry.which;
  }
  return objects;
}

Result<std::vector<TruthObject>> readTruthObjects(const std::filesystem::path& path) {
  using Objects = Result<std::vector<TruthObject>>;
  std::ifstream in(path);
  if (!in) {
    return Objects::fail("cannot read " + path.string());
  }
  try {
    std::vector<TruthObject> objects;
    std::set<std::int64_t> ids;
    for (const json& entry : json::parse(in)) {
      objects.push_back(fromJson(entry));
      if (!ids.insert(objects.back().id).second) {
        return Objects::fail(path.string() + ": object " + std::to_string(objects.back().id) +
                             ": this id appears twice");
      }
    }
    return Objects::ok(std::move(objects));
  } catch (const json::exception& e) {
    return Objects::fail(path.string() + " is not a list of truth objects: " + e.what());
  }
}

std::string writeTruthObjects(const std::vector<TruthObject>& objects, const std::filesystem::path& path) {
  std::ofstream out(path);
  out << "[";
  for (std::size_t i = 0; i < objects.size(); ++i) {
    out << (i == 0 ? "\n" : ",\n") << toJson(objects[i]).dump();
  }
  out << "\n]\n";
  out.close();
  return out ? "" : "cannot write " + path.string();
}

std::string writeTruth(const std::vector<TruthObject>& objects, const std::vector<Pose>& T_map_body,
                       const std::filesystem::path& dir) {
  std::string dir_error = makeDirectory(dir);
  if (!dir_error.empty()) {
    return dir_error;
  }
  const std::string objects_error = writeTruthObjects(objects, dir / kObjects);
  return objects_error.empty() ? writePoses(T_map_body, dir / kPoses) : objects_error;
}

std::string prepareTruth(const std::filesystem::path& dir) {
  std::string message = makeDirectory(dir);
  std::vector<std::string> names = walkGridFiles();
  names.insert(names.end(), {kObjects, kPoses, kCloud, kQueries, kClasses, kRooms});
  for (const std::string& name : names) {
    std::error_code error;
    std::filesystem::remove(dir / name, error);
    if (message.empty() && error) {
      message = "cannot remove " + (dir / name).string() + ": " + error.message();
    }
  }
  if (!message.empty()) {
    return message;
  }
  const bool is_writable = std::ofstream(dir / kPoses).good();
  std::error_code none;
  std::filesystem::remove(dir / kPoses, none);
  return is_writable ? "" : "cannot write into " + dir.string();
}

std::string writeTruth(const WorldTruth& truth, const std::filesystem::path& dir) {
  std::string error = writeTruth(truth.objects, truth.T_map_body, dir);
  error = error.empty() ? writeCloud(truth.cloud, dir / kCloud) : error;
  error = error.empty() ? writeQueries(truth.queries, dir / kQueries) : error;
  error = error.empty() ? writeFile(truth.classes_toml, dir / kClasses) : error;
  error = error.empty() && !truth.rooms.rooms.empty() ? writeRooms(truth.rooms, dir / kRooms) : error;
  return error.empty() && truth.walk_grid ? writeWalkGrid(*truth.walk_grid, dir) : error;
}

}  // namespace hgg
