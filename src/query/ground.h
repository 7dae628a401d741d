#pragma once

#include <optional>
#include <string>
#include <vector>

#include "query/referent.h"
#include "query/request.h"
#include "query/scene.h"
#include "query/views.h"

namespace hgg {

/// What the phrases of a request mean.
struct Grounding {
  Referents target;                // most probable first
  std::vector<Referents> anchors;  // by phrase, for those that were asked about
  double log_evidence = 0;         // of the reading
};

/// Finds what a request means: P(thing) ~ class belief x existence x likelihood of all that is said of it, where what
/// is said of anchors is summed over what they may be, and what is said of left and right over how one may look.
Grounding groundRequest(const Request& request, const QueryScene& scene, const std::optional<Standpoint>& from);

/// The same for all readings of a text: their mixture, each weighted by its prior and how well the scene fits it.
/// `best` is set to the index of the reading with the most weight.
Grounding groundReadings(const std::vector<Request>& readings, const QueryScene& scene,
                         const std::optional<Standpoint>& from, std::size_t& best);

}  // namespace hgg
