#include "sim/queries.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "sim/raycast.h"
#include "sim/world_surface.h"

namespace hgg {
namespace {

constexpr double kEnoughPoints = 50.0;
constexpr std::int64_t kEnoughFrames = 3;
constexpr double kAhead = 1.1;                      // of a superlative over the next
constexpr double kFarther = 1.5, kFartherBy = 0.5;  // of the next candidate of a relation, and m
constexpr double kNextTo = 1.5, kClosest = 5.0;     // m between surfaces
constexpr double kFar = kFarther * kClosest + 2.0;  // m: distances beyond this are all the same
constexpr double kFarthest = 1.15;                  // of the farthest over the next
constexpr std::size_t kRelationsPerClass = 5;

/// A thing of the world and what was seen of it.
struct Candidate {
  const WorldObject* object;
  std::vector<Vec3> surface;
  Bounds bounds;
  Belief shape;             // of the surface
  const TruthObject* seen;  // nullptr: never
  bool is_answer;           // seen well, and there to the end

  double height() const { return bounds.hi.z() - bounds.lo.z(); }
};

using Candidates = std::vector<Candidate>;

std::string nounOf(const WorldObject& object) {
  std::string noun = object.name == "trunk" ? "tree" : object.name;
  std::ranges::replace(noun, '-', ' ');
  return noun;
}

Candidate describe(const World& world, std::size_t index, const TruthObject* seen) {
  constexpr double kSpacing = 0.15;
  Candidate c{&world.objects[index], sampleObject(world, index, kSpacing), {}, {}, seen, false};
  for (const Vec3& p : c.surface) {
    c.bounds = join(c.bounds, {p, p});
  }
  c.shape = beliefFromPoints(c.surface);
  c.is_answer = seen != nullptr && !seen->gone && seen->belief.kappa >= kEnoughPoints && seen->frames >= kEnoughFrames;
  return c;
}

/// Things by class; without the classes of which some move by themselves.
std::map<ClassId, Candidates> candidatesByClass(const World& world, const std::vector<TruthObject>& seen) {
  std::map<std::int64_t, const TruthObject*> by_id;
  for (const TruthObject& object : seen) {
    by_id[object.id] = &object;
  }
  std::map<ClassId, Candidates> result;
  std::set<ClassId> moving;
  for (std::size_t i = 0; i < world.objects.size(); ++i) {
    const WorldObject& object = world.objects[i];
    if (object.thing) {
      const auto known = by_id.find(object.id);
      result[object.label].push_back(describe(world, i, known == by_id.end() ? nullptr : known->second));
    }
    if (object.dynamic) {
      moving.insert(object.label);
    }
  }
  for (const ClassId label : moving) {
    result.erase(label);
  }
  return result;
}

/// All that someone may mean by the noun of a class: a desk is a table, too.
std::vector<const Candidate*> meantBy(const std::map<ClassId, Candidates>& classes, ClassId label) {
  const std::string& name = classes.at(label).front().object->name;
  std::vector<const Candidate*> meant;
  for (const auto& [other, members] : classes) {
    if (other == label || (name == "table" && members.front().object->name == "desk")) {
      for (const Candidate& member : members) {
        meant.push_back(&member);
      }
    }
  }
  return meant;
}

/// The one with the highest value by the margin; nullptr when there is none.
template <typename Value>
const Candidate* clearlyFirst(const std::vector<const Candidate*>& candidates, double margin, Value value) {
  const auto first = std::ranges::max_element(candidates, {}, [&](const Candidate* c) { return value(*c); });
  for (const Candidate* other : candidates) {
    if (other != *first && value(*other) * margin > value(**first)) {
      return nullptr;
    }
  }
  return *first;
}

/// Clearly first in the world's geometry (`true_value`), and first in what was seen too (`seen_value`).
template <typename TrueValue, typename SeenValue>
const Candidate* superlative(const std::vector<const Candidate*>& meant, TrueValue true_value, SeenValue seen_value) {
  constexpr double kAheadSeen = 1.05;
  std::vector<const Candidate*> seen;
  std::ranges::copy_if(meant, std::back_inserter(seen), [](const Candidate* c) { return c->seen != nullptr; });
  const Candidate* first = clearlyFirst(meant, kAhead, true_value);
  const bool agreed = first != nullptr && first->is_answer && clearlyFirst(seen, kAheadSeen, seen_value) == first;
  return agreed ? first : nullptr;
}

double spread(const Belief& belief) { return std::sqrt(belief.cov.trace()); }

double boundsGap(const Bounds& a, const Bounds& b) { return (a.lo - b.hi).cwiseMax(b.lo - a.hi).cwiseMax(0.0).norm(); }

/// The points at which two things are nearest to each other.
std::pair<Vec3, Vec3> nearestPoints(const Candidate& a, const Candidate& b) {
  std::pair<Vec3, Vec3> nearest{a.surface.front(), b.surface.front()};
  double square = (nearest.first - nearest.second).squaredNorm();
  for (const Vec3& p : a.surface) {
    for (const Vec3& q : b.surface) {
      if ((p - q).squaredNorm() < square) {
        nearest = {p, q};
        square = (p - q).squaredNorm();
      }
    }
  }
  return nearest;
}

/// m between the surfaces of two things, no more than kFar.
double surfaceDistance(const Candidate& a, const Candidate& b) {
  if (boundsGap(a.bounds, b.bounds) >= kFar) {
    return kFar;
  }
  const auto [p, q] = nearestPoints(a, b);
  return std::min(kFar, (p - q).norm());
}

/// Whether a wall or the like stands between two things: no one would call them neighbours.
bool isBlocked(const World& world, const Candidate& a, const Candidate& b) {
  const auto [p, q] = nearestPoints(a, b);
  const double distance = (q - p).norm();
  return std::ranges::any_of(world.solids, [&](const Solid& solid) {
    if (world.objects[solid.object].thing || distance == 0.0) {
      return false;
    }
    const auto range = std::visit([&](const auto& s) { return intersect(s, {p, (q - p) / distance}); }, solid.shape);
    return range && *range < distance;
  });
}

double centerDistance(const Candidate& a, const Candidate& b) { return (a.shape.mean - b.shape.mean).norm(); }

/// The nearest of some anchors.
template <typename Distance>
double toNearest(const Candidate& c, const std::vector<const Candidate*>& anchors, Distance distance) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Candidate* anchor : anchors) {
    nearest = std::min(nearest, distance(c, *anchor));
  }
  return nearest;
}

struct Relation {
  const Candidate* target;
  double distance;
};

/// The one of `meant` that is clearly farthest from the anchor, by boxes and by centres.
const Candidate* clearlyFarthest(const std::vector<const Candidate*>& meant, const Candidate& anchor) {
  const auto distance = [&](const Candidate& c) { return boundsGap(c.bounds, anchor.bounds); };
  const Candidate* first = clearlyFirst(meant, kFarthest, distance);
  const bool agreed = first != nullptr && first->is_answer && clearlyFirst(meant, kFarthest, [&](const Candidate& c) {
                                                                return centerDistance(c, anchor);
                                                              }) == first;
  return agreed ? first : nullptr;
}

/// The one of `meant` that is clearly nearest to any of the anchors.
std::optional<Relation> clearlyNearest(const std::vector<const Candidate*>& meant,
                                       const std::vector<const Candidate*>& anchors) {
  std::vector<Relation> relations;
  for (const Candidate* c : meant) {
    relations.push_back({c, toNearest(*c, anchors, surfaceDistance)});
  }
  std::ranges::stable_sort(relations, {}, &Relation::distance);
  const auto first = relations.front();
  const bool is_clear = relations.size() > 1 && first.distance <= kClosest &&
                        relations[1].distance >= std::max(kFarther * first.distance, first.distance + kFartherBy);
  if (!is_clear || !first.target->is_answer) {
    return std::nullopt;
  }
  const double by_centers = toNearest(*first.target, anchors, centerDistance);
  const bool agreed = std::ranges::all_of(
      meant, [&](const Candidate* c) { return toNearest(*c, anchors, centerDistance) >= by_centers; });
  return agreed ? std::optional(first) : std::nullopt;
}

class Phrases {
 public:
  Phrases(const World& world, const std::map<ClassId, Candidates>& classes) : world_(world), classes_(classes) {}

  void addOnlyOne(ClassId label) {
    const auto meant = meantBy(classes_, label);
    if (meant.size() == 1 && meant.front()->is_answer) {
      add(label, "the " + nounOf(*meant.front()->object), meant.front());
    }
  }

  void addSuperlatives(ClassId label) {
    const auto meant = meantBy(classes_, label);
    if (meant.size() < 2) {
      return;
    }
    const std::string noun = nounOf(*classes_.at(label).front().object);
    const auto size = [](const Candidate& c) { return spread(c.shape); };
    const auto seen_size = [](const Candidate& c) { return spread(c.seen->belief); };
    add(label, "the largest " + noun, superlative(meant, size, seen_size));
    add(label, "the smallest " + noun,
        superlative(
            meant, [&](const Candidate& c) { return 1.0 / size(c); },
            [&](const Candidate& c) { return 1.0 / seen_size(c); }));
    add(label, "the tallest " + noun,
        superlative(
            meant, [](const Candidate& c) { return c.height(); },
            [](const Candidate& c) { return std::sqrt(c.seen->belief.cov(2, 2)); }));
  }

  void addRelations(ClassId label) {
    const auto meant = meantBy(classes_, label);
    std::size_t added = 0;
    for (const auto& [anchor_label, members] : classes_) {
      const auto anchors = meantBy(classes_, anchor_label);
      const bool is_same = std::ranges::any_of(anchors, [&](auto* a) { return std::ranges::count(meant, a) > 0; });
      const bool all_seen = std::ranges::all_of(anchors, [](auto* a) { return a->is_answer; });
      if (is_same || meant.size() < 2 || added >= kRelationsPerClass || (anchors.size() == 1 && !all_seen)) {
        continue;
      }
      const auto nearest = clearlyNearest(meant, anchors);
      if (nearest && isAnchored(*nearest, anchors) && (nearest->distance <= kNextTo || anchors.size() == 1)) {
        const char* relation = nearest->distance <= kNextTo ? " next to the " : " closest to the ";
        add(label, "the " + nounOf(*nearest->target->object) + relation + nounOf(*members.front().object),
            nearest->target);
        ++added;
      }
    }
  }

  void addFarthest(ClassId label) {
    const auto meant = meantBy(classes_, label);
    for (const auto& [anchor_label, members] : classes_) {
      const auto anchors = meantBy(classes_, anchor_label);
      if (meant.size() > 1 && anchors.size() == 1 && anchors.front()->is_answer && anchor_label != label) {
        add(label,
            "the " + nounOf(*classes_.at(label).front().object) + " farthest from the " +
                nounOf(*members.front().object),
            clearlyFarthest(meant, *anchors.front()));
      }
    }
  }

  std::vector<TruthQuery> take() { return std::move(queries_); }

 private:
  /// The anchor that makes the relation true must have been seen as well, with nothing between.
  bool isAnchored(const Relation& relation, const std::vector<const Candidate*>& anchors) const {
    return std::ranges::any_of(anchors, [&](const Candidate* anchor) {
      return anchor->is_answer && surfaceDistance(*relation.target, *anchor) <= relation.distance &&
             !isBlocked(world_, *relation.target, *anchor);
    });
  }

  /// The answer must be of the class that the phrase names, not only something that may be meant by it.
  void add(ClassId label, const std::string& text, const Candidate* target) {
    if (target != nullptr && target->object->label == label) {
      queries_.push_back({text, target->object->id, target->object->name});
    }
  }

  const World& world_;
  const std::map<ClassId, Candidates>& classes_;
  std::vector<TruthQuery> queries_;
};

}  // namespace

std::vector<TruthQuery> makeQueries(const Scene& scene, const std::vector<TruthObject>& seen) {
  const auto classes = candidatesByClass(scene.world, seen);
  Phrases phrases(scene.world, classes);
  for (const auto& [label, members] : classes) {
    phrases.addOnlyOne(label);
    phrases.addSuperlatives(label);
    phrases.addRelations(label);
    phrases.addFarthest(label);
  }
  return phrases.take();
}

}  // namespace hgg
