#pragma once

#include <cstddef>
#include <vector>

#include "mapper.h"
#include "publish/messages.h"

namespace hgg {

/// What a step changed: its created, changed, moved and removed nodes, those whose edges a neighbour's change has
/// changed, and all edges with an end among them. What a closed loop does to edges is said over the frames after it.
GraphUpdate changedGraph(const Mapper& mapper, const StepReport& report);

/// The same, telling of `moved` (ascending) instead of what the step moved. Those that are not in the map, or not in
/// memory, are left out.
GraphUpdate changedGraph(const Mapper& mapper, const StepReport& report, const std::vector<NodeId>& moved);

/// The nodes that corrections have moved and that subscribers have not been told of. A closed loop moves all of a map
/// at once; telling of 20,000 nodes at once would cost the frame's thread more than a frame, so it is spread over the
/// frames that follow.
class MoveQueue {
 public:
  /// Takes in what a step moved, and gives back which nodes to tell of now (ascending, at most kMostAtOnce). What the
  /// step changed, rewired or removed is told of anyway and leaves the queue.
  std::vector<NodeId> next(const MapDelta& delta);
  /// After subscribers were told of the whole graph.
  void clear() { waiting_.clear(); }

  static constexpr std::size_t kMostAtOnce = 1000;  // nodes: about a millisecond with their encoding

 private:
  std::vector<NodeId> waiting_;  // ascending
};

/// The whole graph at its present revision, for late joiners. `utime_us` is the time of the newest frame.
GraphUpdate completeGraph(const Mapper& mapper, Micros utime_us);

}  // namespace hgg
