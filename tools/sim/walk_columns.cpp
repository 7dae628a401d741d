#include "sim/walk_columns.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/units.h"
#include "sim/raycast.h"

namespace hgg {
namespace {

constexpr double kSame = 0.005;  // m: surfaces this near are one
constexpr int kTries = 4;        // along each side of a cell

/// The stretch of a vertical line inside a solid; a sheet has no thickness.
struct Span {
  double lo, hi;
  double slope_deg;  // of its upper end
  std::size_t object;
  ClassId label;
  bool is_sheet, is_foliage;
};

double slopeOf(const Vec3& normal) { return std::acos(std::min(std::abs(normal.normalized().z()), 1.0)) / kDegree; }

std::optional<double> heightOf(const Plane& plane, double x, double y) {
  const Vec3& n = plane.normal;
  if (n.z() == 0.0) {
    return std::nullopt;
  }
  return plane.point.z() - (n.x() * (x - plane.point.x()) + n.y() * (y - plane.point.y())) / n.z();
}

std::optional<Span> spanOf(const World& world, const Solid& solid, double x, double y) {
  constexpr double kOutside = 1.0;  // m above and below the shape
  const bool is_foliage = world.objects[solid.object].foliage;
  const ClassId label = world.objects[solid.object].label;
  if (const auto* plane = std::get_if<Plane>(&solid.shape)) {
    const auto z = heightOf(*plane, x, y);
    return z ? std::optional(Span{*z, *z, slopeOf(plane->normal), solid.object, label, true, is_foliage})
             : std::nullopt;
  }
  const Bounds bounds = boundsOf(solid.shape);
  if (x < bounds.lo.x() || x > bounds.hi.x() || y < bounds.lo.y() || y > bounds.hi.y()) {
    return std::nullopt;
  }
  const Ray down{{x, y, bounds.hi.z() + kOutside}, -Vec3::UnitZ()}, up{{x, y, bounds.lo.z() - kOutside}, Vec3::UnitZ()};
  const auto cross = [&](const Ray& ray) {
    return std::visit([&](const auto& shape) { return intersect(shape, ray); }, solid.shape);
  };
  const auto from_above = cross(down), from_below = cross(up);
  if (!from_above || !from_below) {
    return std::nullopt;
  }
  return Span{up.origin.z() + *from_below,
              down.origin.z() - *from_above,
              slopeOf(facingNormal(solid.shape, down, *from_above)),
              solid.object,
              label,
              std::holds_alternative<Triangle>(solid.shape),
              is_foliage};
}

/// The top of a span as a place; nullopt when it lies inside its own object.
std::optional<Place> topOf(const std::vector<Span>& spans, const Span& span) {
  double room = kVoid;
  const Span* above = nullptr;
  for (const Span& other : spans) {
    if (&other == &span || other.hi <= span.hi + kSame) {
      continue;
    }
    const double gap = std::max(other.lo - span.hi, 0.0);
    if (gap <= kSame && other.object == span.object && !span.is_sheet) {
      return std::nullopt;
    }
    above = above == nullptr || gap < room ? &other : above;
    room = std::min(room, gap);
  }
  const ClassId label = above != nullptr ? above->label : ClassId{0};
  return Place{span.hi, span.slope_deg, room, room, label, label};
}

/// Whether the solid is the same everywhere in the cell as in its middle: so that trying one place is enough.
bool fillsCell(const Solid& solid, double x, double y, double side) {
  const auto* box = std::get_if<Box>(&solid.shape);
  if (box == nullptr || std::abs(box->T_world_box.linear()(2, 2)) < 1.0 - 1e-9) {
    return !std::holds_alternative<Box>(solid.shape) && !std::holds_alternative<Cylinder>(solid.shape) &&
           !std::holds_alternative<Ellipsoid>(solid.shape);  // sheets: their neighbours show where they end
  }
  for (const double dx : {-0.5, 0.5}) {
    for (const double dy : {-0.5, 0.5}) {
      const Vec3 corner(x + dx * side, y + dy * side, box->T_world_box.translation().z());
      const Vec3 local = box->T_world_box.inverse() * corner;
      if (std::abs(local.x()) > box->half.x() || std::abs(local.y()) > box->half.y()) {
        return false;
      }
    }
  }
  return true;
}

void heed(std::vector<Place>& places, const std::vector<Place>& beside, double step) {
  for (Place& place : places) {
    const Place* next = nextPlace(beside, place.z, step);
    const double height = next != nullptr ? std::abs(next->z - place.z) : kVoid;
    place.step = std::max(place.step, height);
    if (height <= step && next->room < place.least_room) {
      place.least_room = next->room;
      place.in_the_way = next->above;
    }
  }
}

}  // namespace

std::vector<Place> placesOn(const World& world, const std::vector<std::size_t>& solids, double x, double y) {
  std::vector<Span> spans;
  for (const std::size_t solid : solids) {
    if (const auto span = spanOf(world, world.solids[solid], x, y)) {
      spans.push_back(*span);
    }
  }
  std::vector<Place> places;
  for (const Span& span : spans) {
    const auto top = span.is_foliage ? std::nullopt : topOf(spans, span);
    if (top) {
      places.push_back(*top);
    }
  }
  std::ranges::sort(places, {}, &Place::z);
  const auto is_same = [](const Place& a, const Place& b) { return b.z - a.z <= kSame; };
  places.erase(std::unique(places.begin(), places.end(), is_same), places.end());
  return places;
}

const Place* nextPlace(const std::vector<Place>& places, double z, double step) {
  const Place *best = nullptr, *nearest = nullptr;
  for (const Place& place : places) {
    const double apart = std::abs(place.z - z);
    if (apart <= step &&
        (best == nullptr || place.room > best->room || (place.room == best->room && apart < std::abs(best->z - z)))) {
      best = &place;
    }
    nearest = nearest == nullptr || apart < std::abs(nearest->z - z) ? &place : nearest;
  }
  return best != nullptr ? best : nearest;
}

std::vector<Place> placesIn(const World& world, const std::vector<std::size_t>& solids, double x, double y, double side,
                            double step) {
  std::vector<Place> places = placesOn(world, solids, x, y);
  const bool is_uniform =
      std::ranges::all_of(solids, [&](std::size_t solid) { return fillsCell(world.solids[solid], x, y, side); });
  if (is_uniform) {
    return places;
  }
  for (int i = 0; i < kTries; ++i) {
    for (int j = 0; j < kTries; ++j) {
      const double dx = ((i + 0.5) / kTries - 0.5) * side, dy = ((j + 0.5) / kTries - 0.5) * side;
      heed(places, placesOn(world, solids, x + dx, y + dy), step);
    }
  }
  return places;
}

}  // namespace hgg
