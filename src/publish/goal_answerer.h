#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>

#include "config.h"
#include "publish/messages.h"
#include "query/lexicon.h"
#include "traversability/leaf_copy.h"

namespace hgg {

/// The map as it was when something was asked, and where the robot was.
struct AskedMap {
  LeafChanges all;
  std::map<ClassId, std::string> class_names;
  Micros utime_us = 0;  // of the newest frame
  std::int64_t revision = 0;
  std::optional<Pose> T_map_body;  // nothing: the robot does not know where it is
};

/// Answers queries as `hggmap query` does, of a copy of the map. Slow: for a thread of its own.
class GoalAnswerer {
 public:
  explicit GoalAnswerer(const TraversabilityConfig& limits) : limits_(limits) {}

  GoalReply answer(AskedMap map, const GoalQuery& query);
  /// The words for these classes; made anew only when the classes are others than the last time.
  const Lexicon& lexiconOf(const std::map<ClassId, std::string>& class_names);

 private:
  TraversabilityConfig limits_;
  std::map<ClassId, std::string> class_names_;  // of the lexicon
  std::unique_ptr<Lexicon> lexicon_;
};

/// The reply to a query that is not answered.
GoalReply failure(const GoalQuery& query, std::string why);

}  // namespace hgg
