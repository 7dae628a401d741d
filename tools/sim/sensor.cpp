#include "sim/sensor.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <optional>
#include <thread>

#include "core/units.h"

namespace hgg {
namespace {

constexpr double kEndless = std::numeric_limits<double>::infinity();
constexpr double kStepPast = 1e-6;  // m: a ray goes on behind the surface it met
constexpr int kMaxCrossings = 32;   // of foliage by one ray
/// What moves is posed this often during a sweep.
constexpr int kSlices = 16;

/// Numbers of one ray: 14 uniform ones and a Gaussian.
class RayNoise {
 public:
  enum Use : std::uint64_t { kFoliage, kGrazing, kDropout, kMixed, kMixedShare };

  RayNoise(const RandomKey& key, std::size_t ray) : key_(key), ray_(ray) {}
  double uniform(Use use) const { return hgg::uniform(key_, 16 * ray_ + use); }
  double gaussian() const { return hgg::gaussian(key_, 8 * ray_ + 7); }

 private:
  RandomKey key_;
  std::uint64_t ray_;
};

struct Echo {
  double range = 0;
  std::size_t object = 0;
  double incidence = 1;  // |cosine| between ray and surface normal
};

/// Follows a ray until something opaque or a leaf returns it. The way it gets through leaves is exponential.
std::optional<Echo> findEcho(const RayCaster& caster, const World& world, const Ray& ray, double foliage_depth,
                             const RayNoise& noise) {
  double at = 0, leaves_until = 0;
  double leaves_left = -foliage_depth * std::log(noise.uniform(RayNoise::kFoliage));
  std::size_t leaves_object = 0;
  for (int crossing = 0; crossing < kMaxCrossings; ++crossing) {
    const Ray rest{ray.origin + at * ray.direction, ray.direction};
    const auto hit = caster.cast(rest);
    const double next = hit ? at + hit->range : kEndless;
    const double through_leaves = std::max(std::min(next, leaves_until) - at, 0.0);
    if (leaves_left < through_leaves) {
      return Echo{at + leaves_left, leaves_object, 1.0};
    }
    leaves_left -= through_leaves;
    if (!hit) {
      return std::nullopt;
    }
    if (foliage_depth <= 0 || !world.objects[hit->object].foliage) {
      return Echo{next, hit->object, std::abs(hit->normal.dot(ray.direction))};
    }
    leaves_until = std::max(leaves_until, at + caster.leavesAt(rest, *hit));
    leaves_object = hit->object;
    at = next + kStepPast;
  }
  return std::nullopt;
}

bool isLost(const Echo& echo, const RangeErrors& errors, const RayNoise& noise) {
  const double full = std::sin(errors.grazing_deg * kDegree);
  return echo.range < errors.range_min || echo.range > errors.range_max ||
         noise.uniform(RayNoise::kDropout) < errors.dropout ||
         echo.incidence < full * noise.uniform(RayNoise::kGrazing);
}

/// A true range until addRangeErrors(): edges are looked for in true ranges.
void castInto(Scan& scan, std::size_t i, const RayCaster& caster, const World& world, const Ray& ray,
              const RangeErrors& errors, const RayNoise& noise) {
  const auto echo = findEcho(caster, world, ray, errors.foliage_depth, noise);
  if (!echo) {
    return;
  }
  scan.object[i] = static_cast<std::int32_t>(echo->object);
  scan.range[i] = isLost(*echo, errors, noise) ? 0.0F : static_cast<float>(echo->range);
}

/// The range farthest from this return's own among its four neighbours.
float acrossEdge(const RayGrid& grid, const std::vector<float>& ranges, int x, int y) {
  const float own = ranges[grid.at(x, y)];
  float across = own;
  for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
    const int nx = grid.wraps ? (x + dx + grid.width) % grid.width : x + dx, ny = y + dy;
    if (nx < 0 || nx >= grid.width || ny < 0 || ny >= grid.height) {
      continue;
    }
    const float range = ranges[grid.at(nx, ny)];
    if (range > 0 && std::abs(range - own) > std::abs(across - own)) {
      across = range;
    }
  }
  return across;
}

void addRangeErrors(Scan& scan, const std::vector<float>& truth, const RayGrid& grid, const RangeErrors& errors, int x,
                    int y, const RandomKey& key) {
  const std::size_t i = grid.at(x, y);
  if (truth[i] <= 0) {
    return;
  }
  const RayNoise noise(key, i);
  double range = truth[i];
  const double across = acrossEdge(grid, truth, x, y);
  if (std::abs(across - range) > kEdgeStep && noise.uniform(RayNoise::kMixed) < errors.mixed) {
    range += noise.uniform(RayNoise::kMixedShare) * (across - range);
    scan.mixed[i] = 1;
  }
  range += (errors.noise + errors.noise_per_m2 * range * range) * noise.gaussian();
  scan.range[i] = static_cast<float>(std::max(range, 0.0));
}

}  // namespace

double columnTime(const RayGrid& grid, const Exposure& exposure, int column) {
  return exposure.time - exposure.sweep * (1.0 - static_cast<double>(column + 1) / grid.width);
}

Scan measure(RayCaster& caster, const World& world, const RayGrid& grid, const RangeErrors& errors,
             const Trajectory& T_world_body, const Exposure& exposure, const RandomKey& key, int threads) {
  Scan scan{std::vector<float>(grid.size()), std::vector<std::int32_t>(grid.size(), -1),
            std::vector<std::uint8_t>(grid.size())};
  const int slices = exposure.sweep > 0 ? std::min(kSlices, grid.width) : 1;
  for (int slice = 0; slice < slices; ++slice) {
    const int begin = slice * grid.width / slices, end = (slice + 1) * grid.width / slices;
    caster.setTime(columnTime(grid, exposure, (begin + end) / 2));
    std::vector<Pose> T_world_sensor;
    for (int x = begin; x < (exposure.sweep > 0 ? end : begin + 1); ++x) {
      T_world_sensor.push_back(T_world_body(columnTime(grid, exposure, x)) * grid.T_body_sensor);
    }
    parallelFor(grid.height, threads, [&](int y) {
      for (int x = begin; x < end; ++x) {
        const std::size_t i = grid.at(x, y);
        const Pose& T = T_world_sensor[exposure.sweep > 0 ? static_cast<std::size_t>(x - begin) : 0];
        castInto(scan, i, caster, world, {T.translation(), T.linear() * grid.directions[i]}, errors, {key, i});
      }
    });
  }
  scan.true_range = scan.range;
  parallelFor(grid.height, threads, [&](int y) {
    for (int x = 0; x < grid.width; ++x) {
      addRangeErrors(scan, scan.true_range, grid, errors, x, y, key);
    }
  });
  return scan;
}

void parallelFor(int count, int threads, const std::function<void(int)>& work) {
  std::atomic<int> next = 0;
  const auto run = [&] {
    for (int i = next++; i < count; i = next++) {
      work(i);
    }
  };
  std::vector<std::jthread> helpers;
  for (int i = 1; i < std::min(threads, count); ++i) {
    helpers.emplace_back(run);
  }
  run();
}

}  // namespace hgg
