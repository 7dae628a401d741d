#pragma once

#include <string>
#include <vector>

#include "map/import.h"
#include "query/answer.h"

namespace hgg {

/// A room of boxes to ask about: what `hggmap import` makes of them.
class Room {
 public:
  /// Next id, from 0 on.
  Room& add(const std::string& label, const Vec3& centre, const Vec3& size, const std::string& more = "") {
    const auto list = [](const Vec3& v) {
      return "[" + std::to_string(v.x()) + "," + std::to_string(v.y()) + "," + std::to_string(v.z()) + "]";
    };
    objects_ += (objects_.empty() ? "" : ",") + ("{\"id\":" + std::to_string(count_++)) + ",\"label\":\"" + label +
                "\",\"center\":" + list(centre) + ",\"size\":" + list(size) + more + "}";
    return *this;
  }
  Map map() const { return *importJson("{\"objects\":[" + objects_ + "]}"); }
  Answer ask(const std::string& text, const std::optional<Standpoint>& from = std::nullopt) const {
    const QueryScene scene = sceneOf(map());
    return answerText(text, scene, Lexicon(scene.class_names, {}), from, 10);
  }
  /// The id of the first answer; -1 when there is none.
  NodeId first(const std::string& text, const std::optional<Standpoint>& from = std::nullopt) const {
    const Answer answer = ask(text, from);
    return answer.things.empty() ? -1 : answer.things.front().id;
  }

 private:
  std::string objects_;
  int count_ = 0;
};

}  // namespace hgg
