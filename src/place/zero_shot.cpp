#include "place/zero_shot.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/se3.h"
#include "core/units.h"

namespace hgg {
namespace {

constexpr std::size_t kMaxCandidates = 6000;
constexpr std::size_t kPlaces = 8;            // registered and weighed
constexpr std::size_t kPlacesWithPrior = 40;  // of which those within the prior are
constexpr double kTilt = 2.5 * kDegree;       // of either map, standard deviation
constexpr double kRobustScale = 2;            // standard deviations
constexpr std::size_t kMostSurfaces = 1200;
/// Surfaces share the errors of their maps: together they count as this many independent ones.
constexpr double kEffectiveSurfaces = 400;
/// On top of the places looked at. A place is made to fit two pairs, whose score is therefore free: kThings is for
/// that.
constexpr double kOddsAgainst = 1000;
constexpr int kThings = 4;  // matched
constexpr double kOverlap =
    0.25;  // of the upright surfaces of the smaller map: less is a corner that many places share
constexpr double kThingsThere = 0.55;  // of the things that both maps have surveyed must be in both
constexpr double kClearlyWorse = 0.5;  // of the best score
constexpr double kMaxDeviation = 0.3;  // m
constexpr double kMaxTurnDeviation = 1.0 * kDegree;
constexpr double kUnheld = 100;  // m; beyond it a deviation is no figure to report
constexpr double kUnheldTurn = 180 * kDegree;

/// A place that was registered and weighed.
struct Place {
  Registration found;
  std::vector<Candidate> matches;
  PlaceEvidence evidence;
};

// ------------------------------------------------------------------------------------------------ registration

/// Yaw and translation free (but for what keeps the system regular).
PoseBelief uprightPrior(const Pose& T) {
  PoseBelief prior;
  prior.T_map_body = T;
  prior.information.diagonal() << 1e-6, 1e-6, 1e-6, square(1 / kTilt), square(1 / kTilt), 1e-6;
  return prior;
}

/// Things by where they are; their extents depend on the view.
GaussianPair thingGaussian(const Landmark& a, const Landmark& b, double weight) {
  return {b.mean, square(b.sigma) / weight * Mat3::Identity(), a.mean, square(a.sigma) / weight * Mat3::Identity()};
}

/// Surfaces of b, evenly spread, with the nearest like one of a within `gate`. `slack` is how far off they may still
/// be, on top of their own extent.
std::vector<GaussianPair> surfaceGaussians(const Comparison& c, const SurfaceIndex& index, const Pose& T_a_b,
                                           double slack) {
  const std::size_t stride = 1 + c.b.surfaces.size() / kMostSurfaces;
  std::vector<GaussianPair> pairs;
  std::vector<std::size_t> near;
  for (std::size_t k = 0; k < c.b.surfaces.size(); k += stride) {
    const Surface& b = c.b.surfaces[k];
    const Vec3 p = T_a_b * b.mean;
    const Surface* nearest = nullptr;
    index.near(p, near);
    for (const std::size_t i : near) {
      const Surface& a = c.a.surfaces[i];
      if (c.areLike(a.label, b.label) &&
          (nearest == nullptr || (a.mean - p).squaredNorm() < (nearest->mean - p).squaredNorm())) {
        nearest = &a;
      }
    }
    if (nearest != nullptr) {
      pairs.push_back({b.mean, b.cov, nearest->mean, nearest->cov + square(slack) * Mat3::Identity()});
    }
  }
  return pairs;
}

/// Things alone, then things and surfaces through a gate that closes.
Registration registerPlace(const Comparison& c, const Hypothesis& hypothesis) {
  const PoseBelief prior = uprightPrior(hypothesis.T_a_b);
  std::vector<GaussianPair> things;
  for (const Match& m : hypothesis.clique) {
    things.push_back(
        thingGaussian(c.a.landmarks[static_cast<std::size_t>(m.a)], c.b.landmarks[static_cast<std::size_t>(m.b)], 1));
  }
  Registration found = registerPairs(things, 1, prior, hypothesis.T_a_b, kRobustScale);
  for (const bool is_wide : {true, false, false, false}) {
    auto pairs =
        surfaceGaussians(c, is_wide ? *c.wide_index_a : *c.index_a, found.T_map_body, (is_wide ? 0.5 : 0.05) * c.reach);
    const double weight = std::min(1.0, kEffectiveSurfaces / static_cast<double>(pairs.size() + 1));
    for (const Candidate& m : matchThings(c, found.T_map_body)) {
      pairs.push_back(thingGaussian(c.a.landmarks[static_cast<std::size_t>(m.row)],
                                    c.b.landmarks[static_cast<std::size_t>(m.column)], 1 / weight));
    }
    found = registerPairs(pairs, weight, prior, found.T_map_body, kRobustScale);
  }
  return found;
}

// ------------------------------------------------------------------------------------------------ verdict

bool isWithin(const PlacePrior& prior, const Pose& T_a_b) {
  const Pose off = T_a_b * prior.T_a_b.inverse();
  return (T_a_b * prior.centre_b - prior.T_a_b * prior.centre_b).norm() <= prior.distance && turnOf(off) <= prior.turn;
}

/// The place that odometry names, with the things that then meet.
Hypothesis expected(const Comparison& c, const PlacePrior& prior) {
  Hypothesis hypothesis;
  hypothesis.T_a_b = prior.T_a_b;
  for (const Candidate& m : matchThings(c, prior.T_a_b)) {
    hypothesis.clique.push_back({m.row, m.column, 1});
  }
  return hypothesis;
}

std::vector<Hypothesis> hypothesesOf(const Comparison& c, std::span<const Match> candidates,
                                     const std::optional<PlacePrior>& prior) {
  if (!prior) {
    return findHypotheses(c.a.landmarks, c.b.landmarks, candidates, kPlaces);
  }
  auto hypotheses = findHypotheses(c.a.landmarks, c.b.landmarks, candidates, kPlacesWithPrior);
  std::erase_if(hypotheses, [&](const Hypothesis& h) { return !isWithin(*prior, h.T_a_b); });
  hypotheses.resize(std::min(hypotheses.size(), kPlaces));
  hypotheses.push_back(expected(c, *prior));
  return hypotheses;
}

std::vector<Place> findPlaces(const Comparison& c, std::span<const Match> candidates,
                              const std::optional<PlacePrior>& prior) {
  std::vector<Place> places;
  for (const Hypothesis& hypothesis : hypothesesOf(c, candidates, prior)) {
    Place place;
    place.found = registerPlace(c, hypothesis);
    if (prior && !isWithin(*prior, place.found.T_map_body)) {
      continue;
    }
    place.matches = matchThings(c, place.found.T_map_body);
    place.evidence = weighPlace(c, place.found.T_map_body, place.matches);
    places.push_back(std::move(place));
  }
  std::stable_sort(places.begin(), places.end(),
                   [](const Place& p, const Place& q) { return p.evidence.odds() > q.evidence.odds(); });
  return places;
}

/// Standard deviations in the directions least known: translation at the centre of map b (m) and turn (rad).
std::pair<double, double> worstDeviations(const Registration& found, const Vec3& centre_b) {
  const Vec3 arm = found.T_map_body.linear() * centre_b;
  const Mat6 at_centre = tangentTransport(-arm);  // from a change at the centre to the tangent, about b's origin
  const Mat6 information = at_centre.transpose() * found.information * at_centre + 1e-9 * Mat6::Identity();
  const Mat6 cov = information.inverse();
  const auto worst = [](const Mat3& m) {
    return std::sqrt(Eigen::SelfAdjointEigenSolver<Mat3>(m, Eigen::EigenvaluesOnly).eigenvalues()[2]);
  };
  return {worst(cov.topLeftCorner<3, 3>()), worst(cov.bottomRightCorner<3, 3>())};
}

Vec3 centreOf(const ComparisonSide& view) {
  Vec3 centre = Vec3::Zero();
  for (const Landmark& l : view.landmarks) {
    centre += l.mean / static_cast<double>(view.landmarks.size());
  }
  return centre;
}

/// Why the best place is not to be trusted; empty when it is.
std::string objection(const ZeroShot& z, const std::pair<double, double>& deviations) {
  const PlaceEvidence& e = z.evidence;
  if (z.score <= z.threshold) {
    return fmt::format(
        "too little agrees: {} things matched, {:.1f} missed, {:.0f} % of the surfaces found ({:.0f} % by chance)",
        e.things_matched, e.things_missed, 100 * e.surface_share, 100 * e.chance_share);
  }
  if (e.things_matched < kThings) {
    return fmt::format("too few things in common: {} matched, {} needed", e.things_matched, kThings);
  }
  if (e.thing_share < kThingsThere) {
    return fmt::format("the things speak against it: {} matched, {:.1f} missed", e.things_matched, e.things_missed);
  }
  if (e.overlap < kOverlap) {
    return fmt::format("too little in common: {:.0f} % of the smaller map", 100 * e.overlap);
  }
  if (z.runner_up >= kClearlyWorse * z.score) {
    return fmt::format("ambiguous: another place scores {:.1f}", z.runner_up);
  }
  if (!(deviations.first <= kMaxDeviation && deviations.second <= kMaxTurnDeviation)) {
    const bool is_held = deviations.first <= kUnheld && deviations.second <= kUnheldTurn;
    return is_held ? fmt::format("degenerate: known to {:.2f} m and {:.2f} degrees only", deviations.first,
                                 deviations.second / kDegree)
                   : "degenerate: not held in every direction";
  }
  return "";
}

/// ln of the places that were looked at: every two candidates make one, and within a prior there are as many as differ.
double lnPlaces(std::size_t candidates, const std::optional<PlacePrior>& prior) {
  const auto n = static_cast<double>(candidates);
  const double found = std::max(1.0, 0.5 * n * (n - 1));
  const double within = prior ? square(1 + prior->distance) * (1 + prior->turn / (5 * kDegree)) : found;
  return std::log(std::min(found, within));
}

}  // namespace

ZeroShot alignMaps(const Map& a, const Map& b, std::span<const SimilarClasses> similar,
                   const std::optional<PlacePrior>& prior) {
  ZeroShot result;
  const Comparison c(a, b, similar);
  const auto candidates = candidateMatches(c.a.landmarks, c.b.landmarks, c.similarity, kMaxCandidates);
  result.threshold = lnPlaces(candidates.size(), prior) + std::log(kOddsAgainst);
  const std::vector<Place> places = c.reach > 0 ? findPlaces(c, candidates, prior) : std::vector<Place>();
  if (places.empty()) {
    result.reason =
        c.reach > 0
            ? fmt::format("no two pairs of things agree: {} and {} things, {} pairs of like class and size",
                          c.a.things.size(), c.b.things.size(), candidates.size())
            : fmt::format("no surveyed surface in common: {} and {} leaves", c.a.surfaces.size(), c.b.surfaces.size());
    return result;
  }
  const Place& best = places.front();
  const Vec3 centre_b = centreOf(c.b);
  for (const Place& place : places) {
    if (areDistinct(place.found.T_map_body, best.found.T_map_body, centre_b)) {
      result.runner_up = std::max(result.runner_up, place.evidence.odds());
    }
  }
  result.T_a_b = best.found.T_map_body;
  result.score = best.evidence.odds();
  result.evidence = best.evidence;
  for (const Candidate& m : best.matches) {
    result.pairs.emplace_back(c.a.nodes[c.a.things[static_cast<std::size_t>(m.row)]]->id,
                              c.b.nodes[c.b.things[static_cast<std::size_t>(m.column)]]->id);
  }
  result.reason = objection(result, worstDeviations(best.found, centre_b));
  result.accepted = result.reason.empty();
  if (result.accepted) {
    result.reason = fmt::format("{} things matched, {:.1f} missed, {:.0f} % of the surfaces found ({:.0f} % by chance)",
                                best.evidence.things_matched, best.evidence.things_missed,
                                100 * best.evidence.surface_share, 100 * best.evidence.chance_share);
  }
  return result;
}

}  // namespace hgg
