#include "map/track_assignment.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/position_uncertainty.h"
#include "core/spd.h"
#include "core/units.h"

namespace hgg {
namespace {

// Chosen by hand but for the quantile of chi-square.
/// m^2/s^3: the velocity of a thing wanders by 0.5 m/s in a second, its climb by 0.1 m/s.
constexpr double kAcceleration = 0.25, kClimb = 0.01;
/// One look in a thousand at the right thing is farther off (chi-square of three degrees of freedom).
constexpr double kGate = 16.3;
/// In the logarithm of a likelihood, times minus two: that a track's thing is labelled as another class that can move.
constexpr double kOtherClass = 4;
/// A track of fewer views has just begun.
constexpr int kYoungViews = 3;
/// A solid box is taken to end at two deviations; pieces of what is seen in part may lie farther out.
constexpr double kPieceSigmas = 3;

constexpr double seconds(Micros us) { return 1e-6 * static_cast<double>(us); }

/// Whether a piece at `p` may be of a thing of this extent at `mean`.
bool isInside(const Vec3& p, const Vec3& mean, const Mat3& extent, double margin) {
  const Eigen3 e = eigenSymmetric(extent);
  const Vec3 d = (e.vectors.transpose() * (p - mean)).cwiseAbs();
  return (d.array() < kPieceSigmas * e.values.array().max(0).sqrt() + margin).all();
}

/// A possible pair. Tracks that have lasted choose first: one that has just begun knows so little of its velocity that
/// it would take whatever comes.
struct Option {
  bool is_young;
  double cost;  // its likelihood in logarithm, times minus two
  std::size_t track, seen;
};

}  // namespace

std::vector<Seen> thingsOf(const std::vector<LocalObject>& objects, const Pose& T_map_body, const ClassTable& classes) {
  std::vector<Seen> seen;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const ClassInfo* info = classes.find(objects[i].label);
    if (!objects[i].stuff) {
      seen.push_back({&objects[i], static_cast<int>(i), transform(T_map_body, objects[i].belief),
                      info != nullptr && info->dynamic});
    }
  }
  return seen;
}

Mat3 noiseOfView(const Mat3& extent) {
  return square(kPositionOfView.view_share) * extent + square(kPositionOfView.view_noise) * Mat3::Identity();
}

const Mat3& larger(const Mat3& a, const Mat3& b) { return a.trace() >= b.trace() ? a : b; }

ConstantVelocity expectedAt(const Track& track, const Movers& movers, Micros utime_us) {
  const double dt = seconds(std::max<Micros>(utime_us - movers.utime_us, 0));
  return predict(track.mover.motion, dt, {kAcceleration, kAcceleration, kClimb});
}

void assignTracks(const Movers& movers, Micros utime_us, std::vector<Seen>& seen) {
  std::vector<ConstantVelocity> states;
  std::vector<Option> options;
  for (std::size_t t = 0; t < movers.tracks.size(); ++t) {
    const Track& track = movers.tracks[t];
    states.push_back(expectedAt(track, movers, utime_us));
    for (std::size_t i = 0; i < seen.size(); ++i) {
      if (!seen[i].can_move) {
        continue;
      }
      const Mat3 R = noiseOfView(larger(seen[i].belief.cov, track.extent));
      const Mat3 S = states[t].positionCov() + R;
      if ((seen[i].belief.mean - states[t].position()).squaredNorm() > kGate * S.trace()) {
        continue;
      }
      const double off = innovationSquare(states[t], seen[i].belief.mean, R);
      if (off < kGate) {
        const double other = seen[i].object->label != track.mover.label ? kOtherClass : 0;
        options.push_back({track.mover.views < kYoungViews, off + std::log(S.determinant()) + other, t, i});
      }
    }
  }
  std::ranges::stable_sort(options, {}, [](const Option& option) { return std::pair(option.is_young, option.cost); });
  std::vector<int> object_of(movers.tracks.size(), -1);
  for (const Option& option : options) {
    if (seen[option.seen].track < 0 && object_of[option.track] < 0) {
      seen[option.seen].track = static_cast<int>(option.track);
      object_of[option.track] = static_cast<int>(option.seen);
    }
  }
  for (Seen& piece : seen) {
    for (std::size_t t = 0; piece.track < 0 && t < movers.tracks.size(); ++t) {
      const Track& track = movers.tracks[t];
      const bool is_mover = track.mover.id != 0;
      if ((!is_mover && (object_of[t] < 0 || !piece.can_move)) || piece.belief.cov.trace() > track.extent.trace()) {
        continue;
      }
      if (isInside(piece.belief.mean, states[t].position(), track.extent, kPositionOfView.view_noise)) {
        piece.track = static_cast<int>(t);
      }
    }
  }
}

std::vector<LocalObject> takeOut(LocalGraph& local, std::vector<ObjectPair>& pairs, const std::vector<bool>& marked) {
  std::vector<LocalObject> taken, kept;
  if (std::ranges::find(marked, true) == marked.end()) {
    return taken;
  }
  std::vector<int> index_of(marked.size(), -1);
  for (std::size_t i = 0; i < marked.size(); ++i) {
    if (!marked[i]) {
      index_of[i] = static_cast<int>(kept.size());
    }
    (marked[i] ? taken : kept).push_back(std::move(local.objects[i]));
  }
  local.objects = std::move(kept);
  const auto newIndex = [&](int i) { return index_of[static_cast<std::size_t>(i)]; };
  std::erase_if(local.edges, [&](const auto& edge) { return newIndex(edge.first) < 0 || newIndex(edge.second) < 0; });
  for (auto& [a, b] : local.edges) {
    a = newIndex(a), b = newIndex(b);
  }
  std::erase_if(pairs, [&](const ObjectPair& pair) { return newIndex(pair.local) < 0; });
  for (ObjectPair& pair : pairs) {
    pair.local = newIndex(pair.local);
  }
  return taken;
}

}  // namespace hgg
