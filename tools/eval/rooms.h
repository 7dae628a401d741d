#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "eval/objects.h"
#include "map/node.h"
#include "truth/rooms.h"

namespace hgg {

/// How the regions of a map lie beside the true rooms, judged by the things that were found and are in one.
struct RoomScore {
  std::size_t things = 0;         // found, in a room, and in a region
  std::size_t rooms = 0;          // with such a thing
  std::size_t regions = 0;        // with such a thing
  std::size_t alike = 0;          // rooms all of whose things are in one region that has no thing of another room
  double mutual_information = 0;  // normalised, 0..1: 1 where rooms and regions are the same groups
  std::vector<std::string> cut = {}, joined = {};  // names of rooms in several regions, and of those that share one
};

/// Normalised mutual information of two groupings of the same things: 2 I / (H + H'), 1 where both are one group.
double normalisedMutualInformation(std::span<const std::size_t> a, std::span<const std::size_t> b);

RoomScore scoreRooms(std::span<const ObjectMatch> matches, std::span<const TruthObject> truth, const TruthRooms& rooms,
                     const std::map<NodeId, std::int64_t>& region_of);

}  // namespace hgg
