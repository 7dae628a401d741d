#include "map/tentative.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/units.h"
#include "map/patch.h"
#include "map/sight.h"
#include "map/stuff_surface.h"

namespace hgg {
namespace {

/// A thing that exists is found by one look in four or more: the limit of existence() (core/class_belief.h), where
/// three misses weigh as much as one find.
constexpr double kLeastFound = 0.25;
/// A thing that noise troubles much is found by one look in two.
constexpr double kOftenFound = 0.5;
/// Chance that something found by one look in four passes for one. Chosen by hand.
constexpr double kMistaken = 0.05;
/// Things made by noise in a drive, expected number. Chosen by hand: the test's strength is linear in its logarithm.
constexpr double kFalseThings = 0.01;
/// Looks at noise, and repeats among them, that a drive starts with: one in twenty until it has shown its own share.
constexpr double kPriorLooks = 20, kPriorRepeats = 1;
/// At most so many tentative things. Those go first that were seen last the longest ago, where each frame that found
/// one keeps it for a second more.
constexpr std::size_t kMostTentative = 1024;
constexpr Micros kKeptForFrame_us = 1'000'000;
/// A frame looks at one in so many of those that it has no cluster of, and counts that look as many times: bounds the
/// work.
constexpr std::size_t kLookedAtInTurn = 4;
/// How far around a cluster other ends of beams are looked for, beside its class's radius: a beam or two of a spinning
/// LiDAR to either side, rad.
constexpr double kBesideBeams = 0.5 * kDegree;
/// Class of a view in which a place was something else, whatever.
constexpr ClassId kOther = 0;

LocalObject objectOf(ClassId label, const Belief& belief) {
  LocalObject object;
  object.label = label;
  object.belief = belief;
  object.T_body_object = objectFrame(belief);
  object.leaves = {transform(object.T_body_object.inverse(), belief)};
  return object;
}

/// How the beams of the frame met a place; `sigma`: how far around it, m.
BeamCount beamsAt(const FrameBeams& beams, const Pose& T_sensor_frame, const Belief& place, double sigma) {
  const Mat3 R = T_sensor_frame.linear();
  return beams.image.beamsAt(T_sensor_frame * place.mean, R * place.cov * R.transpose(), sigma);
}

/// True when at least half of the beams that end around the cluster are its own. A grain of wrong labels on a surface
/// has the surface around it.
bool standsClear(const FrameBeams& beams, const Pose& T_sensor_body, const SmallCluster& cluster, double radius) {
  const double range = (T_sensor_body * cluster.belief.mean).norm();
  const BeamCount count = beamsAt(beams, T_sensor_body, cluster.belief, std::max(radius / 2, kBesideBeams * range));
  return count.ends * beams.per_counted <= 2 * cluster.belief.kappa;
}

/// True when the cluster comes closer than `reach` to the surface of an active, confirmed node of its class, or lies no
/// farther from its middle than it is long: more likely a piece of a thing that is hidden in part than one of its own.
bool isAtNode(const Map& map, ClassId label, const Belief& cluster, double reach, double gate) {
  return std::ranges::any_of(map.near(cluster.mean, gate), [&](NodeId id) {
    const MapNode& node = *map.find(id);
    if (node.stuff || node.label != label || !isConfirmed(node)) {
      return false;
    }
    const double length = 2 * kPatchSigmas * std::sqrt(std::max(node.belief.cov.trace(), 0.0));
    if ((cluster.mean - node.belief.mean).norm() < length) {
      return true;
    }
    const Belief here = transform(node.T_map_object.inverse(), cluster);
    return std::ranges::any_of(leavesOf(node),
                               [&](const Leaf& leaf) { return surfaceGap(unpackLeaf(leaf), here) < reach; });
  });
}

/// How often noise repeats at a place where it was once, a share of the looks.
double repeatsOfNoise(const TentativeThings& things) {
  const double share = (things.repeats_of_noise + kPriorRepeats) / (things.looks_at_noise + kPriorLooks);
  return std::min(share, 0.9 * kLeastFound);  // beyond it nothing tells them apart
}

/// Log likelihood ratio of a thing against noise, from the finds after the first stretch and all misses.
double evidenceOf(const TentativeThing& thing, double noise) {
  return thing.found_again * std::log(kLeastFound / noise) + thing.missed * std::log((1 - kLeastFound) / (1 - noise));
}

/// True when it is found clearly more often than by one look in four, as what stands at a border of two things is,
/// whose points now and then take the other's label.
bool isFoundOften(const TentativeThing& thing) {
  return thing.found * std::log(kOftenFound / kLeastFound) +
             thing.missed * std::log((1 - kOftenFound) / (1 - kLeastFound)) >
         -std::log(kMistaken);
}

/// The tentative things of one frame at work.
class Gathering {
 public:
  Gathering(const Map& map, const FrameBeams& beams, double weight, const ClassTable& classes, const Config& config,
            Micros utime_us)
      : map_(map), beams_(beams), weight_(weight), classes_(classes), config_(config), utime_us_(utime_us) {
    things_ = map.tentative();
    is_found_.resize(things_.list.size(), false);
    is_object_ = is_found_;
    for (std::size_t k = 0; k < things_.list.size(); ++k) {
      by_class_[things_.list[k].label].push_back(k);
    }
  }

  void add(ClassId label, const Belief& cluster, double radius) {
    std::vector<std::size_t>& same = by_class_[label];
    std::size_t nearest = things_.list.size();
    double least = radius;
    for (const std::size_t k : same) {
      const Belief& other = things_.list[k].belief;
      if ((other.mean - cluster.mean).squaredNorm() < square(config_.alignment.gate)) {
        const double gap = surfaceGap(other, cluster);
        nearest = gap < least && map_.isActive(things_.list[k].anchor) ? k : nearest;
        least = std::min(least, gap);
      }
    }
    if (nearest == things_.list.size()) {
      same.push_back(nearest);
      things_.list.push_back({label, cluster, map_.keyframes().current(), weight_, 0, 0, 1, utime_us_, utime_us_});
      things_.begun += 1;
      is_found_.push_back(true), is_object_.push_back(false);
      return;
    }
    things_.list[nearest].belief = merge(things_.list[nearest].belief, cluster);
    find(nearest);
  }

  /// Ends those that the frame has an object of their class at: they are that object.
  void yieldTo(const LocalObject& object, const Pose& T_map_body, double radius) {
    const Belief here = transform(T_map_body, object.belief);
    for (const std::size_t k : by_class_[object.label]) {
      is_object_[k] = is_object_[k] || surfaceGap(things_.list[k].belief, here) < radius;
    }
  }

  /// Looks at those that the frame has no cluster of.
  void look() {
    const Pose T_sensor_map = beams_.T_map_sensor.inverse();
    // By the frame's time in a mixed order, so that no rate of frames leaves some of them out.
    const std::uint64_t turn = (static_cast<std::uint64_t>(utime_us_) * 0x9E3779B97F4A7C15ULL) >> 32;
    for (std::size_t k = turn % kLookedAtInTurn; k < things_.list.size(); k += kLookedAtInTurn) {
      TentativeThing& thing = things_.list[k];
      const ClassInfo* info = classes_.find(thing.label);
      if (is_found_[k] || is_object_[k] || info == nullptr || !map_.isActive(thing.anchor) ||
          (T_sensor_map * thing.belief.mean).squaredNorm() > square(config_.frame.range_max)) {
        continue;
      }
      Belief place = thing.belief;
      place.cov.diagonal().array() += square(info->cluster_radius / 4);
      const BeamCount count = beamsAt(beams_, T_sensor_map, place, info->cluster_radius / 4);
      thing.missed += kLookedAtInTurn * weight_ * (takenBy(count) + seenThroughBy(count));
    }
  }

  /// Takes out what has turned out to be noise or a thing.
  void decide(const Pose& T_map_body, std::vector<GrownThing>& grown) {
    const double noise = repeatsOfNoise(things_), enough = std::log(std::max(things_.begun, 1.0) / kFalseThings);
    const double once = std::log(kLeastFound / noise);
    std::size_t k = 0;
    std::erase_if(things_.list, [&](const TentativeThing& thing) {
      if (is_object_[k++]) {
        return true;
      }
      const ClassInfo* info = classes_.find(thing.label);
      const double evidence = evidenceOf(thing, noise);
      if (info == nullptr || evidence + std::min(thing.found, 1.0) * once < 0) {
        things_.looks_at_noise += thing.found_again + thing.missed;
        things_.repeats_of_noise += thing.found_again;
        return true;
      }
      if (evidence < enough || thing.belief.kappa < info->min_points || !isFoundOften(thing)) {
        return false;
      }
      ClassWeights views;
      addWeight(views, thing.label, thing.found);
      addWeight(views, kOther, thing.missed);
      grown.push_back({objectOf(thing.label, transform(T_map_body.inverse(), thing.belief)), std::move(views),
                       thing.frames, thing.first_us});
      return true;
    });
    if (things_.list.size() > kMostTentative) {
      const auto keptUntil = [](const TentativeThing& thing) {
        return thing.last_us + thing.frames * kKeptForFrame_us;
      };
      std::vector<Micros> kept(things_.list.size());
      std::ranges::transform(things_.list, kept.begin(), keptUntil);
      const auto last = kept.begin() + static_cast<std::ptrdiff_t>(kept.size() - kMostTentative);
      std::ranges::nth_element(kept, last);
      std::erase_if(things_.list, [&](const TentativeThing& thing) { return keptUntil(thing) < *last; });
      things_.list.resize(std::min(things_.list.size(), kMostTentative));  // of one frame, those begun first
    }
  }

  TentativeThings take() { return std::move(things_); }

 private:
  void find(std::size_t k) {
    TentativeThing& thing = things_.list[k];
    if (!is_found_[k]) {
      thing.found_again += thing.found + thing.missed >= kStretchOfWrongLabels ? weight_ : 0;
      thing.found += weight_, ++thing.frames, thing.last_us = utime_us_;
      is_found_[k] = true;
    }
  }

  const Map& map_;
  const FrameBeams& beams_;
  double weight_;
  const ClassTable& classes_;
  const Config& config_;
  Micros utime_us_;
  TentativeThings things_;
  std::vector<bool> is_found_, is_object_;  // in this frame
  std::map<ClassId, std::vector<std::size_t>> by_class_;
};

}  // namespace

SmallThings gatherSmallThings(const Map& map, const LocalGraph& local, const FrameBeams& beams, const Pose& T_map_body,
                              double weight, const ClassTable& classes, const Config& config) {
  Gathering gathering(map, beams, weight, classes, config, local.utime_us);
  const Pose T_sensor_body = beams.T_map_sensor.inverse() * T_map_body;
  const double per_range = config.creation.beam_factor * config.creation.beam_spacing_deg * kDegree;
  for (const SmallCluster& cluster : local.small) {
    const ClassInfo* info = classes.find(cluster.label);
    // What can move is large: few points of it are a piece of something near that moves, or far and somewhere else
    // soon.
    if (info == nullptr || info->dynamic || !standsClear(beams, T_sensor_body, cluster, info->cluster_radius)) {
      continue;
    }
    // As far as clustering would join them, had the cluster been seen together with all of the node.
    const double reach = std::max(kFragmentDistance * info->cluster_radius, per_range * cluster.belief.mean.norm());
    const Belief here = transform(T_map_body, cluster.belief);
    if (!isAtNode(map, cluster.label, here, reach, config.alignment.gate)) {
      gathering.add(cluster.label, here, info->cluster_radius);
    }
  }
  for (const LocalObject& object : local.objects) {
    const ClassInfo* info = object.stuff ? nullptr : classes.find(object.label);
    if (info != nullptr) {
      gathering.yieldTo(object, T_map_body, info->cluster_radius);
    }
  }
  SmallThings small;
  gathering.look();
  gathering.decide(T_map_body, small.grown);
  small.tentative = gathering.take();
  return small;
}

void moveThings(TentativeThings& things, const KeyframeMoves& moves) {
  for (TentativeThing& thing : things.list) {
    const auto move = std::ranges::lower_bound(moves, thing.anchor, {}, &KeyframeMoves::value_type::first);
    if (move != moves.end() && move->first == thing.anchor) {
      thing.belief = transform(move->second, thing.belief);
    }
  }
}

}  // namespace hgg
