#pragma once

#include <deque>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "map/paging.h"

namespace hgg {

/// All nodes of a map of which a part is out of memory, one after the other: what is paged out is read a few pages at a
/// time and moved with its keyframes. Beside the map it takes what the edges of the whole take, and a few bytes a node.
class WholeMap {
 public:
  /// Both must outlive it. Reads every page once.
  WholeMap(const Map& map, const PageReader& read);

  /// Why some of it could not be read; empty when all could.
  const std::string& error() const { return error_; }
  std::size_t size() const { return map_.nodes().size() + away_.size(); }
  /// Of the whole, as they are once the graph is settled.
  const std::vector<Edge>& edges() const { return edges_; }
  /// Whether some node has them (map/node_bytes.h).
  bool hasLooks() const { return has_looks_; }
  bool hasFreeSpace() const { return has_free_space_; }

  /// Calls visit(const MapNode&) for each node, ascending by id.
  template <typename Visit>
  void forEach(Visit visit) {
    auto away = away_.begin();
    const auto visitAwayBefore = [&](NodeId id) {
      for (; away != away_.end() && away->first < id && error_.empty(); ++away) {
        if (const MapNode* node = findAway(away->first, away->second)) {
          visit(*node);
        }
      }
    };
    for (const auto& [id, node] : map_.nodes()) {
      visitAwayBefore(id);
      visit(node);
    }
    visitAwayBefore(std::numeric_limits<NodeId>::max());
  }

 private:
  void survey();
  void note(const MapNode& node);
  /// A page as the keyframes lie now; nullptr, with an error, when it cannot be read.
  const MapPage* pageAt(KeyframeId id);
  const MapNode* findAway(NodeId id, KeyframeId keyframe);

  const Map& map_;
  const PageReader& read_;
  std::string error_;
  std::vector<std::pair<NodeId, KeyframeId>> away_;  // ascending
  std::vector<Edge> edges_;
  bool has_looks_ = false, has_free_space_ = false;
  std::map<KeyframeId, MapPage> held_;
  std::deque<KeyframeId> order_;  // of held_, as they came
};

}  // namespace hgg
