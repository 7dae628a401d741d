#include "publish/graph_update.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "map/position.h"

namespace hgg {
namespace {

ObjectSummary summarise(const Map& map, const MapNode& node, const ClassTable& classes) {
  ObjectSummary out;
  out.id = node.id;
  out.label = node.label;
  out.name = classes.name(node.label);
  out.belief = node.belief;
  out.relative_cov = positionCovariance(node);
  out.position_cov = positionCovarianceInMap(map, node);
  out.anchor = node.anchor;
  out.stuff = node.stuff;
  out.existence = existenceOf(node);
  out.classes = node.stuff ? ClassWeights{{node.label, 1.0F}} : classProbabilities(node.classes);
  out.class_probability = weightOf(out.classes, node.label);
  out.views = node.views;
  out.leaves = static_cast<std::int32_t>(leavesOf(node).size());
  out.first_us = node.first_us;
  out.last_us = node.last_us;
  return out;
}

/// A mover moves by itself, but where the map is corrected it moves along with the newest keyframe.
ObjectSummary summarise(const Map& map, const Mover& mover, const ClassTable& classes) {
  ObjectSummary out;
  out.id = mover.id;
  out.label = mover.label;
  out.name = classes.name(mover.label);
  out.belief = mover.belief;
  out.belief.mean = mover.motion.position();
  out.anchor = map.keyframes().current();
  out.relative_cov = mover.motion.positionCov();
  out.position_cov = out.relative_cov + map.poseCovariance(out.anchor).topLeftCorner<3, 3>();
  out.classes = classProbabilities(mover.classes);
  out.class_probability = weightOf(out.classes, mover.label);
  out.views = mover.views;
  out.first_us = mover.first_us;
  out.last_us = mover.last_us;
  out.motion = ObjectMotion{mover.motion.velocity(), mover.motion.velocityCov()};
  return out;
}

void addMovers(const Mapper& mapper, const std::vector<Mover>& moving, GraphUpdate& update) {
  for (const Mover& mover : moving) {
    update.objects.push_back(summarise(mapper.map(), mover, mapper.classes()));
  }
  std::ranges::sort(update.objects, {}, &ObjectSummary::id);
}

}  // namespace

GraphUpdate changedGraph(const Mapper& mapper, const StepReport& report) {
  return changedGraph(mapper, report, report.delta.moved);
}

GraphUpdate changedGraph(const Mapper& mapper, const StepReport& report, const std::vector<NodeId>& moved) {
  GraphUpdate update;
  update.utime_us = report.utime_us;
  update.revision = report.delta.revision;
  std::vector<NodeId> beliefs, touched;
  std::ranges::set_union(report.delta.changed, moved, std::back_inserter(beliefs));
  std::ranges::set_union(beliefs, report.delta.rewired, std::back_inserter(touched));
  for (const NodeId id : touched) {
    const MapNode* node = mapper.map().find(id);
    if (node != nullptr && isConfirmed(*node)) {
      update.objects.push_back(summarise(mapper.map(), *node, mapper.classes()));
    } else if (node != nullptr) {
      update.removed.push_back(id);
    }
  }
  addMovers(mapper, report.moving, update);
  update.removed.insert(update.removed.end(), report.delta.removed.begin(), report.delta.removed.end());
  update.removed.insert(update.removed.end(), report.stopped.begin(), report.stopped.end());
  std::ranges::sort(update.removed);
  update.edges = mapper.map().graph().edgesOf(touched);
  return update;
}

GraphUpdate completeGraph(const Mapper& mapper, Micros utime_us) {
  GraphUpdate update;
  update.utime_us = utime_us;
  update.revision = mapper.map().revision();
  update.complete = true;
  for (const auto& [id, node] : mapper.map().nodes()) {
    if (isConfirmed(node)) {
      update.objects.push_back(summarise(mapper.map(), node, mapper.classes()));
    }
  }
  addMovers(mapper, moversOf(mapper.movers()), update);
  update.edges = mapper.map().graph().edges();
  return update;
}

std::vector<NodeId> MoveQueue::next(const MapDelta& delta) {
  std::vector<NodeId> all, beliefs, told, waiting;
  std::ranges::set_union(waiting_, delta.moved, std::back_inserter(all));
  std::ranges::set_union(delta.changed, delta.removed, std::back_inserter(beliefs));
  std::ranges::set_union(beliefs, delta.rewired, std::back_inserter(told));
  std::ranges::set_difference(all, told, std::back_inserter(waiting));
  const auto rest = waiting.begin() + static_cast<std::ptrdiff_t>(std::min(waiting.size(), kMostAtOnce));
  waiting_.assign(rest, waiting.end());
  waiting.erase(rest, waiting.end());
  return waiting;
}

}  // namespace hgg
