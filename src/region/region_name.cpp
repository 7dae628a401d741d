#include "region/region_name.h"

#include <algorithm>
#include <array>
#include <map>
#include <string_view>

#include "core/spd.h"

namespace hgg {
namespace {

/// How much a class of things speaks for a kind of room; one is enough to call it so.
struct Sign {
  std::string_view room, thing;
  double weight;
};

/// What things tell of a room. Those with a weight below one are found in others, too.
constexpr Sign kSigns[] = {
    {"bathroom", "toilet", 1.5},   {"bathroom", "bathtub", 1.5}, {"bathroom", "shower", 1.5},
    {"bathroom", "sink", 0.4},     {"kitchen", "fridge", 1.2},   {"kitchen", "refrigerator", 1.2},
    {"kitchen", "stove", 1.2},     {"kitchen", "oven", 1.2},     {"kitchen", "counter", 0.5},
    {"kitchen", "sink", 0.5},      {"bedroom", "bed", 1.1},      {"office", "desk", 0.6},
    {"office", "monitor", 0.4},    {"living room", "sofa", 1},   {"station", "ticket-machine", 1},
    {"dining room", "table", 0.5}, {"dining room", "chair", 0.5}};

std::string byItsThings(const std::map<std::string, int>& counts) {
  std::map<std::string_view, double> scores;
  for (const Sign& sign : kSigns) {
    scores[sign.room] += counts.contains(std::string(sign.thing)) ? sign.weight : 0;
  }
  const auto best = std::ranges::max_element(scores, {}, [](const auto& entry) { return entry.second; });
  return best->second >= 1 ? std::string(best->first) : "";
}

std::string plural(const std::string& name) {
  for (const std::string_view ending : {"s", "sh", "ch", "x"}) {
    if (name.ends_with(ending)) {
      return name + "es";
    }
  }
  return name + "s";
}

/// Whether it is much longer than wide, seen from above.
bool isRow(const Belief& belief) {
  constexpr double kLonger = 4;  // times as long as wide
  Mat3 flat = belief.cov;
  flat.row(2).setZero(), flat.col(2).setZero();
  const Vec3 squares = eigenSymmetric(flat).values;  // the first of them is that of the height
  return squares[2] > kLonger * kLonger * squares[1];
}

}  // namespace

std::string regionName(const MapLeaves& map, const ClassNames& names, const Region& region) {
  std::map<std::string, int> counts;
  for (const NodeId id : region.objects) {
    const auto name = names.find(map.nodes.at(id).label);
    if (name != names.end()) {
      ++counts[name->second];
    }
  }
  if (counts.empty()) {
    return "";
  }
  if (std::string name = byItsThings(counts); !name.empty()) {
    return name;
  }
  const auto most = std::ranges::max_element(counts, {}, [](const auto& entry) { return entry.second; });
  constexpr int kRow = 3;  // things: two are always in a row
  return most->second == 1                              ? most->first
         : most->second >= kRow && isRow(region.belief) ? "row of " + plural(most->first)
                                                        : plural(most->first);
}

}  // namespace hgg
