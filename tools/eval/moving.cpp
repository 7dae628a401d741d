#include <algorithm>
#include <array>
#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "core/units.h"
#include "eval/ghosts.h"

namespace hgg {
namespace {

using nlohmann::json;

constexpr double kOnThing = 2.0;         // deviations of its points: an even line or face ends at 1.73
constexpr double kSlackShare = 1.0 / 6;  // of the radius

/// The place of a track nearest to `p`, seen from above, and how far off it is.
std::pair<std::size_t, double> nearestOn(const std::vector<Vec3>& track, const Vec3& p) {
  std::pair<std::size_t, double> nearest{0, std::numeric_limits<double>::infinity()};
  for (std::size_t i = 0; i < track.size(); ++i) {
    const double off = (track[i] - p).head<2>().norm();
    nearest = off < nearest.second ? std::pair(i, off) : nearest;
  }
  return nearest;
}

/// The index into the true track that place number k of the told one belongs to, and how far apart they are.
std::pair<std::size_t, double> partnerOf(const TruthObject& mover, const ToldMover& told, std::size_t k) {
  const auto& frames = mover.track_frames;
  if (told.frames.empty() || frames.size() != mover.track.size()) {
    return nearestOn(mover.track, told.places[k]);
  }
  const auto at = std::ranges::lower_bound(frames, told.frames[k]);
  const auto i = static_cast<std::size_t>(at - frames.begin());
  const bool is_seen = at != frames.end() && *at == told.frames[k];
  return {i, is_seen ? (mover.track[i] - told.places[k]).head<2>().norm() : std::numeric_limits<double>::infinity()};
}

bool isOn(const TruthObject& thing, const Vec3& p, double radius) {
  const Mat3 cov = thing.belief.cov + square(kSlackShare * radius) * Mat3::Identity();
  const Vec3 off = p - thing.belief.mean;
  return off.dot(cov.inverse() * off) < square(kOnThing);
}

/// The true object of the track's class that most of its places are on; nullptr: none.
const TruthObject* thingOf(const ToldMover& told, std::span<const TruthObject> truth, double radius) {
  const TruthObject* best = nullptr;
  std::size_t most = told.places.size() / 2;
  for (const TruthObject& object : truth) {
    std::size_t on = 0;
    for (std::size_t k = 0; object.label == told.label && k < told.places.size(); ++k) {
      const bool is_on =
          object.dynamic ? partnerOf(object, told, k).second < radius : isOn(object, told.places[k], radius);
      on += is_on ? 1 : 0;
    }
    if (on > most) {
      most = on;
      best = &object;
    }
  }
  return best;
}

/// Index into its track of the frame that is the kSeenFrames-th to see it; nothing where there are fewer.
std::optional<std::size_t> lastInTime(const TruthObject& object) {
  std::int64_t seen = 0;
  for (std::size_t i = 0; i < object.track.size(); ++i) {
    seen += i >= object.track_points.size() || object.track_points[i] >= kSeenPoints ? 1 : 0;
    if (seen == kSeenFrames) {
      return i;
    }
  }
  return std::nullopt;
}

}  // namespace

MovingScore scoreMoving(std::span<const ToldMover> told, std::span<const TruthObject> truth, double radius) {
  MovingScore score;
  std::map<std::int64_t, std::size_t> first;  // index into the true track, by the object's id
  for (const ToldMover& mover : told) {
    const TruthObject* thing = mover.places.empty() ? nullptr : thingOf(mover, truth, radius);
    if (thing != nullptr && thing->dynamic) {
      const std::size_t at = partnerOf(*thing, mover, 0).first;
      const auto known = first.try_emplace(thing->id, at).first;
      known->second = std::min(known->second, at);
    } else {
      (thing != nullptr ? score.parked : score.elsewhere).push_back(mover.id);
    }
  }
  score.soon = 0;
  for (const TruthObject& object : truth) {
    const auto last = object.dynamic ? lastInTime(object) : std::nullopt;
    const auto at = first.find(object.id);
    score.truth += last ? 1 : 0;
    score.said += last && at != first.end() ? 1 : 0;
    *score.soon += last && at != first.end() && at->second <= *last ? 1 : 0;
  }
  return score;
}

Result<std::vector<ToldMover>> readMoving(const std::filesystem::path& path) {
  using Told = Result<std::vector<ToldMover>>;
  std::ifstream in(path);
  if (!in) {
    return Told::fail("cannot read " + path.string());
  }
  std::map<NodeId, ToldMover> movers;
  std::string line;
  try {
    while (std::getline(in, line)) {
      const json entry = json::parse(line);
      ToldMover& mover = movers[entry.at("id").get<NodeId>()];
      mover.id = entry.at("id").get<NodeId>();
      mover.label = entry.at("label").get<ClassId>();
      mover.places.emplace_back(entry.at("position").get<std::array<double, 3>>().data());
      mover.times_us.push_back(entry.at("utime").get<Micros>());
    }
  } catch (const json::exception& e) {
    return Told::fail(path.string() + " is not what hggmap writes of what moves: " + e.what());
  }
  std::vector<ToldMover> all;
  for (auto& [id, mover] : movers) {
    all.push_back(std::move(mover));
  }
  return Told::ok(std::move(all));
}

}  // namespace hgg
