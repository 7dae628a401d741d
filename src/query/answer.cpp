#include "query/answer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "query/relations.h"
#include "query/words.h"

namespace hgg {
namespace {

/// That a text means something else than it was taken to mean: at the least, and for each word that was not understood.
/// Fitted to the tuning part of the language scans (docs/language.md).
constexpr double kMisread = 0.01, kMisreadPerWord = 0.04;
/// The second is within noise of the first when it is at least this likely next to it.
constexpr double kAmbiguousRatio = 0.6;
/// A first answer less probable than this is one of many, whatever the second.
constexpr double kLeastSure = 0.35;
/// A thing that the text is about and the map does not have is worse than a word that was not understood: as bad as so
/// many.
constexpr int kMissingCounts = 4;

const char* nameOf(Relation r) {
  static constexpr const char* kNames[] = {"near",  "closest to", "far from",    "between", "on",      "with on it",
                                           "above", "below",      "in front of", "behind",  "left of", "right of",
                                           "in",    "facing",     "across from", "with"};
  return kNames[static_cast<std::size_t>(r)];
}

const char* nameOf(Placement p) {
  static constexpr const char* kNames[] = {
      "left", "right", "middle", "front", "back", "top", "bottom", "corner", "centre of the room",
      "wall", "floor", "alone"};
  return kNames[static_cast<std::size_t>(p)];
}

std::string describe(const Request& request, int phrase, int depth);

std::string describe(const Request& request, const Constraint& c, int depth) {
  std::string text = c.is_negated ? "not " : "";
  switch (c.kind) {
    case Constraint::Kind::kRelation: {
      text += nameOf(c.relation);
      for (const int anchor : c.anchors) {
        text += ' ';
        text += describe(request, anchor, depth + 1);
      }
      return text;
    }
    case Constraint::Kind::kPlace:
      return text + nameOf(c.place) + (c.ranked ? fmt::format(" #{}", c.rank) : "");
    default:
      return text + c.word;
  }
}

std::string describe(const Request& request, int phrase, int depth) {
  const Phrase& p = request.phrases[static_cast<std::size_t>(phrase)];
  std::string text = p.words;
  if (depth > 4 || p.constraints.empty()) {
    return text;
  }
  text += " (";
  for (const Constraint& c : p.constraints) {
    text += (text.back() == '(' ? "" : "; ") + describe(request, c, depth);
  }
  return text + ")";
}

std::string nameOf(const QueryScene& scene, ClassId label) {
  const auto it = scene.class_names.find(label);
  return it != scene.class_names.end() ? it->second : fmt::format("class {}", label);
}

/// Of the anchors that are about as likely as any, the nearest to the thing (for far: the farthest).
const SceneThing& anchorToName(const QueryScene& scene, const Referents& found, const SceneThing& thing,
                               bool farthest) {
  const SceneThing* best = nullptr;
  for (const Referent& r : found) {
    const SceneThing& a = scene.things[static_cast<std::size_t>(r.thing)];
    const bool likely = r.probability > 0.3 * found.front().probability && a.id != thing.id;
    if (likely && (best == nullptr || (gapBetween(a, thing) < gapBetween(*best, thing)) != farthest)) {
      best = &a;
    }
  }
  return best != nullptr ? *best : scene.things[static_cast<std::size_t>(found.front().thing)];
}

/// Why this thing: what was said of it, with the anchors that were found.
std::string reasonFor(const Request& request, const Grounding& grounding, const QueryScene& scene,
                      const SceneThing& thing) {
  const Phrase& target = request.phrases[static_cast<std::size_t>(request.target)];
  std::string reason = fmt::format("a {}", nameOf(scene, thing.label));
  for (const Constraint& c : target.constraints) {
    reason += reason.find(',') == std::string::npos ? ", " : " and ";
    if (c.kind != Constraint::Kind::kRelation || c.anchors.empty()) {
      reason += describe(request, c, 5);
      continue;
    }
    reason += std::string(c.is_negated ? "not " : "") + nameOf(c.relation);
    for (const int anchor : c.anchors) {
      const std::vector<Referent>& found = grounding.anchors[static_cast<std::size_t>(anchor)];
      const std::string& words = request.phrases[static_cast<std::size_t>(anchor)].words;
      if (found.empty()) {
        reason += fmt::format(" \"{}\", which the map does not have", words);
        continue;
      }
      const SceneThing& a = anchorToName(scene, found, thing, c.relation == Relation::kFar);
      reason += fmt::format(" the {} {} ({:.1f} m)", nameOf(scene, a.label), a.id, gapBetween(thing, a));
    }
  }
  return reason;
}

Answer noAnswer(AnswerStatus status, std::string reason, std::optional<Request> request = std::nullopt) {
  return {status, {}, std::move(reason), std::move(request)};
}

/// Softens probabilities by how likely it is that the text was misread.
void allowForMisreading(std::vector<Referent>& candidates, int unread) {
  const double misread = 1 - (1 - kMisread) * std::pow(1 - kMisreadPerWord, unread);
  for (Referent& c : candidates) {
    c.probability = (1 - misread) * c.probability + misread / static_cast<double>(candidates.size() + 1);
  }
}

/// What the thing is told by, and the map does not have.
std::vector<std::string> missingAnchors(const Request& request, const Grounding& grounding) {
  std::vector<std::string> missing;
  for (const Constraint& c : request.phrases[static_cast<std::size_t>(request.target)].constraints) {
    for (const int anchor : c.kind == Constraint::Kind::kRelation ? c.anchors : std::vector<int>{}) {
      const Phrase& phrase = request.phrases[static_cast<std::size_t>(anchor)];
      const bool is_thing = !phrase.is_robot && !phrase.is_room && !phrase.is_any;
      if (is_thing && !c.is_negated && grounding.anchors[static_cast<std::size_t>(anchor)].empty()) {
        missing.push_back(phrase.words);
      }
    }
  }
  return missing;
}

/// Whether the first answer is one, or one of several, and why.
void judge(const Referents& candidates, const std::vector<std::string>& missing, Answer& answer) {
  const double most = candidates.front().probability;
  const auto is_close = [&](const Referent& c) { return c.probability > kAmbiguousRatio * most; };
  const auto close = std::ranges::count_if(candidates, is_close);
  if (!missing.empty()) {
    answer.status = AnswerStatus::kAmbiguous;
    answer.reason = fmt::format("the map has no \"{}\", so this is a guess", missing.front());
  } else if (close > 1) {
    answer.status = AnswerStatus::kAmbiguous;
    answer.reason = fmt::format("{} things fit about as well", close);
  } else if (most < kLeastSure) {
    answer.status = AnswerStatus::kAmbiguous;
    answer.reason = "nothing fits well";
  }
}

std::optional<Standpoint> inScene(const QueryScene& scene, const std::optional<Standpoint>& from) {
  if (!from) {
    return std::nullopt;
  }
  const Vec2 p = Eigen::Rotation2Dd(-scene.yaw) * Vec2(from->x, from->y);
  return Standpoint{p.x(), p.y(), from->yaw - scene.yaw};
}

}  // namespace

const char* nameOf(AnswerStatus status) {
  static constexpr const char* kNames[] = {"ok", "ambiguous", "not_found", "not_understood"};
  return kNames[static_cast<std::size_t>(status)];
}

std::string describe(const Request& request) {
  std::string text = describe(request, request.target, 0);
  if (request.view) {
    static constexpr const char* kKinds[] = {"facing", "from", "entering"};
    text += fmt::format(", {} {}", kKinds[static_cast<std::size_t>(request.view->kind)],
                        request.view->phrase >= 0 ? describe(request, request.view->phrase, 3) : "the room");
  }
  return text;
}

std::string parseJson(const Answer& answer) {
  nlohmann::ordered_json parse = nlohmann::ordered_json::object();
  if (answer.request) {
    parse = {{"reading", describe(*answer.request)}, {"unread", answer.request->unread}};
  }
  return parse.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

Answer answerText(const std::string& text, const QueryScene& scene, const Lexicon& lexicon,
                  const std::optional<Standpoint>& from, std::size_t top) {
  const Parse parse = parseText(text, lexicon);
  if (parse.readings.empty()) {
    return noAnswer(AnswerStatus::kNotUnderstood, parse.reason);
  }
  std::size_t best = 0;
  Grounding grounding = groundReadings(parse.readings, scene, inScene(scene, from), best);
  const Request& request = parse.readings[best];
  const Phrase& target = request.phrases[static_cast<std::size_t>(request.target)];
  if (grounding.target.empty()) {
    return noAnswer(AnswerStatus::kNotFound, fmt::format("the map has no \"{}\"", target.words), request);
  }
  const std::vector<std::string> missing = missingAnchors(request, grounding);
  allowForMisreading(grounding.target, request.unread + kMissingCounts * static_cast<int>(missing.size()));
  const Pose T_map_scene(Eigen::AngleAxisd(scene.yaw, Vec3::UnitZ()));
  Answer answer{AnswerStatus::kOk, {}, {}, request};
  for (std::size_t k = 0; k < std::min(top, grounding.target.size()); ++k) {
    const Referent& c = grounding.target[k];
    const SceneThing& thing = scene.things[static_cast<std::size_t>(c.thing)];
    answer.things.push_back({thing.id, nameOf(scene, thing.label), c.probability, T_map_scene * thing.centre,
                             reasonFor(request, grounding, scene, thing)});
  }
  judge(grounding.target, missing, answer);
  return answer;
}

}  // namespace hgg
