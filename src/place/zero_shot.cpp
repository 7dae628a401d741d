#include "place/zero_shot.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/se3.h"
#include "core/units.h"
#include "place/consistency.h"

namespace hgg {
namespace {

// Bounds of the work, chosen by hand: the figures of docs/experiments.md, "Zero-shot alignment", were measured with
// them.
constexpr std::size_t kMaxCandidates = 6000;
constexpr std::size_t kPlaces = 8;            // registered and weighed
constexpr std::size_t kPlacesWithPrior = 40;  // found where there is a prior; the first kPlaces within it go on
constexpr std::size_t kMostSurfaces = 1200;   // of b, registered

// Registration.
constexpr double kTilt = 2.5 * kDegree;  // standard deviation between the maps: two are the 5 degrees that are promised
constexpr double kFree = 1e-6;           // 1/m^2, 1/rad^2: information that only keeps the system regular
/// Scale of the robust kernel, standard deviations: that of alignment (docs/experiments.md, "Drag of a depth camera
/// indoors").
constexpr double kRobustScale = 2;
/// Surfaces share the errors of their maps: together they count as this many independent ones at most. The compromise
/// between LiDAR and camera in docs/experiments.md, "How much a leaf says along its surface"; not measured for two
/// maps.
constexpr double kEffectiveSurfaces = 400;
/// One round of correspondences finds surfaces within kWideGate survey distances, kNarrowRounds more within one. What a
/// surface may still be off is added to its extent, in survey distances. Chosen by hand, not measured.
constexpr double kWideGate = 2, kWideSlack = 0.5, kNarrowSlack = 0.05;
constexpr int kNarrowRounds = 3;

// Limits of acceptance; docs/experiments.md, "Why the verdict has these limits", says what each one refuses.
constexpr double kOddsAgainst = 1000;  // margin of the score over the number of places looked at
/// The same for things alone, which no surface gives the lie: the best of 1,012 wrong places of rooms reached 600
/// (docs/experiments.md, "Graphs without leaves").
constexpr double kOddsAgainstThings = 30'000;
constexpr int kThings = 4;             // matched: a place is made to fit two pairs, whose score is free
constexpr double kOverlap = 0.25;      // of the smaller map's upright surfaces: corners are alike everywhere
constexpr double kThingsThere = 0.55;  // of the things that both maps have surveyed must be in both
constexpr double kClearlyWorse = 0.5;  // of the best score: what a rival may reach
constexpr double kMaxDeviation = 0.3;  // m, standard deviation in the direction least known
constexpr double kMaxTurnDeviation = 1.0 * kDegree;
constexpr double kPriorPairs = 2;
/// Beyond these a deviation only means that nothing holds the place: no figure to report.
constexpr double kUnheld = 100, kUnheldTurn = 180 * kDegree;  // m, rad
/// Information (1/m^2, 1/rad^2) that makes that of the pairs invertible; deviations of 1 / sqrt(1e-9) = 30 km.
constexpr double kInvertible = 1e-9;

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
  prior.information.diagonal() << kFree, kFree, kFree, square(1 / kTilt), square(1 / kTilt), kFree;
  return prior;
}

/// Things by where they are; their extents depend on the view.
GaussianPair thingGaussian(const Landmark& a, const Landmark& b, double weight) {
  return {b.mean, square(b.sigma) / weight * Mat3::Identity(), a.mean, square(a.sigma) / weight * Mat3::Identity()};
}

/// The surface of a that is like `b` and nearest to p (its mean, in a), within `gate` (m); nullptr when there is none.
const Surface* nearestLike(const Comparison& c, const Surface& b, const Vec3& p, double gate,
                           std::vector<std::size_t>& near) {
  const Surface* nearest = nullptr;
  double least = std::numeric_limits<double>::max();
  c.index_a->near(p, gate, near);
  for (const std::size_t i : near) {
    const Surface& a = c.a.surfaces[i];
    if (!c.areLike(a.label, b.label)) {
      continue;
    }
    const double square_distance = (a.mean - p).squaredNorm();
    if (square_distance < least || (square_distance == least && &a < nearest)) {  // the first of several that coincide
      nearest = &a, least = square_distance;
    }
  }
  return nearest;
}

/// Surfaces of b, evenly spread, each with the nearest like one of a within `gate` (m). `slack` (m) is how far off they
/// may still be, on top of their own extent.
std::vector<GaussianPair> surfaceGaussians(const Comparison& c, const Pose& T_a_b, double gate, double slack) {
  const std::size_t stride = 1 + c.b.surfaces.size() / kMostSurfaces;
  std::vector<GaussianPair> pairs;
  std::vector<std::size_t> near;
  for (std::size_t k = 0; k < c.b.surfaces.size(); k += stride) {
    const Surface& b = c.b.surfaces[k];
    const Surface* nearest = nearestLike(c, b, T_a_b * b.mean, gate, near);
    if (nearest != nullptr) {
      pairs.push_back({b.mean, b.cov, nearest->mean, nearest->cov + square(slack) * Mat3::Identity()});
    }
  }
  return pairs;
}

/// Registers the things alone, then things and surfaces through a gate that closes.
Registration registerPlace(const Comparison& c, const Hypothesis& hypothesis) {
  const PoseBelief prior = uprightPrior(hypothesis.T_a_b);
  std::vector<GaussianPair> things;
  for (const Match& m : hypothesis.clique) {
    things.push_back(
        thingGaussian(c.a.landmarks[static_cast<std::size_t>(m.a)], c.b.landmarks[static_cast<std::size_t>(m.b)], 1));
  }
  Registration found = registerPairs(things, 1, prior, hypothesis.T_a_b, kRobustScale);
  for (int round = 0; round <= kNarrowRounds; ++round) {
    const double gate = (round == 0 ? kWideGate : 1) * c.survey_distance;
    const double slack = (round == 0 ? kWideSlack : kNarrowSlack) * c.survey_distance;
    auto pairs = c.by_things ? std::vector<GaussianPair>() : surfaceGaussians(c, found.T_map_body, gate, slack);
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

/// The place of the prior itself, with the things that meet there.
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

/// Standard deviations in the directions least known: translation at the centre of map b (m) and turn (rad). Things
/// alone say little of the tilt: that maps are upright is counted in.
std::pair<double, double> worstDeviations(const Registration& found, const Vec3& centre_b, bool by_things) {
  const Vec3 arm = found.T_map_body.linear() * centre_b;
  const Mat6 at_centre = tangentTransport(-arm);  // from a change at the centre to the tangent, about b's origin
  Mat6 known = found.information;
  if (by_things) {
    known += uprightPrior(found.T_map_body).information;
  }
  const Mat6 information = at_centre.transpose() * known * at_centre + kInvertible * Mat6::Identity();
  const Mat6 cov = information.inverse();
  const auto worst = [](const Mat3& m) {
    return std::sqrt(Eigen::SelfAdjointEigenSolver<Mat3>(m, Eigen::EigenvaluesOnly).eigenvalues()[2]);
  };
  return {worst(cov.topLeftCorner<3, 3>()), worst(cov.bottomRightCorner<3, 3>())};
}

Vec3 centreOf(const ComparisonSide& side) {
  Vec3 centre = Vec3::Zero();
  for (const Landmark& l : side.landmarks) {
    centre += l.mean / static_cast<double>(side.landmarks.size());
  }
  return centre;
}

/// How the deviations of things from each other compare with what is expected of two drives, as a factor of the
/// variance: graphs from one source agree far better. Inverse-gamma estimate, worth kPriorPairs pairs beforehand at a
/// factor of 1.
double varianceFactor(const std::vector<Candidate>& matches) {
  double sum = 0;
  for (const Candidate& m : matches) {
    sum += m.cost;
  }
  return (3 * kPriorPairs + sum) / (3 * (kPriorPairs + static_cast<double>(matches.size())));
}

/// Why the best place is not accepted; empty when it is.
std::string objection(const ZeroShot& z, const std::pair<double, double>& deviations, bool by_things) {
  const PlaceEvidence& e = z.evidence;
  const double max_turn = by_things ? kTilt : kMaxTurnDeviation;
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
  if (!(deviations.first <= kMaxDeviation && deviations.second <= max_turn)) {
    const bool is_held = deviations.first <= kUnheld && deviations.second <= kUnheldTurn;
    return is_held ? fmt::format("degenerate: known to {:.2f} m and {:.2f} degrees only", deviations.first,
                                 deviations.second / kDegree)
                   : "degenerate: not held in every direction";
  }
  return "";
}

/// ln of the number of places that were looked at. Every two candidates make one; within a prior there are no more than
/// lie apart from each other by kDistinctDistance and kDistinctTurn.
double lnPlaces(std::size_t candidates, const std::optional<PlacePrior>& prior) {
  const auto n = static_cast<double>(candidates);
  const double found = std::max(1.0, 0.5 * n * (n - 1));
  const double within =
      prior ? square(1 + prior->distance / kDistinctDistance) * (1 + prior->turn / kDistinctTurn) : found;
  return std::log(std::min(found, within));
}

}  // namespace

ZeroShot alignMaps(const Map& a, const Map& b, std::span<const SimilarClasses> similar,
                   const std::optional<PlacePrior>& prior) {
  ZeroShot result;
  const Comparison c(a, b, similar);
  const auto candidates = candidateMatches(c.a.landmarks, c.b.landmarks, c.similarity, kMaxCandidates);
  result.threshold = lnPlaces(candidates.size(), prior) + std::log(c.by_things ? kOddsAgainstThings : kOddsAgainst);
  const bool can_compare = c.survey_distance > 0 || (c.by_things && !prior);
  const std::vector<Place> places = can_compare ? findPlaces(c, candidates, prior) : std::vector<Place>();
  if (places.empty()) {
    result.reason =
        can_compare
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
  std::vector<Candidate> matches = best.matches;
  if (c.by_things) {
    const std::vector<Candidate> others = matchOtherNames(c, best.found.T_map_body, matches);
    matches.insert(matches.end(), others.begin(), others.end());
    std::ranges::sort(matches, {}, &Candidate::row);
  }
  for (const Candidate& m : matches) {
    result.pairs.emplace_back(c.a.nodes[c.a.things[static_cast<std::size_t>(m.row)]]->id,
                              c.b.nodes[c.b.things[static_cast<std::size_t>(m.column)]]->id);
  }
  std::pair<double, double> deviations = worstDeviations(best.found, centre_b, c.by_things);
  if (c.by_things) {
    const double factor = std::sqrt(std::min(1.0, varianceFactor(best.matches)));
    deviations.first *= factor, deviations.second *= factor;
  }
  result.reason = objection(result, deviations, c.by_things);
  result.accepted = result.reason.empty();
  if (result.accepted) {
    result.reason = fmt::format("{} things matched, {:.1f} missed, {:.0f} % of the surfaces found ({:.0f} % by chance)",
                                best.evidence.things_matched, best.evidence.things_missed,
                                100 * best.evidence.surface_share, 100 * best.evidence.chance_share);
  }
  return result;
}

}  // namespace hgg
