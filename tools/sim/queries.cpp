#include "sim/queries.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
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

constexpr const char* kTree = "trunk";  // the class of which a map has only the trunk

/// A thing of the world and what was seen of it.
struct Candidate {
  const WorldObject* object;
  std::optional<std::size_t> crown;  // index into World::objects, when it is counted in
  std::vector<Vec3> surface;
  Bounds bounds;
  Belief shape;             // of the surface
  const TruthObject* seen;  // nullptr: never
  bool is_answer;           // seen well, and there to the end

  double height() const { return bounds.hi.z() - bounds.lo.z(); }
};

using Candidates = std::vector<Candidate>;
using Classes = std::map<ClassId, Candidates>;

std::string nounOf(const WorldObject& object) {
  std::string noun = object.name == kTree ? "tree" : object.name;
  std::ranges::replace(noun, '-', ' ');
  return noun;
}

void measureSurface(Candidate& c) {
  c.bounds = {};
  for (const Vec3& p : c.surface) {
    c.bounds = join(c.bounds, {p, p});
  }
  c.shape = beliefFromPoints(c.surface);
}

Candidate describe(const World& world, std::size_t index, const TruthObject* seen) {
  constexpr double kSpacing = 0.15;
  Candidate c{&world.objects[index], std::nullopt, sampleObject(world, index, kSpacing), {}, {}, seen, false};
  measureSurface(c);
  c.is_answer = seen != nullptr && !seen->gone && seen->belief.kappa >= kEnoughPoints && seen->frames >= kEnoughFrames;
  return c;
}

/// Whether anyone would say the name: "the other vehicle" is no English.
bool isNoun(const WorldObject& object) { return object.name != "other-vehicle"; }

/// Things by class; without the classes of which some move by themselves.
Classes candidatesByClass(const World& world, const std::vector<TruthObject>& seen) {
  std::map<std::int64_t, const TruthObject*> by_id;
  for (const TruthObject& object : seen) {
    by_id[object.id] = &object;
  }
  Classes result;
  std::set<ClassId> moving;
  for (std::size_t i = 0; i < world.objects.size(); ++i) {
    const WorldObject& object = world.objects[i];
    if (object.thing && isNoun(object)) {
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

/// The foliage at a trunk's upper end, the one most above it; nullopt when there is none.
std::optional<std::size_t> crownOf(const World& world, const Candidate& trunk) {
  constexpr double kTouch = 0.05;  // m
  const Vec3 top(trunk.shape.mean.x(), trunk.shape.mean.y(), trunk.bounds.hi.z());
  std::optional<std::size_t> crown;
  double nearest = std::numeric_limits<double>::infinity();
  for (const Solid& solid : world.solids) {
    const WorldObject& object = world.objects[solid.object];
    if (object.thing || !object.foliage) {
      continue;
    }
    const Bounds b = boundsOf(solid.shape);
    const bool is_over = (b.lo.array() <= top.array() + kTouch).all() && (b.hi.array() >= top.array()).all();
    const double aside = (solid.bound_center - top).head<2>().norm();
    if (is_over && aside < nearest) {
      crown = solid.object;
      nearest = aside;
    }
  }
  return crown;
}

/// The same with the crowns of the trees counted in: someone may mean them, though no map has them with the trunk.
Classes withCrowns(const World& world, Classes classes) {
  constexpr double kSpacing = 0.3;
  for (auto& [label, members] : classes) {
    for (Candidate& tree : members) {
      tree.crown = tree.object->name == kTree ? crownOf(world, tree) : std::nullopt;
      if (tree.crown) {
        const auto crown = sampleObject(world, *tree.crown, kSpacing);
        tree.surface.insert(tree.surface.end(), crown.begin(), crown.end());
        measureSurface(tree);
      }
    }
  }
  return classes;
}

/// All that someone may mean by the noun of a class: a desk may be called a table, too.
std::vector<const Candidate*> meantBy(const Classes& classes, ClassId label, bool desk_is_table) {
  const std::string& name = classes.at(label).front().object->name;
  std::vector<const Candidate*> meant;
  for (const auto& [other, members] : classes) {
    if (other == label || (desk_is_table && name == "table" && members.front().object->name == "desk")) {
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
  const auto nearest = nearestPoints(a, b);
  const Vec3 p = nearest.first, q = nearest.second;
  const double distance = (q - p).norm();
  return std::ranges::any_of(world.solids, [&](const Solid& solid) {
    const bool is_theirs = solid.object == a.crown || solid.object == b.crown;
    if (world.objects[solid.object].thing || is_theirs || distance == 0.0) {
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
  double next_distance = 0;  // of the next candidate
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
  if (relations.size() < 2) {
    return std::nullopt;
  }
  Relation first = relations.front();
  first.next_distance = relations[1].distance;
  const bool is_clear = first.distance <= kClosest &&
                        first.next_distance >= std::max(kFarther * first.distance, first.distance + kFartherBy);
  if (!is_clear || !first.target->is_answer) {
    return std::nullopt;
  }
  const double by_centers = toNearest(*first.target, anchors, centerDistance);
  const bool agreed = std::ranges::all_of(
      meant, [&](const Candidate* c) { return toNearest(*c, anchors, centerDistance) >= by_centers; });
  return agreed ? std::optional(first) : std::nullopt;
}

/// One way to understand the nouns of a phrase.
struct Reading {
  const Classes* classes;     // trees with or without their crowns
  bool anchor_desk_is_table;  // "next to the table" may mean a desk
};

/// All readings that differ; the plain one first.
std::vector<Reading> readingsOf(const Classes& classes, const Classes& crowned) {
  const auto has = [&](const std::string& name) {
    return std::ranges::any_of(classes, [&](const auto& c) { return c.second.front().object->name == name; });
  };
  std::vector<Reading> readings{{&classes, false}};
  if (has("desk")) {
    readings.push_back({&classes, true});
  }
  if (has(kTree)) {
    for (std::size_t i = 0, plain = readings.size(); i < plain; ++i) {
      readings.push_back({&crowned, readings[i].anchor_desk_is_table});
    }
  }
  return readings;
}

/// A query, or nothing: the answer must be of the class that the phrase names, not only something that may be meant by
/// it.
void add(std::vector<TruthQuery>& queries, ClassId label, const std::string& text, const Candidate* target) {
  if (target != nullptr && target->object->label == label) {
    queries.push_back({text, target->object->id, target->object->name});
  }
}

/// The queries that every reading gives with the same answer.
template <typename QueriesOf>
std::vector<TruthQuery> agreed(const std::vector<Reading>& readings, QueriesOf queries_of) {
  std::vector<TruthQuery> queries = queries_of(readings.front());
  for (std::size_t i = 1; i < readings.size(); ++i) {
    const std::vector<TruthQuery> others = queries_of(readings[i]);
    std::erase_if(queries, [&](const TruthQuery& query) {
      return std::ranges::none_of(
          others, [&](const TruthQuery& other) { return other.text == query.text && other.target == query.target; });
    });
  }
  return queries;
}

std::vector<TruthQuery> onlyOne(const Classes& classes, ClassId label) {
  std::vector<TruthQuery> queries;
  const auto meant = meantBy(classes, label, true);
  if (meant.size() == 1 && meant.front()->is_answer) {
    add(queries, label, "the " + nounOf(*meant.front()->object), meant.front());
  }
  return queries;
}

/// Not of trees: what is true of trunks need not be of trees.
std::vector<TruthQuery> superlatives(const Classes& classes, ClassId label) {
  std::vector<TruthQuery> queries;
  const auto meant = meantBy(classes, label, true);
  const WorldObject& object = *classes.at(label).front().object;
  if (meant.size() < 2 || object.name == kTree) {
    return queries;
  }
  const auto size = [](const Candidate& c) { return spread(c.shape); };
  const auto seen_size = [](const Candidate& c) { return spread(c.seen->belief); };
  add(queries, label, "the largest " + nounOf(object), superlative(meant, size, seen_size));
  add(queries, label, "the smallest " + nounOf(object),
      superlative(
          meant, [&](const Candidate& c) { return 1.0 / size(c); },
          [&](const Candidate& c) { return 1.0 / seen_size(c); }));
  add(queries, label, "the tallest " + nounOf(object),
      superlative(
          meant, [](const Candidate& c) { return c.height(); },
          [](const Candidate& c) { return std::sqrt(c.seen->belief.cov(2, 2)); }));
  return queries;
}

/// The anchor that makes the relation true must have been seen as well, with nothing between.
bool isAnchored(const World& world, const Relation& relation, const std::vector<const Candidate*>& anchors) {
  return std::ranges::any_of(anchors, [&](const Candidate* anchor) {
    return anchor->is_answer && surfaceDistance(*relation.target, *anchor) <= relation.distance &&
           !isBlocked(world, *relation.target, *anchor);
  });
}

std::vector<TruthQuery> relations(const World& world, const Reading& reading, ClassId label) {
  std::vector<TruthQuery> queries;
  const auto meant = meantBy(*reading.classes, label, true);
  for (const auto& [anchor_label, members] : *reading.classes) {
    const auto anchors = meantBy(*reading.classes, anchor_label, reading.anchor_desk_is_table);
    const bool is_same = std::ranges::any_of(anchors, [&](auto* a) { return std::ranges::count(meant, a) > 0; });
    if (is_same || (anchors.size() == 1 && !anchors.front()->is_answer)) {
      continue;
    }
    const auto nearest = clearlyNearest(meant, anchors);
    if (!nearest || !isAnchored(world, *nearest, anchors)) {
      continue;
    }
    // Next to: no other one is, by the same measure. The closest one: to one thing only.
    const bool is_next = nearest->distance <= kNextTo && nearest->next_distance >= kNextTo + kFartherBy;
    if (is_next || anchors.size() == 1) {
      add(queries, label,
          "the " + nounOf(*nearest->target->object) + (is_next ? " next to the " : " closest to the ") +
              nounOf(*members.front().object),
          nearest->target);
    }
  }
  return queries;
}

std::vector<TruthQuery> farthest(const Reading& reading, ClassId label) {
  std::vector<TruthQuery> queries;
  const auto meant = meantBy(*reading.classes, label, true);
  for (const auto& [anchor_label, members] : *reading.classes) {
    const auto anchors = meantBy(*reading.classes, anchor_label, reading.anchor_desk_is_table);
    if (meant.size() > 1 && anchors.size() == 1 && anchors.front()->is_answer && anchor_label != label) {
      add(queries, label,
          "the " + nounOf(*reading.classes->at(label).front().object) + " farthest from the " +
              nounOf(*members.front().object),
          clearlyFarthest(meant, *anchors.front()));
    }
  }
  return queries;
}

}  // namespace

std::vector<TruthQuery> makeQueries(const Scene& scene, const std::vector<TruthObject>& seen) {
  const World& world = scene.world;
  const Classes classes = candidatesByClass(world, seen), crowned = withCrowns(world, classes);
  const std::vector<Reading> readings = readingsOf(classes, crowned);
  std::vector<TruthQuery> queries;
  const auto append = [&](const std::vector<TruthQuery>& more, std::size_t at_most) {
    queries.insert(queries.end(), more.begin(),
                   more.begin() + static_cast<std::ptrdiff_t>(std::min(more.size(), at_most)));
  };
  constexpr auto kAll = std::numeric_limits<std::size_t>::max();
  for (const auto& [known, members] : classes) {
    const ClassId label = known;
    append(onlyOne(classes, label), kAll);
    append(superlatives(classes, label), kAll);
    append(agreed(readings, [&](const Reading& reading) { return relations(world, reading, label); }),
           kRelationsPerClass);
    append(agreed(readings, [&](const Reading& reading) { return farthest(reading, label); }), kAll);
  }
  return queries;
}

}  // namespace hgg
