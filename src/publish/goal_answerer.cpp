#include "publish/goal_answerer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "query/answer.h"
#include "query/goal.h"

namespace hgg {
namespace {

constexpr std::size_t kUsualAnswers = 5, kMostAnswers = 100;
/// Of ground laid for one goal, cells: some seconds of work, while other queries wait.
constexpr double kMostCells = 1e6;

struct Start {
  Standpoint standpoint;
  GoalStart ground;
};

/// Where who asks stands: as said, or where the robot is. Nothing where neither is known.
std::optional<Start> startOf(const AskedMap& map, const GoalQuery& query) {
  if (query.start) {
    const auto& [x, y, z, yaw] = *query.start;
    return Start{{x, y, yaw}, {x, y, std::isfinite(z) ? std::optional(z) : std::nullopt, std::nullopt}};
  }
  if (!map.T_map_body) {
    return std::nullopt;
  }
  const Vec3 p = map.T_map_body->translation(), ahead = map.T_map_body->linear().col(0);
  return Start{{p.x(), p.y(), std::atan2(ahead.y(), ahead.x())}, {p.x(), p.y(), std::nullopt, p.z()}};
}

GoalStatus statusOf(AnswerStatus status) {
  switch (status) {
    case AnswerStatus::kOk:
      return GoalStatus::kOk;
    case AnswerStatus::kAmbiguous:
      return GoalStatus::kAmbiguous;
    case AnswerStatus::kNotFound:
      return GoalStatus::kNotFound;
    case AnswerStatus::kNotUnderstood:
      break;
  }
  return GoalStatus::kNotUnderstood;
}

void tell(const Answer& answer, const MapLeaves& leaves, GoalReply& reply) {
  reply.status = statusOf(answer.status);
  reply.text = answer.reason;
  reply.parse = parseJson(answer);
  for (const FoundThing& thing : answer.things) {
    reply.answers.push_back(
        {thing.id, thing.name, thing.probability, thing.mean, leaves.nodes.at(thing.id).belief.cov, thing.reason});
  }
}

void tell(Goal goal, GoalReply& reply) {
  reply.goal_reason = std::move(goal.reason);
  if (!goal.found) {
    return;
  }
  reply.goal_kind = reply.goal_reason.empty() ? GoalKind::kReachable : GoalKind::kNearest;
  reply.goal = goal.position, reply.goal_yaw = goal.yaw;
  reply.path = std::move(goal.path);
  reply.path_length = goal.path_length, reply.path_confidence = goal.path_confidence;
}

}  // namespace

GoalReply failure(const GoalQuery& query, std::string why) {
  GoalReply reply;
  reply.client = query.client, reply.request_id = query.request_id;
  reply.text = std::move(why);
  return reply;
}

const Lexicon& GoalAnswerer::lexiconOf(const std::map<ClassId, std::string>& class_names) {
  if (!lexicon_ || class_names != class_names_) {
    lexicon_ = std::make_unique<Lexicon>(class_names, LexiconLayers{});
    class_names_ = class_names;
  }
  return *lexicon_;
}

GoalReply GoalAnswerer::answer(AskedMap map, const GoalQuery& query) {
  GoalReply reply = failure(query, {});
  reply.utime_us = map.utime_us, reply.revision = map.revision;
  LeafCopy copy;
  copy.apply(std::move(map.all));
  const MapLeaves leaves = copy.leaves();
  const std::optional<Start> start = startOf(map, query);
  if (start && !isPlace(start->standpoint)) {
    reply.status = GoalStatus::kNotUnderstood;
    reply.text = "the start is no place: x, y and yaw must be finite, within a million metres";
    return reply;
  }
  const std::size_t most =
      query.max_answers <= 0 ? kUsualAnswers : std::min<std::size_t>(query.max_answers, kMostAnswers);
  const Answer answer = answerText(query.text, sceneOf(leaves, map.class_names), lexiconOf(map.class_names),
                                   start ? std::optional(start->standpoint) : std::nullopt, most);
  tell(answer, leaves, reply);
  if (query.with_goal && !answer.things.empty()) {
    if (start) {
      tell(findGoalInMap(leaves, answer.things.front().id, limits_, start->ground, kMostCells), reply);
    } else {
      reply.goal_reason = "the robot does not know where it is, so no way begins there; give a start";
    }
  }
  return reply;
}

}  // namespace hgg
