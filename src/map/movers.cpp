#include "map/movers.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/position_uncertainty.h"
#include "core/spd.h"
#include "core/units.h"
#include "map/sight.h"
#include "map/track_assignment.h"

namespace hgg {
namespace {

// Chosen by hand but for the quantiles of chi-square.
/// m/s, standard deviation of the velocity of what was seen once: cars in towns.
constexpr double kFirstSpeed = 5, kFirstClimb = 0.5;
/// One thing in a hundred that stands seems to move as much (chi-square of two degrees of freedom).
constexpr double kMoves = 9.21;
/// m/s: what is slower counts as standing, whatever its covariance says.
constexpr double kSlowest = 0.3;
/// Looks in a row that make a mover, and how much of the views they must see.
constexpr int kVotes = 3;
constexpr double kSeenThrough = 0.3;
/// Where looks tell nothing, as before the open sky: so many views, so many own lengths within the looks that are kept,
/// and so much more motion than of what stands.
constexpr int kSilentViews = 8;
constexpr double kSilentLengths = 2, kSilentMotion = 100, kSilent = 0.1;
/// A track of more views is not asked whether it has come; how much of its place must have been seen free for that.
constexpr int kNewViews = 30;
constexpr double kArrived = 0.5;
/// us: between looks that are kept, and the age of the oldest.
constexpr Micros kLookEvery = 190'000, kOldestLook = 2'000'000;
/// us: a track ends when it was not seen for so long; one of a single view, which may be noise, earlier.
constexpr Micros kLost = 1'000'000, kNoise = 300'000;
/// us: a mover that seems to stand for so long does.
constexpr Micros kStands = 1'500'000;
/// Leaves of a view that are asked about, spread evenly over it: bounds the work.
constexpr std::size_t kMostLeaves = 12;
/// An even line or face ends sqrt(3) deviations from its middle; a solid box is taken to end at two.
constexpr double kFaceSigmas = 1.732, kBoxSigmas = 2;
/// Share of itself by which the extent that a track remembers follows smaller views.
constexpr double kForgets = 0.02;

/// Whether what is seen of a track is of something that moves, by the index of the track.
using Moving = std::vector<bool>;

Moving moversAmong(const Movers& movers) {
  Moving moving;
  for (const Track& track : movers.tracks) {
    moving.push_back(track.mover.id != 0);
  }
  return moving;
}

/// Marks the objects of the graph that are of something that moves.
std::vector<bool> markMoving(const Moving& moving, const LocalGraph& local, const std::vector<Seen>& seen) {
  std::vector<bool> marked(local.objects.size(), false);
  for (const Seen& s : seen) {
    if (s.index >= 0 && s.track >= 0 && moving[static_cast<std::size_t>(s.track)]) {
      marked[static_cast<std::size_t>(s.index)] = true;
    }
  }
  return marked;
}

std::vector<Belief> leavesOf(const LocalObject& object, const Pose& T_map_body) {
  const Pose T_map_object = T_map_body * object.T_body_object;
  const std::size_t stride = (object.leaves.size() + kMostLeaves - 1) / kMostLeaves;
  std::vector<Belief> leaves;
  for (std::size_t k = 0; k < object.leaves.size(); k += stride) {
    leaves.push_back(transform(T_map_object, object.leaves[k]));
  }
  return leaves;
}

/// Of the things of a track, m.
double lengthOf(const Track& track) {
  return 2 * kFaceSigmas * std::sqrt(std::max(eigenSymmetric(track.extent).values[2], 0.0));
}

/// How far a place is from a glimpse's, seen from above, m.
double wayFrom(const Track::Glimpse& glimpse, const Vec3& p) { return (glimpse.mean - p).head<2>().norm(); }

/// A glimpse to hold the track against, and whether the track has left its place.
struct Past {
  const Track::Glimpse* then = nullptr;
  bool is_behind = false;
};

/// The newest glimpse that the thing has left behind by its own length when its middle is at `p`, else the oldest.
Past pastOf(const Track& track, const Vec3& p) {
  const double length = lengthOf(track);
  Past past;
  for (auto it = track.glimpses.rbegin(); it != track.glimpses.rend() && !past.is_behind; ++it) {
    past = {&*it, wayFrom(*it, p) > length};
  }
  return past;
}

constexpr double kSigmaFloor = 0.01;  // m, of leaves, as creation.sigma_floor

/// What a look saw of a place that `leaves` take up now.
PlaceSight sightBefore(const Look& look, const std::vector<Belief>& leaves, const FreeSpace& now) {
  return lookAt(leaves, *look.free, now.variance, now.variance_turn, kSigmaFloor);
}

/// The same of the look that a glimpse is of.
PlaceSight sightBefore(const Track::Glimpse& then, const std::vector<Belief>& leaves, const FreeSpace& now,
                       const std::deque<Look>& looks) {
  const auto look = std::ranges::find(looks, then.utime_us, &Look::utime_us);
  return look != looks.end() ? sightBefore(*look, leaves, now) : PlaceSight{};
}

/// What is seen now of the place of a glimpse.
PlaceSight sightNow(const Track::Glimpse& then, const FreeSpace& now, const std::deque<Look>& looks) {
  const auto look = std::ranges::find(looks, then.utime_us, &Look::utime_us);
  return look != looks.end() ? lookAt(then.leaves, now, look->free->variance, look->free->variance_turn, kSigmaFloor)
                             : PlaceSight{};
}

bool isTaken(const PlaceSight& sight) { return sight.taken > kSeenThrough && sight.taken > sight.through; }

bool seemsToMove(const Track& track) {
  return motionSquare(track.mover.motion) > kMoves && track.mover.motion.velocity().head<2>().norm() > kSlowest;
}

/// Whether the place of a new track was seen free not long ago: what is there has come, and may go. It makes no node as
/// long as that is so, two seconds at most if it stays.
bool hasArrived(const Track& track, const std::vector<Belief>& leaves, const FreeSpace& free, const Movers& movers) {
  if (track.mover.views > kNewViews || movers.looks.empty()) {
    return false;
  }
  const PlaceSight sight = sightBefore(movers.looks.front(), leaves, free);
  return sight.through > kArrived && sight.taken < kSilent;
}

/// Whether a track that no look says anything of has gone so far, and so steadily, that nothing that stands can have
/// been seen so.
bool hasGoneFar(const Track& track) {
  return track.mover.views >= kSilentViews && motionSquare(track.mover.motion) > kSilentMotion &&
         wayFrom(track.glimpses.front(), track.mover.belief.mean) > kSilentLengths * lengthOf(track);
}

/// Judges whether a track that is in view moves or stands.
void judge(Track& track, const std::vector<Belief>& leaves, const FreeSpace& free, const Movers& movers, Map& map) {
  const bool moves = seemsToMove(track);
  if (track.mover.id != 0) {
    track.still_since_us = moves ? 0 : track.still_since_us == 0 ? track.mover.last_us : track.still_since_us;
    return;
  }
  const Past past = moves ? pastOf(track, track.mover.belief.mean) : Past{};
  if (past.then == nullptr) {
    track.votes = 0;
    return;
  }
  const PlaceSight old = sightNow(*past.then, free, movers.looks);
  const PlaceSight here = sightBefore(*past.then, leaves, free, movers.looks);
  const bool is_contradicted = isTaken(old) || isTaken(here);
  const bool is_silent = old.taken + here.taken < kSilent;
  const bool is_told = old.through + here.through > kSeenThrough || (is_silent && hasGoneFar(track));
  track.votes = is_contradicted ? 0 : is_told ? track.votes + 1 : track.votes;
  if (track.votes >= kVotes) {
    track.mover.id = map.takeId();
    track.still_since_us = 0;
  }
}

/// A view of a track: one object, or several pieces.
struct View {
  Belief belief;
  std::vector<Belief> leaves;
  ClassId label = 0;  // of the largest piece
  double largest = 0;
};

void addObject(View& view, const Seen& seen, const Pose& T_map_body) {
  view.belief = view.belief.kappa > 0 ? merge(view.belief, seen.belief) : seen.belief;
  const std::vector<Belief> leaves = leavesOf(*seen.object, T_map_body);
  view.leaves.insert(view.leaves.end(), leaves.begin(), leaves.end());
  if (seen.can_move && seen.belief.kappa > view.largest) {
    view.label = seen.object->label;
    view.largest = seen.belief.kappa;
  }
}

/// The views of the tracks by the objects they were given. What a mover was given is not of it where it was before the
/// mover came, and then begins a track of its own, as does what can move and belongs to none.
std::vector<View> viewsOf(Movers& movers, std::vector<Seen>& seen, const Pose& T_map_body, const FreeSpace& free) {
  std::vector<View> views(movers.tracks.size());
  for (Seen& s : seen) {
    if (s.track >= 0) {
      const Track& track = movers.tracks[static_cast<std::size_t>(s.track)];
      const Past past = track.mover.id != 0 ? pastOf(track, s.belief.mean) : Past{};
      if (past.is_behind && isTaken(sightBefore(*past.then, leavesOf(*s.object, T_map_body), free, movers.looks))) {
        s.track = -1;
      }
    }
    if (s.track < 0 && s.can_move) {
      s.track = static_cast<int>(movers.tracks.size());
      movers.tracks.emplace_back();
      views.emplace_back();
    }
    if (s.track >= 0) {
      addObject(views[static_cast<std::size_t>(s.track)], s, T_map_body);
    }
  }
  return views;
}

void observe(Track& track, const View& view, Micros utime_us) {
  Mover& mover = track.mover;
  if (mover.views == 0) {
    const Mat3 first = Vec3(square(kFirstSpeed), square(kFirstSpeed), square(kFirstClimb)).asDiagonal();
    mover.motion = seenAt(view.belief.mean, noiseOfView(view.belief.cov), first);
    mover.first_us = utime_us;
    track.extent = view.belief.cov;
  } else {
    mover.motion = update(mover.motion, view.belief.mean, noiseOfView(larger(view.belief.cov, track.extent)));
    track.extent = view.belief.cov.trace() > track.extent.trace()
                       ? view.belief.cov
                       : Mat3((1 - kForgets) * track.extent + kForgets * view.belief.cov);
  }
  mover.belief = view.belief;
  mover.last_us = utime_us;
  ++mover.views;
  if (view.largest > 0) {
    addViews(mover.classes, {{view.label, 1.0F}});
  }
  mover.label = likeliestClass(mover.classes, view.label);
}

/// Keeps the frame as a look when it is time, with how each track is seen in it. `views` goes with the tracks.
void keepLook(Movers& movers, const std::vector<View>& views, Micros utime_us, std::shared_ptr<const FreeSpace> free) {
  if (!movers.looks.empty() && utime_us - movers.looks.back().utime_us < kLookEvery) {
    return;
  }
  movers.looks.push_back({utime_us, std::move(free)});
  while (utime_us - movers.looks.front().utime_us > kOldestLook) {
    movers.looks.pop_front();
  }
  for (std::size_t t = 0; t < movers.tracks.size(); ++t) {
    Track& track = movers.tracks[t];
    std::erase_if(track.glimpses, [&](const Track::Glimpse& g) { return g.utime_us < movers.looks.front().utime_us; });
    if (views[t].belief.kappa > 0) {
      track.glimpses.push_back({utime_us, views[t].belief.mean, views[t].leaves});
    }
  }
}

/// Nodes that were made of the track's views, most of theirs at least.
void takeTrail(Track& track, const Map& map, std::vector<NodeId>& trail) {
  for (const auto& [id, times] : track.fed) {
    const MapNode* node = map.find(id);
    if (node != nullptr && 2 * times >= node->views) {
      trail.push_back(id);
    }
  }
  track.fed.clear();
}

/// Ends tracks that are out of view, and movers that stand.
void endTracks(Movers& movers, Micros utime_us, std::vector<NodeId>& ended) {
  std::erase_if(movers.tracks, [&](Track& track) {
    const Micros unseen = utime_us - track.mover.last_us;
    const bool is_lost = unseen > (track.mover.views > 1 ? kLost : kNoise);
    const bool stands = track.still_since_us != 0 && utime_us - track.still_since_us > kStands;
    if (track.mover.id != 0 && (is_lost || stands)) {
      ended.push_back(track.mover.id);
      track.mover.id = 0;
      track.votes = 0;
    }
    track.still_since_us = stands ? 0 : track.still_since_us;
    return is_lost;
  });
  std::ranges::sort(ended);
}

}  // namespace

std::vector<LocalObject> takeMoving(const Movers& movers, LocalGraph& local, std::vector<ObjectPair>& pairs,
                                    const Pose& T_map_body, const ClassTable& classes) {
  if (std::ranges::none_of(movers.tracks, [](const Track& track) { return track.mover.id != 0; })) {
    return {};
  }
  std::vector<Seen> seen = thingsOf(local.objects, T_map_body, classes);
  assignTracks(movers, local.utime_us, seen);
  return takeOut(local, pairs, markMoving(moversAmong(movers), local, seen));
}

Followed followMovers(Movers& movers, LocalGraph& local, std::vector<ObjectPair>& pairs,
                      const std::vector<LocalObject>& taken, const Pose& T_map_body,
                      std::shared_ptr<const FreeSpace> free, const ClassTable& classes, Map& map) {
  const Micros utime_us = local.utime_us;
  std::vector<Seen> seen = thingsOf(local.objects, T_map_body, classes);
  for (Seen again : thingsOf(taken, T_map_body, classes)) {
    again.index = -1;
    seen.push_back(again);
  }
  assignTracks(movers, utime_us, seen);
  for (Track& track : movers.tracks) {
    track.mover.motion = expectedAt(track, movers, utime_us);
  }
  movers.utime_us = utime_us;
  const std::vector<View> views = viewsOf(movers, seen, T_map_body, *free);
  Followed followed;
  Moving moving(views.size(), false);
  for (std::size_t t = 0; t < views.size(); ++t) {
    if (views[t].belief.kappa > 0) {
      Track& track = movers.tracks[t];
      observe(track, views[t], utime_us);
      judge(track, views[t].leaves, *free, movers, map);
      if (track.mover.id != 0) {
        takeTrail(track, map, followed.trail);
      }
      moving[t] = track.mover.id != 0 || hasArrived(track, views[t].leaves, *free, movers);
    }
  }
  takeOut(local, pairs, markMoving(moving, local, seen));
  std::ranges::sort(followed.trail);
  followed.trail.erase(std::unique(followed.trail.begin(), followed.trail.end()), followed.trail.end());
  std::erase_if(pairs, [&](const ObjectPair& pair) { return std::ranges::binary_search(followed.trail, pair.map); });
  keepLook(movers, views, utime_us, std::move(free));
  endTracks(movers, utime_us, followed.ended);
  return followed;
}

void noteFedNodes(Movers& movers, const Map& map) {
  for (Track& track : movers.tracks) {
    const Mover& mover = track.mover;
    if (mover.id != 0 || mover.last_us != movers.utime_us) {
      continue;
    }
    const double reach = kBoxSigmas * std::sqrt(track.extent.trace()) + kPositionOfView.view_noise;
    NodeId fed = 0;
    double nearest = std::numeric_limits<double>::infinity();
    for (const NodeId id : map.near(mover.belief.mean, reach)) {
      const MapNode& node = *map.find(id);
      const double apart = (node.belief.mean - mover.belief.mean).norm();
      if (!node.stuff && node.last_us == movers.utime_us && apart < nearest) {
        nearest = apart;
        fed = id;
      }
    }
    const auto known = std::ranges::find(track.fed, fed, &std::pair<NodeId, int>::first);
    if (known != track.fed.end()) {
      ++known->second;
    } else if (fed != 0) {
      track.fed.emplace_back(fed, 1);
    }
  }
}

void moveAlong(Movers& movers, const Pose& T_new_old) {
  const Mat3 R = T_new_old.linear();
  for (Track& track : movers.tracks) {
    track.mover.motion = transform(T_new_old, track.mover.motion);
    track.mover.belief = transform(T_new_old, track.mover.belief);
    track.extent = R * track.extent * R.transpose();
    for (Track::Glimpse& glimpse : track.glimpses) {
      glimpse.mean = T_new_old * glimpse.mean;
      for (Belief& leaf : glimpse.leaves) {
        leaf = transform(T_new_old, leaf);
      }
    }
  }
  for (Look& look : movers.looks) {
    FreeSpace moved = *look.free;
    moved.T_map_sensor = T_new_old * moved.T_map_sensor;
    look.free = std::make_shared<const FreeSpace>(std::move(moved));
  }
}

std::vector<NodeId> forgetMovers(Movers& movers) {
  std::vector<NodeId> ended;
  for (const Mover& mover : moversOf(movers)) {
    ended.push_back(mover.id);
  }
  movers = {};
  return ended;
}

std::vector<Mover> moversOf(const Movers& movers) {
  std::vector<Mover> all;
  for (const Track& track : movers.tracks) {
    if (track.mover.id != 0) {
      all.push_back(track.mover);
    }
  }
  std::ranges::sort(all, {}, &Mover::id);
  return all;
}

}  // namespace hgg
