#include "sim/walk_truth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>

#include "sim/motion.h"
#include "sim/sensor.h"
#include "sim/walk_columns.h"
#include "sim/worlds/stage.h"

namespace hgg {
namespace {

/// A return this far above or below a surface's height at the cell's middle is one of it, m: what a slope at the limit
/// makes of half a cell, and above that as much again for what lies on it. No thicker than a ceiling, whose other side
/// nobody sees.
constexpr double kOnSurface = 0.1, kBelowSurface = 0.05;
constexpr std::uint32_t kUnknown = std::numeric_limits<std::uint32_t>::max();
constexpr std::array<std::pair<int, int>, 8> kAround{
    {{-1, -1}, {0, -1}, {1, -1}, {-1, 0}, {1, 0}, {-1, 1}, {0, 1}, {1, 1}}};

/// The world as it stands at a time, without what moves by itself.
World stillWorld(const Scene& scene, double time) {
  World still;
  still.objects = scene.world.objects;
  for (const Solid& solid : scene.world.solids) {
    const auto pose = scene.world.objects[solid.object].dynamic ? std::nullopt : poseAt(scene, solid.object, time);
    if (!pose) {
      continue;
    }
    const bool has_moved = !pose->isApprox(Pose::Identity(), 1e-12);
    addSolid(still, solid.object, has_moved ? moved({solid.shape}, *pose).front() : solid.shape);
  }
  return still;
}

/// Size and place of the grid, and the cells near the way.
WalkGrid emptyGrid(const std::vector<Pose>& T_world_body, const WalkOptions& options) {
  WalkGrid grid;
  grid.T_grid_map = T_world_body.front();
  grid.resolution = options.resolution, grid.reach = options.reach, grid.limits = options.limits;
  Bounds bounds;
  for (const Pose& pose : T_world_body) {
    bounds = join(bounds, {pose.translation(), pose.translation()});
  }
  const auto snapped = [&](double at) { return std::floor((at - options.reach) / grid.resolution) * grid.resolution; };
  grid.origin_x = snapped(bounds.lo.x()), grid.origin_y = snapped(bounds.lo.y());
  grid.width = static_cast<int>(std::ceil((bounds.hi.x() + options.reach - grid.origin_x) / grid.resolution));
  grid.height = static_cast<int>(std::ceil((bounds.hi.y() + options.reach - grid.origin_y) / grid.resolution));
  grid.known.assign(grid.cells(), 0);
  const int reach = static_cast<int>(options.reach / grid.resolution);
  std::optional<Vec3> last;
  for (const Pose& pose : T_world_body) {
    constexpr double kApart = 0.3;  // m between the discs that are filled
    if (last && (pose.translation() - *last).head<2>().norm() < kApart) {
      continue;
    }
    last = pose.translation();
    const int cx = static_cast<int>((last->x() - grid.origin_x) / grid.resolution);
    const int cy = static_cast<int>((last->y() - grid.origin_y) / grid.resolution);
    for (int y = std::max(cy - reach, 0); y <= std::min(cy + reach, grid.height - 1); ++y) {
      const int half = static_cast<int>(std::sqrt(static_cast<double>(reach) * reach - (y - cy) * (y - cy)));
      const int begin = std::max(cx - half, 0), end = std::min(cx + half + 1, grid.width);
      std::fill(grid.known.begin() + static_cast<std::ptrdiff_t>(grid.at(begin, y)),
                grid.known.begin() + static_cast<std::ptrdiff_t>(grid.at(begin, y)) + (end - begin), 1);
    }
  }
  return grid;
}

/// The places of the known cells.
struct Columns {
  const WalkGrid& grid;
  std::vector<std::uint32_t> index;        // by cell: into `places`, or kUnknown
  std::vector<std::vector<Place>> places;  // by known cell

  const std::vector<Place>* at(int x, int y) const {
    const bool is_inside = x >= 0 && y >= 0 && x < grid.width && y < grid.height;
    const std::uint32_t i = is_inside ? index[grid.at(x, y)] : kUnknown;
    return i == kUnknown ? nullptr : &places[i];
  }
};

bool overlaps(const Bounds& bounds, double x0, double y0, double x1, double y1) {
  return bounds.lo.x() <= x1 && bounds.hi.x() >= x0 && bounds.lo.y() <= y1 && bounds.hi.y() >= y0;
}

/// Fills the cells of one square block; blocks are independent.
void fillBlock(Columns& columns, const World& world, const std::vector<Bounds>& bounds, int x0, int y0, int side,
               double step) {
  const WalkGrid& grid = columns.grid;
  const double r = grid.resolution;
  bool is_known = false;
  for (int y = y0; y < std::min(y0 + side, grid.height) && !is_known; ++y) {
    for (int x = x0; x < std::min(x0 + side, grid.width) && !is_known; ++x) {
      is_known = columns.index[grid.at(x, y)] != kUnknown;
    }
  }
  if (!is_known) {
    return;
  }
  const auto near = [&](const auto& from, int x, int y, int cells, std::vector<std::size_t>& found) {
    const double west = grid.origin_x + x * r, south = grid.origin_y + y * r;
    for (const std::size_t solid : from) {
      if (overlaps(bounds[solid], west, south, west + cells * r, south + cells * r)) {
        found.push_back(solid);
      }
    }
  };
  std::vector<std::size_t> all(world.solids.size()), here, of_cell;
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i] = i;
  }
  near(all, x0, y0, side, here);
  for (int y = y0; y < std::min(y0 + side, grid.height); ++y) {
    for (int x = x0; x < std::min(x0 + side, grid.width); ++x) {
      const std::uint32_t i = columns.index[grid.at(x, y)];
      if (i == kUnknown) {
        continue;
      }
      of_cell.clear();
      near(here, x, y, 1, of_cell);
      columns.places[i] =
          placesIn(world, of_cell, grid.origin_x + (x + 0.5) * r, grid.origin_y + (y + 0.5) * r, r, step);
    }
  }
}

Columns makeColumns(const WalkGrid& grid, const World& world, double step, int threads) {
  Columns columns{grid, std::vector<std::uint32_t>(grid.cells(), kUnknown), {}};
  std::uint32_t known = 0;
  for (std::size_t cell = 0; cell < grid.cells(); ++cell) {
    columns.index[cell] = grid.known[cell] != 0 ? known++ : kUnknown;
  }
  columns.places.resize(known);
  std::vector<Bounds> bounds;
  for (const Solid& solid : world.solids) {
    bounds.push_back(boundsOf(solid.shape));
  }
  constexpr int kBlock = 32;  // cells a side
  const int across = (grid.width + kBlock - 1) / kBlock, along = (grid.height + kBlock - 1) / kBlock;
  parallelFor(across * along, threads, [&](int block) {
    fillBlock(columns, world, bounds, kBlock * (block % across), kBlock * (block / across), kBlock, step);
  });
  return columns;
}

/// How far down it goes to the middles of the cells around. At the foot of a step that is too high one can stand, as at
/// the foot of a wall; it is the edge above that is blocked. `step` lets steps be measured that are a little too high.
void measureSteps(Columns& columns, double step) {
  for (int y = 0; y < columns.grid.height; ++y) {
    for (int x = 0; x < columns.grid.width; ++x) {
      const std::uint32_t i = columns.index[columns.grid.at(x, y)];
      if (i == kUnknown) {
        continue;
      }
      for (const auto& [dx, dy] : kAround) {
        const auto* beside = columns.at(x + dx, y + dy);
        for (std::size_t k = 0; beside != nullptr && k < columns.places[i].size(); ++k) {
          Place& place = columns.places[i][k];
          const Place* next = nextPlace(*beside, place.z, step);
          const double height = next == nullptr ? kVoid : std::abs(next->z - place.z);
          const bool is_foot = next != nullptr && next->z > place.z + step;
          place.step = is_foot ? place.step : std::max(place.step, height);
        }
      }
    }
  }
}

/// Marks what can be reached in steps from below the way, whatever stands on it.
void markGround(Columns& columns, const std::vector<Pose>& T_world_body, double step, double slope_deg) {
  struct Node {
    int x, y;
    std::size_t place;
  };
  std::queue<Node> frontier;
  const WalkGrid& grid = columns.grid;
  const auto reach = [&](int x, int y, std::size_t place) {
    Place& there = columns.places[columns.index[grid.at(x, y)]][place];
    if (!there.is_ground) {
      there.is_ground = true;
      frontier.push({x, y, place});
    }
  };
  for (const Pose& pose : T_world_body) {
    const auto cell = grid.cellOf(pose.translation().x(), pose.translation().y());
    const int x = static_cast<int>(*cell) % grid.width, y = static_cast<int>(*cell) / grid.width;
    const auto& places = *columns.at(x, y);
    const auto above = std::ranges::find_if(places, [&](const Place& p) { return p.z > pose.translation().z(); });
    if (above != places.begin()) {
      reach(x, y, static_cast<std::size_t>(above - places.begin()) - 1);
    }
  }
  while (!frontier.empty()) {
    const Node node = frontier.front();
    frontier.pop();
    const Place from = (*columns.at(node.x, node.y))[node.place];
    for (const auto& [dx, dy] : kAround) {
      const auto* beside = from.slope_deg <= slope_deg ? columns.at(node.x + dx, node.y + dy) : nullptr;
      for (std::size_t k = 0; beside != nullptr && k < beside->size(); ++k) {
        if (std::abs((*beside)[k].z - from.z) <= step) {
          reach(node.x + dx, node.y + dy, k);
        }
      }
    }
  }
}

Standing standingOf(const Place& place, const WalkLimits& limits) {
  constexpr LimitMargins kMargins;
  const auto within = [&](double sign) {
    return place.step <= limits.step + sign * kMargins.step &&
           place.slope_deg <= limits.slope_deg + sign * kMargins.slope_deg &&
           place.least_room >= limits.body_height - sign * kMargins.body_height;
  };
  return within(-1.0) ? Standing::kFree : within(1.0) ? Standing::kClose : Standing::kBlocked;
}

ClassId causeOf(const Place& place, const WalkLimits& limits) {
  constexpr LimitMargins kMargins;
  return place.least_room < limits.body_height - kMargins.body_height ? place.in_the_way
         : place.step > limits.step + kMargins.step                   ? kCauseEdge
                                                                      : kCauseSlope;
}

/// How high a return may lie to count for the place: on free ground at it, else up to the top of what stands on it.
double countsTo(const std::vector<Place>& places, std::size_t k, Standing standing, double body_height) {
  const Place& place = places[k];
  if (standing == Standing::kFree) {
    return place.z + kOnSurface;
  }
  for (std::size_t above = k + 1; above < places.size() && places[k].room < body_height; ++above) {
    if (places[above].is_ground) {
      return place.z + std::max(place.room - kOnSurface, 0.0);  // what is on the upper ground is the upper ground's
    }
    if (places[above].room >= body_height) {
      return places[above].z + kOnSurface;
    }
  }
  return place.z + std::min(std::max(place.room - kOnSurface, 0.0), body_height);
}

/// What is inside something one can walk on, such as the floor inside a flight of stairs, is no place.
bool isInsideGround(const std::vector<Place>& places, std::size_t k) {
  constexpr double kCovered = 0.02;  // m
  return places[k].room < kCovered && k + 1 < places.size() && places[k + 1].is_ground;
}

void store(WalkTruth& truth, const Columns& columns) {
  WalkGrid& grid = truth.grid;
  grid.first = {0};
  for (std::size_t cell = 0; cell < grid.cells(); ++cell) {
    const std::uint32_t i = columns.index[cell];
    for (std::size_t k = 0; i != kUnknown && k < columns.places[i].size(); ++k) {
      const std::vector<Place>& places = columns.places[i];
      if (isInsideGround(places, k)) {
        continue;
      }
      const Standing standing = standingOf(places[k], grid.limits);
      grid.surfaces.push_back({static_cast<float>(places[k].z), standing, !places[k].is_ground, 0,
                               standing == Standing::kBlocked ? causeOf(places[k], grid.limits) : ClassId{0}});
      truth.counts_to.push_back(static_cast<float>(countsTo(places, k, standing, grid.limits.body_height)));
    }
    grid.first.push_back(static_cast<std::uint32_t>(grid.surfaces.size()));
  }
}

}  // namespace

WalkTruth walkTruth(const Scene& scene, const std::vector<Pose>& T_world_body, double end_time,
                    const WalkOptions& options) {
  constexpr LimitMargins kMargins;
  const World world = stillWorld(scene, end_time);
  WalkTruth truth{emptyGrid(T_world_body, options), {}, {}};
  const double step = options.limits.step + kMargins.step;
  Columns columns = makeColumns(truth.grid, world, step, options.threads);
  measureSteps(columns, step);
  markGround(columns, T_world_body, step, options.limits.slope_deg + kMargins.slope_deg);
  store(truth, columns);
  truth.stays_there.assign(scene.world.objects.size(), true);
  for (const Motion& motion : scene.motions) {
    truth.stays_there[motion.object] = false;
  }
  return truth;
}

void countReturn(WalkTruth& truth, const Vec3& p_world, std::size_t object) {
  const auto cell = truth.grid.cellOf(p_world.x(), p_world.y());
  if (!cell || !truth.stays_there[object]) {
    return;
  }
  for (std::size_t i = truth.grid.first[*cell]; i < truth.grid.first[*cell + 1]; ++i) {
    WalkSurface& surface = truth.grid.surfaces[i];
    const bool counts = p_world.z() >= static_cast<double>(surface.height) - kBelowSurface &&
                        p_world.z() <= static_cast<double>(truth.counts_to[i]);
    surface.returns += counts ? 1 : 0;
  }
}

WalkGrid finishedGrid(WalkTruth truth) {
  WalkGrid& grid = truth.grid;
  std::vector<std::uint32_t> first{0};
  std::vector<WalkSurface> kept;
  for (std::size_t cell = 0; cell < grid.cells(); ++cell) {
    std::ranges::copy_if(grid.column(cell), std::back_inserter(kept),
                         [](const WalkSurface& s) { return !s.island || s.returns > 0; });
    first.push_back(static_cast<std::uint32_t>(kept.size()));
  }
  grid.first = std::move(first), grid.surfaces = std::move(kept);
  return std::move(truth.grid);
}

}  // namespace hgg
