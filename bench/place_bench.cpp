// What finding surfaces costs when two maps are compared: 40,000 leaves of a street, looked for as registration does.
#include <benchmark/benchmark.h>

#include <random>

#include "place/surfaces.h"

namespace hgg::place_bench {
namespace {

constexpr std::size_t kSurfaces = 40'000, kQueries = 1500;
constexpr double kLength = 400, kHalfWidth = 10;  // m

/// A road with façades on both sides and things between them.
std::vector<Surface> street() {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Surface> surfaces(kSurfaces);
  for (std::size_t i = 0; i < kSurfaces; ++i) {
    const double along = kLength * unit(random), across = kHalfWidth * (2 * unit(random) - 1), up = unit(random);
    const bool is_road = i % 10 < 5, is_thing = i % 10 == 9;
    surfaces[i].mean = is_road    ? Vec3(along, across, 0.05 * up)
                       : is_thing ? Vec3(along, across, 3 * up)
                                  : Vec3(along, across > 0 ? kHalfWidth : -kHalfWidth, 8 * up);
  }
  return surfaces;
}

void BuildSurfaceIndex(benchmark::State& state) {
  const std::vector<Surface> surfaces = street();
  for (auto _ : state) {
    const SurfaceIndex index(surfaces);
    benchmark::DoNotOptimize(&index);
  }
}
BENCHMARK(BuildSurfaceIndex)->Unit(benchmark::kMillisecond);

/// All queries of one round of registration; the argument is the radius in centimetres.
void FindSurfaces(benchmark::State& state) {
  const std::vector<Surface> surfaces = street();
  const SurfaceIndex index(surfaces);
  std::mt19937 random(2);
  std::normal_distribution<double> off(0, 0.3);
  std::vector<Vec3> queries;
  for (std::size_t k = 0; k < kQueries; ++k) {
    queries.emplace_back(surfaces[k * (kSurfaces / kQueries)].mean + Vec3(off(random), off(random), off(random)));
  }
  std::vector<std::size_t> found;
  std::size_t all = 0;
  for (auto _ : state) {
    all = 0;
    for (const Vec3& p : queries) {
      index.near(p, 0.01 * static_cast<double>(state.range(0)), found);
      all += found.size();
    }
  }
  state.counters["found"] = static_cast<double>(all) / kQueries;
}
BENCHMARK(FindSurfaces)->Arg(110)->Arg(220)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace hgg::place_bench
