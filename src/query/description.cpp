#include "query/description.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

namespace hgg {
namespace {

// How sharply people keep to what they say. By hand, then on the tuning part of the language scans (docs/language.md).
constexpr double kPerRange = 3.5;           // of leftmost, topmost: nats over the range of the peers
constexpr double kPerRank = 1.6;            // of "second from the left": nats a rank off
constexpr double kPerLogMeasure = 2.0;      // "large": nats per e-fold of size
constexpr double kPerLogSuperlative = 6.0;  // "largest"
constexpr double kFloor = 0.03;
constexpr double kColourNoise = 18;  // L*a*b* units: mean colours are greyed by shade and by what lies on a thing
constexpr double kColourFloor = 0.15;

std::vector<double> mapThings(const QueryScene& scene, const Peers& peers,
                              const std::function<double(const SceneThing&)>& value) {
  std::vector<double> values;
  for (const int k : peers.things) {
    values.push_back(value(scene.things[static_cast<std::size_t>(k)]));
  }
  return values;
}

/// Those of the peers.
std::vector<double> ofPeers(const std::vector<double>& values, const Peers& peers) {
  std::vector<double> chosen;
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (peers.is_peer[k]) {
      chosen.push_back(values[k]);
    }
  }
  return chosen;
}

/// How many peers have a larger value.
double rankOf(double value, const std::vector<double>& peers) {
  return static_cast<double>(std::ranges::count_if(peers, [&](double v) { return v > value; }));
}

double measureOf(const SceneThing& t, Measure measure) {
  const Vec3 size = 2 * t.half;
  Vec3 sorted = size;
  std::sort(sorted.begin(), sorted.end());
  switch (measure) {
    case Measure::kSize:
      return std::log(sorted[1] * sorted[2]) / 2;  // the face one sees; the thickness of a picture says nothing
    case Measure::kHeight:
      return std::log(size.z());
    case Measure::kLength:
      return std::log(sorted[2]);
    case Measure::kWidth:
      return std::log(std::max(size.x(), size.y()) > 2 * size.z() ? sorted[1] : std::max(size.x(), size.y()));
  }
  return 0;
}

std::vector<double> sumOver(const std::vector<Gaze>& gazes, std::size_t n,
                            const std::function<std::vector<double>(const Vec2&)>& given) {
  std::vector<double> sum(n, 0.0);
  for (const Gaze& gaze : gazes) {
    const std::vector<double> one = given(gaze.direction);
    for (std::size_t k = 0; k < n; ++k) {
      sum[k] += gaze.probability * one[k];
    }
  }
  return sum;
}

/// In the middle: of the row, by rank and by place.
std::vector<double> likelihoodOfMiddle(const QueryScene& scene, const Peers& peers) {
  Vec3 mean = Vec3::Zero();
  double n = 0;
  for (std::size_t k = 0; k < peers.things.size(); ++k) {
    if (peers.is_peer[k]) {
      mean += scene.things[static_cast<std::size_t>(peers.things[k])].centre, n += 1;
    }
  }
  mean /= std::max(n, 1.0);
  return likelihoodOfRank(mapThings(scene, peers, [&](const SceneThing& t) { return -(t.centre - mean).norm(); }),
                          peers, {});
}

double wallGap(const QueryScene& scene, const SceneThing& t) {
  const Vec3 low = t.centre - t.half - scene.low, high = scene.high - t.centre - t.half;
  return std::max(0.0, std::min({low.x(), low.y(), high.x(), high.y()}));
}

double cornerGap(const QueryScene& scene, const SceneThing& t) {
  const Vec3 low = t.centre - t.half - scene.low, high = scene.high - t.centre - t.half;
  return std::hypot(std::max(0.0, std::min(low.x(), high.x())), std::max(0.0, std::min(low.y(), high.y())));
}

double aloneness(const QueryScene& scene, const Peers& peers, const SceneThing& t) {
  double nearest = 10;  // m
  for (const int k : peers.things) {
    const SceneThing& other = scene.things[static_cast<std::size_t>(k)];
    nearest = other.id == t.id ? nearest : std::min(nearest, gapBetween(t, other));
  }
  return nearest;
}

/// Typical colours of the words, L*a*b*, as things of a room have them on average.
const std::map<std::string, Vec3>& colours() {
  static const std::map<std::string, Vec3> kColours{
      {"white", {75, 0, 3}},    {"black", {18, 0, 0}},    {"gray", {48, 0, 0}},      {"grey", {48, 0, 0}},
      {"brown", {38, 10, 18}},  {"red", {38, 38, 22}},    {"green", {42, -22, 18}},  {"blue", {35, 0, -24}},
      {"yellow", {65, 3, 45}},  {"orange", {55, 30, 40}}, {"purple", {32, 20, -16}}, {"pink", {58, 28, 4}},
      {"beige", {62, 4, 16}},   {"tan", {55, 8, 22}},     {"silver", {60, 0, 0}},    {"gold", {55, 8, 40}},
      {"cream", {70, 2, 14}},   {"maroon", {25, 26, 12}}, {"navy", {20, 2, -18}},    {"teal", {40, -20, -6}},
      {"wooden", {45, 10, 22}}, {"wood", {45, 10, 22}},   {"violet", {35, 22, -18}}, {"turquoise", {50, -20, -8}}};
  return kColours;
}

}  // namespace

std::vector<double> likelihoodOfRank(const std::vector<double>& values, const Peers& peers, const Constraint& said) {
  std::vector<double> of_peers = ofPeers(values, peers);
  std::vector<double> likelihoods;
  if (of_peers.empty()) {
    return std::vector<double>(values.size(), 1.0);
  }
  const auto [low, high] = std::ranges::minmax(of_peers);
  const double range = std::max(high - low, 1e-6), n = static_cast<double>(of_peers.size());
  const double wanted = said.rank > 0 ? said.rank - 1 : n + said.rank;  // the last is -1
  for (const double v : values) {
    const double off =
        said.ranked ? kPerRank * std::abs(rankOf(v, of_peers) - wanted) : kPerRange * std::max(0.0, high - v) / range;
    likelihoods.push_back(kFloor + (1 - kFloor) * std::exp(-off));
  }
  return likelihoods;
}

std::vector<double> likelihoodOfPlace(const QueryScene& scene, const Peers& peers, const Constraint& said,
                                      const std::vector<Gaze>& gazes) {
  const auto ranked = [&](const std::function<double(const SceneThing&)>& value) {
    return likelihoodOfRank(mapThings(scene, peers, value), peers, said);
  };
  const auto along = [&](const Vec2& d) {
    return ranked([&](const SceneThing& t) { return t.centre.head<2>().dot(d); });
  };
  const auto decaying = [&](double scale, const std::function<double(const SceneThing&)>& distance) {
    return mapThings(scene, peers,
                     [&](const SceneThing& t) { return kFloor + (1 - kFloor) / std::pow(1 + distance(t) / scale, 2); });
  };
  const std::size_t n = peers.things.size();
  switch (said.place) {
    case Placement::kLeft:
      return sumOver(gazes, n, [&](const Vec2& gaze) { return along(leftOf(gaze)); });
    case Placement::kRight:
      return sumOver(gazes, n, [&](const Vec2& gaze) { return along(-leftOf(gaze)); });
    case Placement::kBack:
      return sumOver(gazes, n, [&](const Vec2& gaze) { return along(gaze); });
    case Placement::kFront:
      return sumOver(gazes, n, [&](const Vec2& gaze) { return along(-gaze); });
    case Placement::kMiddle:
      return likelihoodOfMiddle(scene, peers);
    case Placement::kTop:
      return ranked([](const SceneThing& t) { return t.centre.z(); });
    case Placement::kBottom:
      return ranked([](const SceneThing& t) { return -t.centre.z(); });
    case Placement::kFloor:
      return decaying(0.2, [&](const SceneThing& t) { return t.centre.z() - t.half.z() - scene.low.z(); });
    case Placement::kCorner:
      return decaying(0.7, [&](const SceneThing& t) { return cornerGap(scene, t); });
    case Placement::kWall:
      return decaying(0.3, [&](const SceneThing& t) { return wallGap(scene, t); });
    case Placement::kCentre:
      return decaying(1.0, [&](const SceneThing& t) { return (t.centre.head<2>() - scene.middle).norm(); });
    case Placement::kAlone:
      return ranked([&](const SceneThing& t) { return aloneness(scene, peers, t); });
  }
  return std::vector<double>(n, 1.0);
}

std::vector<double> likelihoodOfMeasure(const QueryScene& scene, const Peers& peers, const Constraint& said) {
  const double slope = said.is_superlative ? kPerLogSuperlative : kPerLogMeasure;
  std::vector<double> values =
      mapThings(scene, peers, [&](const SceneThing& t) { return said.sign * measureOf(t, said.measure); });
  const std::vector<double> of_peers = ofPeers(values, peers);
  const double most = of_peers.empty() ? 0 : std::ranges::max(of_peers);
  for (double& v : values) {
    v = kFloor + (1 - kFloor) * std::exp(-slope * std::max(0.0, most - v));
  }
  return values;
}

std::vector<double> likelihoodOfColour(const QueryScene& scene, const Peers& peers, const Constraint& said) {
  const std::size_t space = said.word.find_last_of(' ');
  const std::string name = space == std::string::npos ? said.word : said.word.substr(space + 1);
  const bool is_dark = said.word.starts_with("dark"), is_light = said.word.starts_with("light") || name == "bright";
  const auto typical = colours().find(name);
  std::vector<double> likelihoods = mapThings(scene, peers, [&](const SceneThing& t) {
    if (!t.lab || (typical == colours().end() && !is_dark && !is_light)) {
      return 1.0;
    }
    Vec3 wanted = typical != colours().end() ? typical->second : Vec3(40, 0, 0);
    wanted.x() += is_dark ? -15 : is_light ? 15 : 0;
    Vec3 off = *t.lab - wanted;
    if (typical == colours().end()) {
      off.tail<2>().setZero();
    }
    off.x() *= 0.6;  // shade changes lightness most
    return kColourFloor + (1 - kColourFloor) * std::exp(-0.5 * off.squaredNorm() / (kColourNoise * kColourNoise));
  });
  return likelihoods;
}

}  // namespace hgg
