#pragma once

#include <optional>
#include <string>
#include <vector>

#include "query/request.h"
#include "query/scene.h"

namespace hgg {

/// Where who asks stands and looks.
struct Standpoint {
  double x = 0, y = 0, yaw = 0;  // m, rad; map frame
};

/// A thing that a phrase may mean.
struct Referent {
  int thing = 0;           // index in the scene
  double probability = 0;  // of those of its phrase
};

/// What the phrases of a request mean.
struct Grounding {
  std::vector<Referent> target;                // most probable first
  std::vector<std::vector<Referent>> anchors;  // by phrase, for those that were asked about
  double log_evidence = 0;                     // of the reading
};

/// Finds what a request means: P(thing) ~ class belief x existence x likelihood of all that is said of it, where what
/// is said of anchors is summed over what they may be, and what is said of left and right over how one may look.
Grounding groundRequest(const Request& request, const QueryScene& scene, const std::optional<Standpoint>& from);

/// The same for all readings of a text: their mixture, each weighted by its prior and how well the scene fits it.
/// `best` is set to the index of the reading with the most weight.
Grounding groundReadings(const std::vector<Request>& readings, const QueryScene& scene,
                         const std::optional<Standpoint>& from, std::size_t& best);

}  // namespace hgg
