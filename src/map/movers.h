#pragma once

#include <deque>
#include <memory>
#include <utility>
#include <vector>

#include "core/class_belief.h"
#include "core/classes.h"
#include "map/class_evidence.h"
#include "map/constant_velocity.h"
#include "map/local_graph.h"
#include "map/map.h"

namespace hgg {

/// Something that moves, as it is told of.
struct Mover {
  NodeId id = 0;  // of the ids of nodes; 0 while it may as well stand
  ClassId label = 0;
  ClassBelief classes;      // how its views were labelled
  Belief belief;            // of its last view, map frame: `cov` is its extent
  ConstantVelocity motion;  // of the middle of its views, at the last frame
  std::int32_t views = 0;
  Micros first_us = 0, last_us = 0;  // seen
};

/// A track: one thing of a class that can move, over the frames that see it.
struct Track {
  /// How it was seen at a look that is kept (Movers::looks).
  struct Glimpse {
    Micros utime_us = 0;
    Vec3 mean = Vec3::Zero();
    std::vector<Belief> leaves;  // map frame
  };

  Mover mover;
  Mat3 extent = Mat3::Zero();  // m^2: of the largest of the late views, as most are partial
  std::vector<Glimpse> glimpses;
  std::vector<std::pair<NodeId, int>> fed;  // nodes that its views became part of, and how many did
  int votes = 0;              // successive looks that found its old place free, or its new one free before
  Micros still_since_us = 0;  // of what is called a mover: since when it seems to stand; 0: it does not
};

/// A frame that is kept to be asked what it saw through.
struct Look {
  Micros utime_us = 0;
  std::shared_ptr<const FreeSpace> free;
};

/// What is known of things that can move, beside the map: every one in view has a track, and those that are known to
/// move are no part of the map. Plain state; the functions below carry it from frame to frame.
struct Movers {
  std::vector<Track> tracks;
  std::deque<Look> looks;  // the oldest first
  Micros utime_us = 0;     // of the last frame that was followed
};

/// Takes the objects of movers, where these are expected at the time of the frame, out of the frame's graph and the
/// pairs that name them. Nothing that moves may hold a pose or become part of a node.
std::vector<LocalObject> takeMoving(const Movers& movers, LocalGraph& local, std::vector<ObjectPair>& pairs,
                                    const Pose& T_map_body, const ClassTable& classes);

/// What following the movers of a frame came to.
struct Followed {
  std::vector<NodeId> trail;  // ascending: nodes that were made of what turns out to move
  std::vector<NodeId> ended;  // ascending: ids of movers that stand again, or were lost from view
};

/// Carries the tracks on by a frame at its aligned pose: its objects of classes that can move, `taken` ones included,
/// go to the tracks they belong to or begin new ones; tracks become movers or stop to be; objects of movers leave the
/// frame's graph. A track is a mover when its velocity is not zero, by a test at one percent, and three looks
/// in a row have found more of it where it was free before, or of its old place free now, than taken. So what stands,
/// and is only seen from elsewhere, is no mover, however its middle wanders. New movers get their ids from `map`.
Followed followMovers(Movers& movers, LocalGraph& local, std::vector<ObjectPair>& pairs,
                      const std::vector<LocalObject>& taken, const Pose& T_map_body,
                      std::shared_ptr<const FreeSpace> free, const ClassTable& classes, Map& map);

/// Notes which nodes of the map the objects of the last frame have become part of.
void noteFedNodes(Movers& movers, const Map& map);

/// Takes the tracks along when a correction moves the robot and what is around it.
void moveAlong(Movers& movers, const Pose& T_new_old);

/// Forgets all tracks, where the robot does not know where it is: gives back the ids of movers, ascending.
std::vector<NodeId> forgetMovers(Movers& movers);

/// What moves, by ascending id.
std::vector<Mover> moversOf(const Movers& movers);

}  // namespace hgg
