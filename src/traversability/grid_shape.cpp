#include "traversability/grid_shape.h"

#include <fmt/format.h>

namespace hgg {

std::string whyNoRegion(const GridRegion& region) {
  constexpr double kFarthest = 1e7;  // m, beyond what a cell index can count
  for (const double v : {region.x_min, region.y_min, region.x_max, region.y_max}) {
    if (!(std::abs(v) <= kFarthest)) {
      return fmt::format("a region that reaches to {} m is no place in a map", v);
    }
  }
  if (!(region.x_min < region.x_max && region.y_min < region.y_max)) {
    return fmt::format("the region {} .. {}, {} .. {} m is empty (x0,y0,x1,y1 with x0 < x1 and y0 < y1)", region.x_min,
                       region.x_max, region.y_min, region.y_max);
  }
  return {};
}

Result<GridShape> gridShape(const GridRegion& region, double resolution, double most_cells) {
  if (!(resolution >= kMinResolution && resolution <= kMaxResolution)) {
    return Result<GridShape>::fail(
        fmt::format("a resolution of {} m is outside {} .. {} m", resolution, kMinResolution, kMaxResolution));
  }
  if (const std::string why = whyNoRegion(region); !why.empty()) {
    return Result<GridShape>::fail(why);
  }
  // A region that ends on a cell's edge must not get one more cell because of the last digit.
  constexpr double kSlack = 1e-6;  // cells
  const double first_column = std::floor(region.x_min / resolution + kSlack);
  const double first_row = std::floor(region.y_min / resolution + kSlack);
  const double width = std::ceil(region.x_max / resolution - kSlack) - first_column;
  const double height = std::ceil(region.y_max / resolution - kSlack) - first_row;
  if (width * height > most_cells) {
    const double fitting = std::sqrt((region.x_max - region.x_min) * (region.y_max - region.y_min) / most_cells);
    return Result<GridShape>::fail(
        fmt::format("a region of {:.0f} x {:.0f} m has {:.0f} million cells of {} m, and {:.1f} million are the most: "
                    "ask for a smaller region or a resolution of {:.2g} m",
                    region.x_max - region.x_min, region.y_max - region.y_min, width * height * 1e-6, resolution,
                    most_cells * 1e-6, 1.05 * fitting));
  }
  return Result<GridShape>::ok({first_column * resolution, first_row * resolution, resolution,
                                static_cast<std::int32_t>(std::max(width, 1.0)),
                                static_cast<std::int32_t>(std::max(height, 1.0)),
                                static_cast<std::int32_t>(first_column), static_cast<std::int32_t>(first_row)});
}

}  // namespace hgg
