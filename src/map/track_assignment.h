#pragma once

#include <vector>

#include "map/movers.h"

namespace hgg {

/// How the objects of a frame are given to the tracks of what can move. Part of map/movers.

/// An object of the frame that can be of a track.
struct Seen {
  const LocalObject* object = nullptr;
  int index = -1;  // of the object in the frame's graph; -1: it was taken out
  Belief belief;   // map frame
  bool can_move = false;
  int track = -1;  // index into Movers::tracks
};

/// The frame's things in the map frame.
std::vector<Seen> thingsOf(const std::vector<LocalObject>& objects, const Pose& T_map_body, const ClassTable& classes);

/// Covariance of the middle of a view of something of this extent, m^2.
Mat3 noiseOfView(const Mat3& extent);

const Mat3& larger(const Mat3& a, const Mat3& b);

/// Where a track is expected at the time of a frame.
ConstantVelocity expectedAt(const Track& track, const Movers& movers, Micros utime_us);

/// Gives each object the track it most likely is of: the best pair first, each track one object; then to each track the
/// smaller objects within its box, which are pieces of it. A mover takes those of every class, other tracks only what
/// can move.
void assignTracks(const Movers& movers, Micros utime_us, std::vector<Seen>& seen);

/// Takes marked objects out of a frame's graph, and out of the edges and pairs that name them.
std::vector<LocalObject> takeOut(LocalGraph& local, std::vector<ObjectPair>& pairs, const std::vector<bool>& marked);

}  // namespace hgg
