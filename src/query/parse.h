#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "query/lexicon.h"
#include "query/request.h"

namespace hgg {

/// What a text asks for. Where it can be read in more than one way ("the lamp on the table by the door": what is by the
/// door?), there are several readings with their prior odds.
struct Parse {
  std::vector<Request> readings;  // none: it was not understood
  std::string reason;             // why not
};

Parse parseText(std::string_view text, const Lexicon& lexicon);

}  // namespace hgg
