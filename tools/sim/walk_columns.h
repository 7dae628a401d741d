#pragma once

#include <limits>
#include <vector>

#include "sim/world.h"
#include "truth/walk_grid.h"

namespace hgg {

/// A surface that faces up, on one vertical line or in one cell.
struct Place {
  double z = 0;
  double slope_deg = 0;
  double room = 0;         // m, free above it on the line; 0: something stands on it
  double least_room = 0;   // m, the same anywhere in the cell
  ClassId above = 0;       // the class of what ends `room`
  ClassId in_the_way = 0;  // of what ends `least_room`
  double step = 0;         // m, the largest in the cell and down to what is around it; infinite beside a void
  bool is_ground = false;  // steps lead to it from where the robot went, whatever stands on the way
};

constexpr double kVoid = std::numeric_limits<double>::infinity();

/// The surfaces on the vertical line through (x, y), lowest first. What lies inside its own object is none (where a
/// car's body meets its cabin), what is below another thing is one without room.
std::vector<Place> placesOn(const World& world, const std::vector<std::size_t>& solids, double x, double y);

/// The place a foot is put on that comes from height z: the one with most room among those a step away, else the
/// nearest; nullptr when there is none.
const Place* nextPlace(const std::vector<Place>& places, double z, double step);

/// The places at the middle of a square cell, with the step and the least room to what is anywhere in it.
std::vector<Place> placesIn(const World& world, const std::vector<std::size_t>& solids, double x, double y, double side,
                            double step);

}  // namespace hgg
