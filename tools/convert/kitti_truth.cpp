#include "convert/kitti_truth.h"

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>
#include <unordered_map>

#include "core/classes.h"

namespace hgg {
namespace {

constexpr double kMovedDistance = 1.0;
constexpr ClassId kFirstMovingLabel = 252, kLastMovingLabel = 259;

using Box2 = Eigen::AlignedBox2d;

/// Where an object's points were, seen from above.
struct Spread {
  Box2 all, frame;
  std::size_t frame_index = 0;
  double largest_frame = 0;
  bool moving_label = false;

  void add(std::size_t index, const Vec3& p_world) {
    if (index != frame_index) {
      closeFrame();
      frame_index = index;
    }
    frame.extend(p_world.head<2>());
    all.extend(p_world.head<2>());
  }
  void closeFrame() {
    largest_frame = std::max(largest_frame, frame.isEmpty() ? 0.0 : frame.diagonal().norm());
    frame.setEmpty();
  }
  double excess() {
    closeFrame();
    return all.diagonal().norm() - largest_frame;
  }
};

std::int64_t objectId(ClassId label, std::uint32_t instance) { return label * std::int64_t{100000} + instance; }

std::vector<std::string> splitCsv(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream in(line);
  for (std::string cell; std::getline(in, cell, ',');) {
    cells.push_back(cell.ends_with('\r') ? cell.substr(0, cell.size() - 1) : cell);
  }
  return cells;
}

std::optional<double> cellNumber(const std::vector<std::string>& cells, std::ptrdiff_t column) {
  if (column >= std::ssize(cells)) {
    return std::nullopt;
  }
  std::istringstream in(cells[static_cast<std::size_t>(column)]);
  double value = 0;
  return in >> value ? std::optional(value) : std::nullopt;
}

/// Instances whose box centre moves further than kMovedDistance from where it was first.
Result<std::set<std::uint32_t>> movedTracks(const std::filesystem::path& path) {
  using Moved = Result<std::set<std::uint32_t>>;
  std::ifstream in(path);
  std::string line;
  if (!std::getline(in, line)) {
    return Moved::fail("cannot read " + path.string());
  }
  const std::vector<std::string> header = splitCsv(line);
  const auto column = [&](const char* name) { return std::ranges::find(header, name) - header.begin(); };
  const auto track_column = column("track_id"), x_column = column("cx_world"), y_column = column("cy_world");
  std::unordered_map<std::uint32_t, Eigen::Vector2d> first;
  std::set<std::uint32_t> moved;
  for (std::size_t number = 2; std::getline(in, line); ++number) {
    const auto cells = splitCsv(line);
    const auto track = cellNumber(cells, track_column), x = cellNumber(cells, x_column),
               y = cellNumber(cells, y_column);
    if (!track || !x || !y) {
      return Moved::fail(path.string() + " line " + std::to_string(number) + ": no track_id, cx_world, cy_world");
    }
    const auto id = static_cast<std::uint32_t>(*track);
    const Eigen::Vector2d centre(*x, *y);
    if ((first.try_emplace(id, centre).first->second - centre).norm() > kMovedDistance) {
      moved.insert(id);
    }
  }
  return Moved::ok(std::move(moved));
}

/// What the frames show of every instance.
struct Observations {
  TruthAccumulator truth;
  std::map<std::int64_t, Spread> spreads;

  void add(std::size_t index, const Point& p, const Pose& T_world_body, const ClassTable& classes) {
    const ClassInfo* folded = classes.find(p.label);
    const ClassId label = folded == nullptr ? p.label : folded->id;
    const std::int64_t id = objectId(label, p.instance);
    const Vec3 p_world = T_world_body * Vec3(p.x, p.y, p.z);
    truth.add(id, label, index, p_world);
    Spread& spread = spreads[id];
    spread.add(index, p_world);
    spread.moving_label |= p.label >= kFirstMovingLabel && p.label <= kLastMovingLabel;
  }
};

Result<Observations> observe(const std::vector<KittiFrame>& frames, const Progress& progress) {
  const ClassTable classes = ClassTable::builtin();
  Observations seen;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto points = readKittiPoints(frames[i]);
    if (!points) {
      return Result<Observations>::fail(points.error);
    }
    for (const Point& p : *points) {
      if (p.instance != 0) {
        seen.add(i, p, frames[i].T_world_body, classes);
      }
    }
    progress(i + 1, frames.size());
  }
  return Result<Observations>::ok(std::move(seen));
}

}  // namespace

Result<std::vector<TruthObject>> kittiTruth(const std::vector<KittiFrame>& frames,
                                            const std::optional<std::filesystem::path>& boxes,
                                            const Progress& progress) {
  using Objects = Result<std::vector<TruthObject>>;
  const auto moved = boxes ? movedTracks(*boxes) : Result<std::set<std::uint32_t>>::ok({});
  auto seen = moved ? observe(frames, progress) : Result<Observations>::fail(moved.error);
  if (!seen) {
    return Objects::fail(seen.error);
  }
  std::vector<TruthObject> objects = seen->truth.objects();
  for (TruthObject& object : objects) {
    Spread& spread = seen->spreads[object.id];
    const auto instance = static_cast<std::uint32_t>(object.id - objectId(object.label, 0));
    const bool has_moved = boxes ? moved->contains(instance) : spread.excess() > kMovedDistance;
    object.dynamic = spread.moving_label || has_moved;
  }
  return Objects::ok(std::move(objects));
}

}  // namespace hgg
