#include "place/evidence.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/units.h"

namespace hgg {
namespace {

// Chosen by hand, but for kGate; the figures of docs/experiments.md, "Zero-shot alignment", were measured with them.
constexpr double kThingFound = 0.7;   // probability that a map that has surveyed the place of a thing has the thing
constexpr double kSameSurface = 0.3;  // survey distances: surfaces this near across are one
/// Squared Mahalanobis distance of matched things: three standard deviations, within which 97.1 % of true pairs lie
/// (chi-square, three degrees of freedom).
constexpr double kGate = 9;
constexpr double kAround = 10;                   // m, neighbourhood that says how common a class of things is
constexpr double kNearProbe = 3, kFarProbe = 5;  // survey distances, displacements at which chance is measured
constexpr int kDirections = 8;                   // of the displacements, near and far in turn
constexpr double kLeastShare = 0.01;             // shares are kept this far from 0 and 1: their logarithms are finite
/// A pair is held by both maps and a thing that is missed by one only, so that it counts as half a pair.
constexpr double kMissedWeight = 0.5;
/// Both maps see the same surfaces: half of the nodes seen say something new.
constexpr double kNewNodes = 0.5;
/// Things are of one size when their extents (standard deviations) differ by less than this, m, plus this share.
constexpr double kSizeSlack = 0.03, kSizeShare = 0.2;
// Bounds of the work: surfaces that are looked for, spread evenly.
constexpr std::size_t kWeighed = 1500;       // of each map
constexpr std::size_t kWeighedOfThing = 30;  // of each thing
constexpr std::size_t kProbes = 400;         // of one map, at each displacement

/// What a map has at the place of a surface of the other: no surface near it at all, a like surface, or others only.
enum class Surveyed : std::uint8_t { kUnseen, kFound, kMissing };

/// Looks in one map for what the other holds.
struct Search {
  const Comparison& c;
  bool of_b;  // looks in a for what b holds; else in b for what a holds
  Pose T_in_of;

  const ComparisonSide& of() const { return of_b ? c.b : c.a; }
  const ComparisonSide& in() const { return of_b ? c.a : c.b; }
  bool areLike(ClassId label_of, ClassId label_in) const {
    return of_b ? c.areLike(label_in, label_of) : c.areLike(label_of, label_in);
  }
  Surveyed lookFor(const Surface& s, std::vector<std::size_t>& near) const;
};

Surveyed Search::lookFor(const Surface& s, std::vector<std::size_t>& near) const {
  const Vec3 p = T_in_of * s.mean, normal = T_in_of.linear() * s.normal;
  (of_b ? *c.index_a : *c.index_b).near(p, c.survey_distance, near);
  for (const std::size_t i : near) {
    const Surface& other = in().surfaces[i];
    const Vec3 d = p - other.mean;
    const double across = std::min(std::abs(d.dot(normal)), std::abs(d.dot(other.normal)));
    if (across < kSameSurface * c.survey_distance && areLike(s.label, other.label)) {
      return Surveyed::kFound;
    }
  }
  return near.empty() ? Surveyed::kUnseen : Surveyed::kMissing;
}

/// For each thing the share of its leaves whose place the other map has surveyed without finding them, times the trust
/// in the thing.
std::vector<double> missedShares(const Search& search) {
  std::vector<double> shares;
  std::vector<std::size_t> near;
  const ComparisonSide& of = search.of();
  for (std::size_t t = 0; t < of.things.size(); ++t) {
    const auto [first, last] = of.surfaces_of[of.things[t]];
    const std::size_t stride = 1 + (last - first) / kWeighedOfThing;
    double missed = 0, looked_at = 0;
    for (std::size_t k = first; k < last; k += stride) {
      looked_at += 1;
      missed += search.lookFor(of.surfaces[k], near) == Surveyed::kMissing ? 1 : 0;
    }
    shares.push_back(of.trust[t] * missed / std::max(looked_at, 1.0));
  }
  return shares;
}

/// The same where there are no leaves: things whose place lies within what the other map's things are spread over.
std::vector<double> missedThings(const Search& search) {
  std::vector<double> shares;
  const ComparisonSide& of = search.of();
  for (std::size_t t = 0; t < of.things.size(); ++t) {
    const bool is_surveyed = isSurveyed(search.in().outline, search.T_in_of * of.landmarks[t].mean);
    shares.push_back(is_surveyed ? of.trust[t] : 0.0);
  }
  return shares;
}

/// Things of a that are like one of b around a place, per square metre: how easily one is there by chance.
double densityAround(const Comparison& c, const Vec3& p_a, ClassId label_b) {
  const auto count = std::count_if(c.a.landmarks.begin(), c.a.landmarks.end(), [&](const Landmark& l) {
    return c.areLike(l.label, label_b) && (l.mean - p_a).head<2>().norm() < kAround;
  });
  const double around = kPi * square(kAround);
  return static_cast<double>(count) / (c.by_things ? std::min(around, c.a.outline.room) : around);
}

/// What of a class of things was found and missed, by trust.
struct Tally {
  double found = 0, missed = 0;
  double expected() const { return found + kMissedWeight * missed; }
};

/// Share of the things that should be there and are, as a mean over the classes, weighted by the root of their number.
/// A place that was refurnished keeps its doors and windows, which must not outvote the chairs.
double shareByClass(const std::map<ClassId, Tally>& tallies) {
  double votes = 0, share = 0;
  for (const auto& [label, tally] : tallies) {
    const double expected = tally.expected();
    votes += std::sqrt(expected);
    share += expected > 0 ? tally.found / std::sqrt(expected) : 0;
  }
  return votes > 0 ? share / votes : 0;
}

/// What a match is worth, nats, before trust.
double gainOf(const Comparison& c, const Landmark& a, const Landmark& b, double cost) {
  const double variance = square(a.sigma) + square(b.sigma);
  const double chance = std::min(1.0, 2 * kPi * variance * densityAround(c, a.mean, b.label));
  return std::log(kThingFound * c.similarity(a.label, b.label) / chance) - 0.5 * cost;
}

void weighThings(const Comparison& c, const Pose& T_a_b, const std::vector<Candidate>& matches,
                 PlaceEvidence& evidence) {
  const auto missed = [&](const Search& search) { return c.by_things ? missedThings(search) : missedShares(search); };
  std::vector<double> missed_a = missed({c, false, T_a_b.inverse()}), missed_b = missed({c, true, T_a_b});
  std::map<ClassId, Tally> tallies;
  for (const Candidate& m : matches) {
    const auto i = static_cast<std::size_t>(m.row), j = static_cast<std::size_t>(m.column);
    const double trust = std::sqrt(c.a.trust[i] * c.b.trust[j]);
    evidence.thing_odds += trust * gainOf(c, c.a.landmarks[i], c.b.landmarks[j], m.cost);
    tallies[c.a.landmarks[i].label].found += trust;
    missed_a[i] = missed_b[j] = 0;
  }
  for (std::size_t i = 0; i < missed_a.size(); ++i) {
    tallies[c.a.landmarks[i].label].missed += missed_a[i];
  }
  for (std::size_t j = 0; j < missed_b.size(); ++j) {
    tallies[c.b.landmarks[j].label].missed += missed_b[j];
  }
  for (const auto& [label, tally] : tallies) {
    evidence.things_missed += tally.missed;
  }
  evidence.things_matched = static_cast<int>(matches.size());
  evidence.thing_share = shareByClass(tallies);
  evidence.thing_odds += evidence.things_missed * std::log(1 - kThingFound);
}

/// Counts of upright surfaces: all that were looked for, those whose place the other map has surveyed (`seen`), those
/// of stuff among these, those of them that it has, and the nodes they belong to. Surfaces of one node are not
/// independent, so that a node counts once as evidence.
struct Count {
  int all = 0, seen = 0, stuff_seen = 0, stuff_there = 0, stuff_nodes = 0;
  double seenShare() const { return all > 0 ? static_cast<double>(seen) / all : 0; }
};

Count countSurfaces(const Search& search, std::size_t at_most) {
  const ComparisonSide& of = search.of();
  const std::size_t stride = 1 + of.surfaces.size() / at_most;
  Count count;
  std::vector<std::size_t> near;
  for (std::size_t n = 0; n < of.nodes.size(); ++n) {
    const auto [first, last] = of.surfaces_of[n];
    const bool is_stuff = of.nodes[n]->stuff;
    const int seen_before = count.stuff_seen;
    for (std::size_t k = (first + stride - 1) / stride * stride; k < last; k += stride) {
      if (!of.surfaces[k].is_level) {
        const Surveyed surveyed = search.lookFor(of.surfaces[k], near);
        count.all += 1;
        count.seen += surveyed != Surveyed::kUnseen ? 1 : 0;
        count.stuff_seen += is_stuff && surveyed != Surveyed::kUnseen ? 1 : 0;
        count.stuff_there += is_stuff && surveyed == Surveyed::kFound ? 1 : 0;
      }
    }
    count.stuff_nodes += count.stuff_seen > seen_before ? 1 : 0;
  }
  return count;
}

double shareOf(int there, int seen) { return static_cast<double>(there) / std::max(seen, 1); }

/// The share that is found at displacements of a few survey distances. A street goes on and so do its façades: where
/// they are found a little farther on as well, finding them says little.
double chanceShare(const Comparison& c, const Pose& T_a_b) {
  int seen = 0, there = 0;
  for (int k = 0; k < kDirections; ++k) {
    const double angle = 2 * kPi * k / kDirections;
    Pose T = T_a_b;
    T.translation() +=
        (k % 2 == 0 ? kNearProbe : kFarProbe) * c.survey_distance * Vec3(std::cos(angle), std::sin(angle), 0);
    const Count count = countSurfaces({c, true, T}, kProbes);
    seen += count.stuff_seen, there += count.stuff_there;
  }
  return shareOf(there, seen);
}

/// n KL(share || chance), negative where the share is below chance.
double surpriseOf(double n, double share, double chance) {
  const double s = std::clamp(share, kLeastShare, 1 - kLeastShare),
               q = std::clamp(chance, kLeastShare, 1 - kLeastShare);
  const double divergence = s * std::log(s / q) + (1 - s) * std::log((1 - s) / (1 - q));
  return s > q ? n * divergence : -n * divergence;
}

void weighSurfaces(const Comparison& c, const Pose& T_a_b, PlaceEvidence& evidence) {
  const Count a = countSurfaces({c, false, T_a_b.inverse()}, kWeighed);
  const Count b = countSurfaces({c, true, T_a_b}, kWeighed);
  evidence.overlap = std::max(a.seenShare(), b.seenShare());
  evidence.surface_share = shareOf(a.stuff_there + b.stuff_there, a.stuff_seen + b.stuff_seen);
  evidence.chance_share = chanceShare(c, T_a_b);
  evidence.surface_odds =
      surpriseOf(kNewNodes * (a.stuff_nodes + b.stuff_nodes), evidence.surface_share, evidence.chance_share);
}

/// Share of a map's things that are matched, or whose place the other map's things are spread around.
double surveyedShare(const Search& search, const std::vector<Candidate>& matches) {
  const std::vector<Landmark>& things = search.of().landmarks;
  std::vector<bool> is_matched(things.size(), false);
  for (const Candidate& m : matches) {
    is_matched[static_cast<std::size_t>(search.of_b ? m.column : m.row)] = true;
  }
  double seen = 0;
  for (std::size_t t = 0; t < things.size(); ++t) {
    seen += is_matched[t] || isSurveyed(search.in().outline, search.T_in_of * things[t].mean) ? 1 : 0;
  }
  return seen / static_cast<double>(std::max<std::size_t>(things.size(), 1));
}

/// Pairs that lie within three standard deviations of each other at a transform, of those that `fits`.
template <typename Fits>
std::vector<Candidate> meetings(const Comparison& c, const Pose& T_a_b, const Fits& fits) {
  const std::vector<Landmark>& a = c.a.landmarks;
  std::vector<std::pair<double, std::size_t>> by_x;  // so that not every two things have to meet
  double sigma_a = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    by_x.emplace_back(a[i].mean.x(), i);
    sigma_a = std::max(sigma_a, a[i].sigma);
  }
  std::sort(by_x.begin(), by_x.end());
  std::vector<Candidate> candidates;
  for (std::size_t j = 0; j < c.b.landmarks.size(); ++j) {
    const Landmark& lb = c.b.landmarks[j];
    const Vec3 p = T_a_b * lb.mean;
    const double farthest = std::sqrt(kGate) * std::hypot(sigma_a, lb.sigma);
    for (auto it = std::lower_bound(by_x.begin(), by_x.end(), std::pair(p.x() - farthest, std::size_t{0}));
         it != by_x.end() && it->first <= p.x() + farthest; ++it) {
      const std::size_t i = it->second;
      const double cost = (p - a[i].mean).squaredNorm() / (square(a[i].sigma) + square(lb.sigma));
      if (cost < kGate && fits(i, j)) {
        candidates.push_back({static_cast<int>(i), static_cast<int>(j), cost});
      }
    }
  }
  return candidates;
}

}  // namespace

std::vector<Candidate> matchThings(const Comparison& c, const Pose& T_a_b) {
  const auto areLike = [&](std::size_t i, std::size_t j) {
    return c.areLike(c.a.landmarks[i].label, c.b.landmarks[j].label);
  };
  return assignSparse(meetings(c, T_a_b, areLike), kGate);
}

std::vector<Candidate> matchOtherNames(const Comparison& c, const Pose& T_a_b, const std::vector<Candidate>& matches) {
  std::vector<bool> taken_a(c.a.landmarks.size(), false), taken_b(c.b.landmarks.size(), false);
  for (const Candidate& m : matches) {
    taken_a[static_cast<std::size_t>(m.row)] = taken_b[static_cast<std::size_t>(m.column)] = true;
  }
  const auto areOfOneSize = [&](std::size_t i, std::size_t j) {
    const Landmark &a = c.a.landmarks[i], &b = c.b.landmarks[j];
    const double limit = kSizeSlack + kSizeShare * std::max(a.size.norm(), b.size.norm());
    return !taken_a[i] && !taken_b[j] && (a.size - b.size).norm() < limit;
  };
  return assignSparse(meetings(c, T_a_b, areOfOneSize), kGate);
}

PlaceEvidence weighPlace(const Comparison& c, const Pose& T_a_b, const std::vector<Candidate>& matches) {
  PlaceEvidence evidence;
  weighThings(c, T_a_b, matches, evidence);
  if (c.by_things) {
    evidence.overlap =
        std::max(surveyedShare({c, false, T_a_b.inverse()}, matches), surveyedShare({c, true, T_a_b}, matches));
  } else {
    weighSurfaces(c, T_a_b, evidence);
  }
  return evidence;
}

}  // namespace hgg
