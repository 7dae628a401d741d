#pragma once

#include <optional>
#include <string>
#include <vector>

#include "query/ground.h"
#include "query/lexicon.h"
#include "query/parse.h"

namespace hgg {

enum class AnswerStatus : std::uint8_t { kOk, kAmbiguous, kNotFound, kNotUnderstood };
const char* nameOf(AnswerStatus status);

/// One thing that may be meant.
struct FoundThing {
  NodeId id = 0;
  std::string name;
  double probability = 0;
  Vec3 mean = Vec3::Zero();  // m, map frame
  std::string reason;        // one sentence
};

struct Answer {
  AnswerStatus status = AnswerStatus::kNotUnderstood;
  std::vector<FoundThing> things;  // most probable first; none unless ok or ambiguous
  std::string reason;              // why there is no answer, or more than one
  std::optional<Request> request;  // as it was read
};

/// The thing that a text means, of those in the scene; at most `top` things.
Answer answerText(const std::string& text, const QueryScene& scene, const Lexicon& lexicon,
                  const std::optional<Standpoint>& from, std::size_t top);

/// How a request was read, on one line: "chair (next to: table (largest))".
std::string describe(const Request& request);

/// How the text of an answer was read, as JSON: {"reading":"..","unread":words}, {} where it was not.
std::string parseJson(const Answer& answer);

}  // namespace hgg
