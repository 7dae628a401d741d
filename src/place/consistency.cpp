#include "place/consistency.h"

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "core/units.h"

namespace hgg {
namespace {

constexpr double kBend = 0.01;         // maps bend by this share of a distance; chosen by hand, not measured
constexpr double kTilt = 5 * kDegree;  // how far from upright a map may be: what alignMaps promises
/// A distance fixes a yaw to asin(tolerance / distance). Above this ratio (44 degrees) it says nothing of it. Chosen by
/// hand.
constexpr double kVaguestYaw = 0.7;
constexpr double kRounding = 1e-9;  // rad or nats; what is this close is equal
// Bounds of the work, chosen by hand: the figures of docs/experiments.md, "Zero-shot alignment", were measured with
// them.
constexpr std::size_t kSeeds = 1500;      // pairs around which cliques are sought, heaviest first
constexpr std::size_t kPlacesOfSeed = 3;  // yaws tried around a pair
constexpr std::size_t kTries = 40;        // places fitted for each one asked for
constexpr int kRefits = 4;                // rounds of fitting and gathering

double toleranceOf(double variance, double distance) {
  return kToleranceSigmas * std::sqrt(variance) + kBend * distance;
}

/// A candidate with what the inner loops need of its landmarks side by side.
struct Row {
  Vec3 a, b;
  double variance, weight;
  int index_a, index_b;
};

std::vector<Row> rowsOf(std::span<const Landmark> a, std::span<const Landmark> b, std::span<const Match> matches) {
  std::vector<Row> rows;
  rows.reserve(matches.size());
  for (const Match& m : matches) {
    const Landmark& la = a[static_cast<std::size_t>(m.a)];
    const Landmark& lb = b[static_cast<std::size_t>(m.b)];
    rows.push_back({la.mean, lb.mean, varianceOfDifference(la, lb), m.weight, m.a, m.b});
  }
  return rows;
}

/// Whether one rigid, upright transform can hold for both pairs, which makes them an edge of the consistency graph: the
/// horizontal distances agree within the uncertainty of the means, the differences of height within that and the tilt.
/// `distance` and `tolerance` (m) become those of the horizontal distances.
bool isEdge(const Row& p, const Row& q, double& distance, double& tolerance) {
  if (p.index_a == q.index_a || p.index_b == q.index_b) {
    return false;
  }
  const Vec3 da = q.a - p.a, db = q.b - p.b;
  const double length_a = da.head<2>().norm(), length_b = db.head<2>().norm();
  distance = std::max(length_a, length_b);
  tolerance = toleranceOf(p.variance + q.variance, distance);
  return std::abs(length_a - length_b) < tolerance && std::abs(da.z() - db.z()) < tolerance + kTilt * distance;
}

/// Yaws an edge admits, as an interval [from, to] with from in [-pi, pi).
struct YawInterval {
  double from, to, weight;
};

std::vector<YawInterval> yawsAround(const std::vector<Row>& rows, const Row& seed) {
  std::vector<YawInterval> intervals;
  double distance = 0, tolerance = 0;
  for (const Row& row : rows) {
    if (!isEdge(seed, row, distance, tolerance) || tolerance > kVaguestYaw * distance) {
      continue;
    }
    const Vec3 da = row.a - seed.a, db = row.b - seed.b;
    const double yaw = std::atan2(da.y(), da.x()) - std::atan2(db.y(), db.x());
    const double half_width = std::asin(tolerance / distance);
    const double from = std::remainder(yaw - half_width, 2 * kPi);
    intervals.push_back({from, from + 2 * half_width, row.weight});
  }
  return intervals;
}

/// A place to look at: a yaw about a pair.
struct Seed {
  double weight;
  std::size_t row;
  double yaw;
};

/// The yaw that lies in the heaviest set of intervals.
Seed heaviestYaw(const std::vector<YawInterval>& intervals, std::size_t row) {
  std::vector<std::pair<double, double>> events;  // yaw, change of the weight
  for (const YawInterval& i : intervals) {
    for (const double turn : {0.0, -2 * kPi}) {  // those that end beyond pi come round again
      if (i.to + turn > -kPi) {
        events.emplace_back(i.from + turn, i.weight);
        events.emplace_back(i.to + turn, -i.weight);
      }
    }
  }
  std::sort(events.begin(), events.end());
  Seed best{0, row, 0};
  double weight = 0;
  for (std::size_t k = 0; k + 1 < events.size(); ++k) {
    weight += events[k].second;
    if (weight > best.weight + kRounding && events[k].first >= -kPi - kRounding) {
      best.weight = weight;
      best.yaw = 0.5 * (events[k].first + events[k + 1].first);
    }
  }
  return best;
}

std::vector<Seed> findSeeds(const std::vector<Row>& rows) {
  std::vector<Seed> seeds;
  for (std::size_t r = 0; r < std::min(rows.size(), kSeeds); ++r) {
    std::vector<YawInterval> intervals = yawsAround(rows, rows[r]);
    for (std::size_t k = 0; k < kPlacesOfSeed && !intervals.empty(); ++k) {
      Seed seed = heaviestYaw(intervals, r);
      std::erase_if(intervals, [&](const YawInterval& i) {
        return std::abs(std::remainder(0.5 * (i.from + i.to) - seed.yaw, 2 * kPi)) <= 0.5 * (i.to - i.from) + kRounding;
      });
      seed.weight += rows[r].weight;
      seeds.push_back(seed);
    }
  }
  std::stable_sort(seeds.begin(), seeds.end(), [](const Seed& a, const Seed& b) { return a.weight > b.weight; });
  return seeds;
}

Pose poseAbout(const Row& row, double yaw) {
  Pose T = Pose::Identity();
  T.linear() = Eigen::AngleAxisd(yaw, Vec3::UnitZ()).toRotationMatrix();
  T.translation() = row.a - T.linear() * row.b;
  return T;
}

/// The one-to-one pairs that agree with a transform, the surest first served; `centre_b` is where it is best known.
Hypothesis gather(const std::vector<Row>& rows, const Pose& T, const Vec3& centre_b) {
  std::vector<Match> near;
  for (const Row& row : rows) {
    const Vec3 d = T * row.b - row.a;
    const double distance = (row.b - centre_b).head<2>().norm();
    const double tolerance = toleranceOf(row.variance, distance), miss = d.head<2>().norm();
    const double value = row.weight - 0.5 * square(miss) / (row.variance + square(kBend * distance));
    if (miss < tolerance && std::abs(d.z()) < tolerance + kTilt * distance && value > 0) {
      near.push_back({row.index_a, row.index_b, value});
    }
  }
  std::stable_sort(near.begin(), near.end(), [](const Match& p, const Match& q) { return p.weight > q.weight; });
  Hypothesis found;
  found.T_a_b = T;
  std::unordered_set<int> taken_a, taken_b;
  for (const Match& m : near) {
    if (!taken_a.contains(m.a) && !taken_b.contains(m.b)) {
      taken_a.insert(m.a), taken_b.insert(m.b);
      found.clique.push_back(m);
      found.weight += m.weight;
    }
  }
  std::sort(found.clique.begin(), found.clique.end(), [](const Match& p, const Match& q) { return p.a < q.a; });
  return found;
}

Vec3 centreOf(const Hypothesis& hypothesis, std::span<const Landmark> b) {
  Vec3 centre = Vec3::Zero();
  for (const Match& m : hypothesis.clique) {
    centre += b[static_cast<std::size_t>(m.b)].mean / static_cast<double>(hypothesis.clique.size());
  }
  return centre;
}

Pose fitClique(const Hypothesis& hypothesis, std::span<const Landmark> a, std::span<const Landmark> b) {
  std::vector<PointPair> points;
  for (const Match& m : hypothesis.clique) {
    const Landmark& la = a[static_cast<std::size_t>(m.a)];
    const Landmark& lb = b[static_cast<std::size_t>(m.b)];
    points.push_back({la.mean, lb.mean, 1 / varianceOfDifference(la, lb)});
  }
  return fitUpright(points);
}

/// Fits and gathers in turn from a seed; the transform is always one that was fitted.
Hypothesis grow(std::span<const Landmark> a, std::span<const Landmark> b, const std::vector<Row>& rows,
                const Seed& seed) {
  Hypothesis best;
  Hypothesis next = gather(rows, poseAbout(rows[seed.row], seed.yaw), rows[seed.row].b);
  for (int k = 0; k < kRefits && next.clique.size() > 1; ++k) {
    next = gather(rows, fitClique(next, a, b), centreOf(next, b));
    if (next.weight <= best.weight) {
      break;
    }
    best = next;
  }
  return best;
}

}  // namespace

std::vector<Hypothesis> findHypotheses(std::span<const Landmark> a, std::span<const Landmark> b,
                                       std::span<const Match> candidates, std::size_t count) {
  const std::vector<Row> rows = rowsOf(a, b, candidates);
  const std::vector<Seed> seeds = findSeeds(rows);
  std::vector<Hypothesis> found;
  for (std::size_t k = 0; k < std::min(seeds.size(), kTries * count); ++k) {
    found.push_back(grow(a, b, rows, seeds[k]));
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Hypothesis& p, const Hypothesis& q) { return p.weight > q.weight; });
  Vec3 centre_b = Vec3::Zero();
  for (const Landmark& l : b) {
    centre_b += l.mean / static_cast<double>(b.size());
  }
  std::vector<Hypothesis> distinct;
  for (Hypothesis& hypothesis : found) {
    const auto isKnown = [&](const Hypothesis& other) { return !areDistinct(hypothesis.T_a_b, other.T_a_b, centre_b); };
    if (distinct.size() < count && hypothesis.clique.size() > 1 &&
        std::none_of(distinct.begin(), distinct.end(), isKnown)) {
      distinct.push_back(std::move(hypothesis));
    }
  }
  return distinct;
}

Pose fitUpright(std::span<const PointPair> pairs) {
  double total = 0;
  Vec3 centre_a = Vec3::Zero(), centre_b = Vec3::Zero();
  for (const PointPair& p : pairs) {
    total += p.weight;
    centre_a += p.weight * p.a;
    centre_b += p.weight * p.b;
  }
  if (total <= 0) {
    return Pose::Identity();
  }
  centre_a /= total, centre_b /= total;
  double cosine = 0, sine = 0;
  for (const PointPair& p : pairs) {
    const Vec3 da = p.a - centre_a, db = p.b - centre_b;
    cosine += p.weight * (db.x() * da.x() + db.y() * da.y());
    sine += p.weight * (db.x() * da.y() - db.y() * da.x());
  }
  Pose T = Pose::Identity();
  T.linear() = Eigen::AngleAxisd(std::atan2(sine, cosine), Vec3::UnitZ()).toRotationMatrix();
  T.translation() = centre_a - T.linear() * centre_b;
  return T;
}

bool areDistinct(const Pose& T, const Pose& T_other, const Vec3& centre_b) {
  const Eigen::AngleAxisd turn(Mat3(T.linear() * T_other.linear().transpose()));
  return (T * centre_b - T_other * centre_b).norm() > kDistinctDistance || std::abs(turn.angle()) > kDistinctTurn;
}

}  // namespace hgg
