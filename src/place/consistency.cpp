#include "place/consistency.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <unordered_set>

#include "core/units.h"

namespace hgg {
namespace {

constexpr double kDeviations = 2.5;    // tolerance of a coordinate, standard deviations
constexpr double kBend = 0.01;         // maps bend by this share of a distance
constexpr double kTilt = 5 * kDegree;  // how far from upright either map may be
constexpr double kDistinct = 1.0;      // m
constexpr double kDistinctYaw = 5 * kDegree;
constexpr std::size_t kSeeds = 1500;  // pairs that cliques are sought around, heaviest first
constexpr std::size_t kPlacesOfSeed = 3;
constexpr std::size_t kTries = 40;  // places fitted for each one asked for
constexpr int kRefits = 4;
constexpr std::size_t kLabels = 65536;
constexpr std::size_t kNeighbors = 3;   // of its own class, that tell a landmark from others
constexpr double kAlikeDistance = 0.3;  // m, of neighbours' distances, seen in two maps
constexpr double kAlikeSize = 0.2;      // of the size, seen in two maps

double varianceOf(const Landmark& a, const Landmark& b) { return square(a.sigma) + square(b.sigma); }

double toleranceOf(double variance, double distance) { return kDeviations * std::sqrt(variance) + kBend * distance; }

/// The ground that landmarks spread over, m^2: their bounding box, at least a few metres a side.
double areaOf(std::span<const Landmark> landmarks) {
  Eigen::AlignedBox2d box;
  for (const Landmark& l : landmarks) {
    box.extend(Eigen::Vector2d(l.mean.head<2>()));
  }
  return box.isEmpty() ? 1 : (box.sizes().array() + 3.0).prod();
}

/// Number of landmarks of each label, by label.
std::vector<std::pair<ClassId, double>> countLabels(std::span<const Landmark> landmarks) {
  std::vector<std::pair<ClassId, double>> counts;
  for (const Landmark& l : landmarks) {
    const auto it = std::find_if(counts.begin(), counts.end(), [&](const auto& c) { return c.first == l.label; });
    it == counts.end() ? void(counts.emplace_back(l.label, 1)) : void(++it->second);
  }
  return counts;
}

/// Pairs of like class and size, one landmark of b at a time: there may be too many to hold.
class Pairing {
 public:
  Pairing(std::span<const Landmark> a, std::span<const Landmark> b, const Similarity& similarity);

  /// Landmarks of a that b's may be, ascending.
  void partnersOf(std::size_t j, std::vector<std::size_t>& partners);
  double weightOf(std::size_t i, std::size_t j) const { return std::log(oddsOf(i, j)); }

 private:
  /// Area over the area in which a rival is found by chance, as far as the classes are alike.
  double oddsOf(std::size_t i, std::size_t j) const {
    return room_[a_[i].label] / (kPi * square(kDeviations) * varianceOf(a_[i], b_[j]));
  }
  /// 2-Wasserstein distance of the extents with place and yaw taken out, against their size.
  bool isAlike(std::size_t i, std::size_t j) const {
    const double limit = std::max(0.6 * std::max(size_a_[i], size_b_[j]), a_[i].sigma + b_[j].sigma);
    return (a_[i].size - b_[j].size).squaredNorm() < square(limit);
  }

  std::span<const Landmark> a_, b_;
  const Similarity& similarity_;
  std::vector<std::pair<ClassId, double>> counts_;
  double area_;
  std::vector<double> size_a_, size_b_;
  std::vector<double> room_;  // m^2 a rival of the landmark of b at hand, by label of a; 0 for none
};

Pairing::Pairing(std::span<const Landmark> a, std::span<const Landmark> b, const Similarity& similarity)
    : a_(a), b_(b), similarity_(similarity), counts_(countLabels(a)), area_(areaOf(a)), room_(kLabels, 0.0) {
  const auto sizeOf = [](const Landmark& l) { return l.size.norm(); };
  std::transform(a.begin(), a.end(), std::back_inserter(size_a_), sizeOf);
  std::transform(b.begin(), b.end(), std::back_inserter(size_b_), sizeOf);
}

void Pairing::partnersOf(std::size_t j, std::vector<std::size_t>& partners) {
  double rivals = 0;
  for (const auto& [label, count] : counts_) {
    rivals += similarity_(label, b_[j].label) > 0 ? count : 0;
  }
  for (const auto& [label, count] : counts_) {
    room_[label] = rivals > 0 ? area_ * similarity_(label, b_[j].label) / rivals : 0;
  }
  partners.clear();
  for (std::size_t i = 0; i < a_.size(); ++i) {
    if (oddsOf(i, j) > 1 && isAlike(i, j)) {
      partners.push_back(i);
    }
  }
}

/// How many each may have, at least one, so that all have `limit` together: whoever has fewer leaves the rest to
/// others.
std::size_t shareOf(std::vector<std::size_t> counts, std::size_t limit) {
  std::sort(counts.begin(), counts.end());
  std::size_t left = limit;
  for (std::size_t k = 0; k < counts.size(); ++k) {
    const std::size_t share = left / (counts.size() - k);
    if (counts[k] > share) {
      return std::max<std::size_t>(share, 1);
    }
    left -= counts[k];
  }
  return std::max<std::size_t>(limit, 1);
}

/// Horizontal distances to the nearest landmarks of the same label, ascending.
using Neighborhood = std::array<double, kNeighbors>;

std::vector<Neighborhood> neighborhoods(std::span<const Landmark> landmarks) {
  std::vector<Neighborhood> all;
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    Neighborhood nearest;
    nearest.fill(std::numeric_limits<double>::max());
    for (std::size_t j = 0; j < landmarks.size(); ++j) {
      const double distance = (landmarks[i].mean - landmarks[j].mean).head<2>().squaredNorm();
      if (i != j && distance < nearest.back() && landmarks[i].label == landmarks[j].label) {
        nearest.back() = distance;
        std::inplace_merge(nearest.begin(), nearest.end() - 1, nearest.end());
      }
    }
    std::transform(nearest.begin(), nearest.end(), nearest.begin(), [](double d) { return std::sqrt(d); });
    all.push_back(nearest);
  }
  return all;
}

/// How little two landmarks of like class look like one, by size and by what stands around them, which may be missing.
double unlikeness(const Landmark& a, const Landmark& b, const Neighborhood& around_a, const Neighborhood& around_b) {
  double sum = std::min(1.0, (a.size - b.size).norm() / (kAlikeSize * std::max(a.size.norm(), b.size.norm()) + 1e-9));
  for (std::size_t k = 0; k < kNeighbors; ++k) {
    sum += std::min(1.0, std::abs(around_a[k] - around_b[k]) / kAlikeDistance);
  }
  return sum;
}

template <typename Unlikeness>
void keepMostAlike(std::vector<std::size_t>& partners, std::size_t count, const Unlikeness& unlikenessOf) {
  std::vector<std::pair<double, std::size_t>> ranking;
  ranking.reserve(partners.size());
  for (const std::size_t i : partners) {
    ranking.emplace_back(unlikenessOf(i), i);
  }
  partners.resize(count);
  std::partial_sort(ranking.begin(), ranking.begin() + static_cast<std::ptrdiff_t>(count), ranking.end());
  std::transform(ranking.begin(), ranking.begin() + static_cast<std::ptrdiff_t>(count), partners.begin(),
                 [](const auto& ranked) { return ranked.second; });
  std::sort(partners.begin(), partners.end());
}

/// The candidates as the inner loop wants them.
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
    rows.push_back({la.mean, lb.mean, varianceOf(la, lb), m.weight, m.a, m.b});
  }
  return rows;
}

/// Whether two pairs can be of one rigid, upright transform: horizontal distances agree within the beliefs, differences
/// of height within the beliefs and 5 degrees of tilt; an edge of the consistency graph. `tolerance` and `distance` are
/// of the horizontal ones.
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
    if (!isEdge(seed, row, distance, tolerance) || tolerance > 0.7 * distance) {
      continue;  // the latter say nothing of the yaw
    }
    const Vec3 da = row.a - seed.a, db = row.b - seed.b;
    const double yaw = std::atan2(da.y(), da.x()) - std::atan2(db.y(), db.x());
    const double reach = std::asin(tolerance / distance);
    const double from = std::remainder(yaw - reach, 2 * kPi);
    intervals.push_back({from, from + 2 * reach, row.weight});
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
    for (const double turn : {0.0, -2 * kPi}) {  // those that reach beyond pi come round again
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
    if (weight > best.weight + 1e-9 && events[k].first >= -kPi - 1e-9) {
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
        return std::abs(std::remainder(0.5 * (i.from + i.to) - seed.yaw, 2 * kPi)) <= 0.5 * (i.to - i.from) + 1e-9;
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
    points.push_back({la.mean, lb.mean, 1 / varianceOf(la, lb)});
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

std::vector<Match> candidateMatches(std::span<const Landmark> a, std::span<const Landmark> b,
                                    const Similarity& similarity, std::size_t limit) {
  Pairing pairing(a, b, similarity);
  std::vector<std::size_t> partners, counts;
  for (std::size_t j = 0; j < b.size(); ++j) {
    pairing.partnersOf(j, partners);
    counts.push_back(partners.size());
  }
  const std::size_t share = shareOf(counts, limit);
  const bool is_scarce = std::any_of(counts.begin(), counts.end(), [&](std::size_t n) { return n > share; });
  const std::vector<Neighborhood> around_a = is_scarce ? neighborhoods(a) : std::vector<Neighborhood>();
  const std::vector<Neighborhood> around_b = is_scarce ? neighborhoods(b) : std::vector<Neighborhood>();
  std::vector<Match> matches;
  for (std::size_t j = 0; j < b.size(); ++j) {
    pairing.partnersOf(j, partners);
    if (partners.size() > share) {
      keepMostAlike(partners, share, [&](std::size_t i) {
        return unlikeness(a[i], b[j], around_a[i], around_b[j]) + (a[i].label == b[j].label ? 0 : 1);
      });
    }
    for (const std::size_t i : partners) {
      matches.push_back({static_cast<int>(i), static_cast<int>(j), pairing.weightOf(i, j)});
    }
  }
  std::stable_sort(matches.begin(), matches.end(), [](const Match& p, const Match& q) { return p.weight > q.weight; });
  matches.resize(std::min(matches.size(), limit));
  return matches;
}

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
  return (T * centre_b - T_other * centre_b).norm() > kDistinct || std::abs(turn.angle()) > kDistinctYaw;
}

}  // namespace hgg
