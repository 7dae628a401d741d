#include "region/region_name.h"

namespace hgg {

std::string regionName(const Map& map, const std::vector<NodeId>& objects) {
  const auto it = map.classNames().find(map.find(objects.front())->label);
  return it == map.classNames().end() ? "" : it->second;
}

}  // namespace hgg
