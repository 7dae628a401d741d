#include "eval/rooms.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace hgg {
namespace {

using Counts = std::map<std::size_t, double>;

double entropyOf(const Counts& counts, double n) {
  double entropy = 0;
  for (const auto& [group, count] : counts) {
    entropy -= count / n * std::log(count / n);
  }
  return entropy;
}

}  // namespace

double normalisedMutualInformation(std::span<const std::size_t> a, std::span<const std::size_t> b) {
  const auto n = static_cast<double>(a.size());
  Counts of_a, of_b;
  std::map<std::pair<std::size_t, std::size_t>, double> of_both;
  for (std::size_t k = 0; k < a.size(); ++k) {
    ++of_a[a[k]], ++of_b[b[k]], ++of_both[{a[k], b[k]}];
  }
  double information = 0;
  for (const auto& [groups, count] : of_both) {
    information += count / n * std::log(count * n / (of_a[groups.first] * of_b[groups.second]));
  }
  const double sum = entropyOf(of_a, n) + entropyOf(of_b, n);
  return sum > 0 ? 2 * information / sum : 1;
}

RoomScore scoreRooms(std::span<const ObjectMatch> matches, std::span<const TruthObject> truth, const TruthRooms& rooms,
                     const std::map<NodeId, std::int64_t>& region_of) {
  std::vector<std::size_t> room_of_thing, region_of_thing;
  std::map<std::size_t, std::set<std::size_t>> regions_of, rooms_in;
  for (const ObjectMatch& match : matches) {
    const auto object = std::ranges::find(truth, match.truth, &TruthObject::id);
    const auto room = object == truth.end() ? std::nullopt : roomAt(rooms, object->belief.mean);
    const auto region = region_of.find(match.prediction);
    if (room && region != region_of.end()) {
      room_of_thing.push_back(*room);
      region_of_thing.push_back(static_cast<std::size_t>(region->second));
      regions_of[*room].insert(region_of_thing.back());
      rooms_in[region_of_thing.back()].insert(*room);
    }
  }
  RoomScore score{.things = room_of_thing.size(), .rooms = regions_of.size(), .regions = rooms_in.size()};
  score.mutual_information = normalisedMutualInformation(room_of_thing, region_of_thing);
  for (const auto& [room, regions] : regions_of) {
    const bool is_cut = regions.size() > 1;
    const bool is_joined = std::ranges::any_of(regions, [&](std::size_t r) { return rooms_in[r].size() > 1; });
    score.alike += is_cut || is_joined ? 0 : 1;
    if (is_cut) {
      score.cut.push_back(rooms.rooms[room].name);
    }
    if (is_joined) {
      score.joined.push_back(rooms.rooms[room].name);
    }
  }
  return score;
}

}  // namespace hgg
