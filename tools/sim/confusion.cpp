#include "sim/confusion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace hgg {
namespace {

struct Common {
  ClassId label;
  double number;  // of things
};

/// The common classes of things, ascending.
std::vector<Common> commonClasses(const World& world) {
  std::map<ClassId, double> numbers;
  double things = 0;
  for (const WorldObject& object : world.objects) {
    if (object.thing) {
      numbers[object.label] += 1;
      things += 1;
    }
  }
  std::vector<Common> common;
  for (const auto& [label, number] : numbers) {
    if (number >= kCommonShare * things) {
      common.push_back({label, number});
    }
  }
  return common;
}

/// Another class than `label`, drawn by u in (0, 1); 0 when there is none.
ClassId drawClass(const std::vector<Common>& common, ClassId label, double u) {
  double all = 0;
  for (const Common& c : common) {
    all += c.label == label ? 0.0 : c.number;
  }
  ClassId drawn = 0;
  for (double left = u * all; const Common& c : common) {
    if (c.label != label && left > 0) {
      drawn = c.label;
      left -= c.number;
    }
  }
  return drawn;
}

/// What is wrong or right as one: a thing, or a stretch of stuff with the places a patch may be at.
struct Unit {
  std::size_t object = 0;
  std::vector<Vec3> places = {};  // none: the whole object
};

std::vector<Unit> unitsOf(const World& world, std::span<const CloudPoint> surface) {
  std::vector<Unit> units;
  for (std::size_t i = 0; i < world.objects.size(); ++i) {
    if (world.objects[i].thing) {
      units.push_back({i});
    }
  }
  std::map<std::array<std::int64_t, 4>, Unit> stretches;
  const auto cell = [](float x) { return static_cast<std::int64_t>(std::floor(static_cast<double>(x) / kStretch)); };
  for (const CloudPoint& p : surface) {
    const std::size_t object = p.object - 1;
    if (!world.objects[object].thing) {
      Unit& unit = stretches[{static_cast<std::int64_t>(object), cell(p.x), cell(p.y), cell(p.z)}];
      unit.object = object;
      unit.places.emplace_back(p.x, p.y, p.z);
    }
  }
  for (auto& [at, unit] : stretches) {
    units.push_back(std::move(unit));
  }
  return units;
}

/// The mistake about a unit; five numbers from `counter` on say which.
Mistake mistakeAbout(const Unit& unit, ClassId label, const RandomKey& key, std::uint64_t counter) {
  Mistake mistake{unit.object, label};
  if (!unit.places.empty()) {
    const auto place = static_cast<std::size_t>(uniform(key, counter + 3) * static_cast<double>(unit.places.size()));
    const double across = kSmallestPatch + (kLargestPatch - kSmallestPatch) * uniform(key, counter + 4);
    mistake.patch = Patch{unit.places[place], 0.5 * across};
  }
  return mistake;
}

}  // namespace

std::vector<std::vector<Mistake>> commonMistakes(const World& world, std::span<const CloudPoint> surface, double share,
                                                 std::uint64_t seed, std::size_t frames) {
  std::vector<std::vector<Mistake>> by_frame(frames);
  const std::vector<Common> common = commonClasses(world);
  const std::vector<Unit> units = share > 0 ? unitsOf(world, surface) : std::vector<Unit>();
  for (std::size_t u = 0; u < units.size(); ++u) {
    const RandomKey key = keyFor(seed, Purpose::kCommonConfusion, 0, u);
    constexpr std::uint64_t kNumbers = 8;  // a stretch of time, at most
    // Some time has passed when the drive begins, so that stretches do not all begin with it.
    auto begin = static_cast<std::int64_t>(-uniform(key, 0) * kLongestMistake);
    for (std::uint64_t k = 1; begin < static_cast<std::int64_t>(frames); ++k) {
      constexpr int kLengths = kLongestMistake - kShortestMistake + 1;
      const auto end = begin + kShortestMistake + static_cast<int>(uniform(key, kNumbers * k) * kLengths);
      const ClassId label = drawClass(common, world.objects[units[u].object].label, uniform(key, kNumbers * k + 2));
      if (uniform(key, kNumbers * k + 1) < share && label != 0) {
        const Mistake mistake = mistakeAbout(units[u], label, key, kNumbers * k);
        for (auto f = std::max<std::int64_t>(begin, 0); f < std::min(end, static_cast<std::int64_t>(frames)); ++f) {
          by_frame[static_cast<std::size_t>(f)].push_back(mistake);
        }
      }
      begin = end;
    }
  }
  return by_frame;
}

std::optional<ClassId> FrameMistakes::at(std::size_t object, int x, const Vec3& p_sensor) const {
  const Pose& T = T_world_sensor[T_world_sensor.size() > 1 ? static_cast<std::size_t>(x) : 0];
  for (const Mistake& mistake : patches) {
    if (mistake.object == object && (T * p_sensor - mistake.patch->center).norm() < mistake.patch->radius) {
      return mistake.label;
    }
  }
  return std::nullopt;
}

std::vector<Mistake> nameWholeObjects(std::span<const Mistake> mistakes, std::vector<ClassId>& object_labels) {
  std::vector<Mistake> patches;
  for (const Mistake& mistake : mistakes) {
    if (mistake.patch) {
      patches.push_back(mistake);
    } else {
      object_labels[mistake.object] = mistake.label;
    }
  }
  return patches;
}

}  // namespace hgg
