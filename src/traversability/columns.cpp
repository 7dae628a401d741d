#include "traversability/columns.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <tuple>

#include "core/units.h"
#include "traversability/point_density.h"

namespace hgg {
namespace {

/// Steeper is a wall whatever the robot: beyond the friction of any foot. rad
constexpr double kSteepest = 55 * kDegree;
/// A leaf this many times wider than thick shows which way its surface leans; a thinner one is a line.
constexpr double kPlaneRatio = 2;
/// What stands is drawn no deeper than this, half a slab: a leaf with points farther off is a cloud, whose middle alone
/// is certain to stand. m
constexpr double kMostDepth = 0.05;
/// From farther off the upper side of a surface is no longer told from its lower one: errors of its normal. m
constexpr double kFarthestLook = 15;
/// Places nearer to each other see the same side. m
constexpr double kEyesApart = 2;
/// Half the height of a slab with the same standard deviation.
constexpr double kSlab = 1.7320508;  // sqrt(3)
/// Patches whose tops are this near to the highest make the surface together: what passes over the same ground differ
/// by through the error of the poses. m
constexpr float kSameTop = 0.05F;
/// Points on a foot at which the ground is half believed.
constexpr double kHalfDensity = 0.5;
/// A leaf with points farther than this from its sheet, one standard deviation, is a cloud: twice what range noise,
/// poses and unmown grass make of ground. m
constexpr float kCloud = 0.05F;
/// A top with more than this share of its points on walls is no ground; the edge of a stair has some of both.
constexpr double kMostSteep = 0.8;
/// Where more than this share of the points of a solid lie deeper than a step below its top, that is a coarse leaf
/// which spans a hole, as a trench: beams went through it.
constexpr double kMostBelow = 0.1;
/// What stands is no face that ends at the ground unless it is this high, and ends within it of the surface: poses and
/// range make half of that. m
constexpr float kLeastFace = 0.1F;
/// A patch with less than this share of the points of the densest in its column is stray.
constexpr float kStray = 0.05F;

/// True when the eyes look at the upper side of the sheet at least half as steeply as at its lower one: at a flat angle
/// nobody can tell which side it is, for the error of its normal. Without eyes nobody knows: true.
bool isSeenFromAbove(const LeafSheet& sheet, const Vec3& up, std::span<const Vec3> eyes) {
  double above = 0, below = 0;  // sines of the steepest angles
  for (const Vec3& p_eye : eyes) {
    const double sine = up.dot((p_eye - sheet.centre).normalized());
    above = std::max(above, sine), below = std::max(below, -sine);
  }
  return above >= below / 2;
}

/// True for ground: no wall, no pole, and nothing that was only seen from below, whose top nobody knows.
bool isGround(const LeafSheet& sheet, std::span<const Vec3> eyes) {
  if (sheet.half_across <= 2 * kPlaneRatio * sheet.thickness) {
    return std::abs(sheet.along.z()) < std::sin(kSteepest) && isSeenFromAbove(sheet, Vec3::UnitZ(), eyes);
  }
  const Vec3 up = sheet.normal.z() < 0 ? -sheet.normal : sheet.normal;
  return up.z() > std::cos(kSteepest) && isSeenFromAbove(sheet, up, eyes);
}

/// Places that may have seen the node, map frame: the keyframe it was made from and those of its time that are near to
/// it, no two of them close together.
std::vector<Vec3> eyesOn(const std::vector<TimedPose>& keyframes, const MapNode& node) {
  std::vector<Vec3> eyes;
  if (node.anchor >= 0 && static_cast<std::size_t>(node.anchor) < keyframes.size()) {
    eyes.push_back(keyframes[static_cast<std::size_t>(node.anchor)].T_map_body.translation());
  }
  const double reach = kFarthestLook + std::sqrt(node.belief.cov.trace());
  for (auto pose = std::ranges::lower_bound(keyframes, node.first_us, {}, &TimedPose::utime_us);
       pose != keyframes.end() && pose->utime_us <= node.last_us; ++pose) {
    const Vec3 p = pose->T_map_body.translation();
    const auto is_close = [&](const Vec3& other) { return (other - p).squaredNorm() < square(kEyesApart); };
    if ((p - node.belief.mean).head<2>().norm() < reach && std::ranges::none_of(eyes, is_close)) {
      eyes.push_back(p);
    }
  }
  return eyes;
}

/// The columns under the bounding box of one sheet, with what its samples say in each.
class Raster {
 public:
  /// False when no column of the grid is under the sheet.
  bool begin(const LeafSheet& sheet, const GridShape& shape) {
    const Vec3 half = halfDrawn(sheet);
    const Vec3 low = sheet.centre - half, high = sheet.centre + half;
    first_column_ = std::max(0, shape.columnOf(low.x())), first_row_ = std::max(0, shape.rowOf(low.y()));
    const int last_column = std::min(shape.width - 1, shape.columnOf(high.x()));
    const int last_row = std::min(shape.height - 1, shape.rowOf(high.y()));
    width_ = last_column - first_column_ + 1, height_ = last_row - first_row_ + 1;
    if (width_ <= 0 || height_ <= 0) {
      return false;
    }
    bins_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), Bin{});
    return true;
  }

  void add(const Vec3& p, const GridShape& shape) {
    const int column = shape.columnOf(p.x()) - first_column_, row = shape.rowOf(p.y()) - first_row_;
    if (column < 0 || row < 0 || column >= width_ || row >= height_) {
      return;
    }
    Bin& bin = bins_[binAt(column, row)];
    bin.low = std::min(bin.low, p.z()), bin.high = std::max(bin.high, p.z());
    bin.sum += p.z(), bin.count += 1;
  }

  void flush(const PlacedSheet& placed, std::int32_t index, const GridShape& shape,
             std::vector<SheetPatch>& patches) const {
    const LeafSheet& sheet = placed.sheet;
    // A tilted slab is thicker along the vertical than across; what stands is bounded by its ends.
    const double thickness = placed.carries
                                 ? sheet.thickness / std::max(std::abs(sheet.normal.z()), std::cos(kSteepest))
                                 : sheet.thickness * std::abs(sheet.normal.z());
    const double trust = placed.views / (placed.views + 1.0);
    SheetPatch patch;
    patch.sheet = index;
    patch.density = static_cast<float>(trust * densityOf(sheet));
    patch.thickness = static_cast<float>(thickness);
    patch.fuzz = static_cast<float>(sheet.thickness);
    patch.reach = static_cast<float>(kSlab * sheet.half_along);
    patch.carries = placed.carries;
    for (int row = 0; row < height_; ++row) {
      for (int column = 0; column < width_; ++column) {
        const Bin& bin = bins_[binAt(column, row)];
        if (bin.count > 0) {
          patch.cell = shape.cell(first_column_ + column, first_row_ + row);
          patch.bottom = static_cast<float>(bin.low - kSlab * thickness);
          patch.top = static_cast<float>(bin.high + kSlab * thickness);
          patch.height = static_cast<float>(bin.sum / bin.count);
          patches.push_back(patch);
        }
      }
    }
  }

 private:
  struct Bin {
    double low = std::numeric_limits<double>::infinity(), high = -low, sum = 0;
    int count = 0;
  };
  std::size_t binAt(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(column);
  }

  int first_column_ = 0, first_row_ = 0, width_ = 0, height_ = 0;
  std::vector<Bin> bins_;
};

/// Half the slab of a sheet that stands, horizontally.
Vec3 depthOf(const LeafSheet& sheet) {
  const Vec3 level(sheet.normal.x(), sheet.normal.y(), 0);
  return kSlab * std::min(sheet.thickness, kMostDepth) * level.normalized();
}

/// Height up to which a patch fills the column: ground is as high as its sheet, and its thickness is noise.
float levelOf(const SheetPatch& p) { return p.carries ? p.height : p.top; }

/// Share of the points of a patch that lie lower than `height`.
double shareBelow(const SheetPatch& p, double height) {
  const double deviation = std::max<double>(p.thickness, (p.top - p.bottom) / (2 * kSlab));
  return 0.5 * std::erfc((p.height - height) / (deviation * std::sqrt(2.0)));
}

/// Bottom of what was seen below a surface that cannot be seen through it: a face that ends at the surface, or what
/// leaves half as large, which tell more exactly where they are, show lower than it. Infinite: nothing.
float beneath(std::span<const SheetPatch> patches, const Support& s) {
  float low = std::numeric_limits<float>::infinity();
  for (const SheetPatch& p : patches) {
    const bool is_face = !p.carries && p.top - p.bottom >= kLeastFace && std::abs(p.top - s.height) <= kLeastFace &&
                         p.density >= kStray * s.density;
    const bool is_lower = p.carries && p.height <= s.height - kSameTop && 2 * p.reach <= s.reach &&
                          p.density >= static_cast<float>(kMostBelow) * s.density;
    low = is_face || is_lower ? std::min(low, p.bottom) : low;
  }
  return low;
}

/// The surface on a solid made of `patches`, which reaches up to `top`.
Support surfaceOf(std::span<const SheetPatch> patches, float bottom, float top, double step_height) {
  double weight = 0, height = 0, square_sum = 0, all = 0, below = 0, density = 0, ground_density = 0, no_ground = 0,
         reach = 0;
  float ground = -std::numeric_limits<float>::infinity(), level = ground;
  Support s;
  for (const SheetPatch& p : patches) {
    level = std::max(level, levelOf(p));
    s.density = std::max(s.density, p.density);
    if (p.carries) {
      ground = std::max(ground, p.height), ground_density += p.density;
    }
  }
  for (const SheetPatch& p : patches) {
    if (levelOf(p) < level - kSameTop) {
      continue;
    }
    const double w = 1e-6 + p.density;
    weight += w, height += w * p.height, no_ground += p.carries ? 0 : w, reach += w * p.reach;
    square_sum += w * (square(p.thickness) + square(p.height));
    density += p.carries ? p.density : 0;
  }
  const double mean = height / weight;
  for (const SheetPatch& p : patches) {
    all += p.density;
    below += p.density * shareBelow(p, mean - step_height);
  }
  const bool is_flat = no_ground <= kMostSteep * weight;
  s.bottom = bottom, s.top = top;
  // A riser whose tread begins in the next column: what is no higher than a step is stepped on.
  s.spans_hole = below >= kMostBelow * all;
  s.carries = (is_flat || level - ground <= step_height) && !s.spans_hole;
  s.height = is_flat ? static_cast<float>(mean) : level;
  s.roughness = is_flat ? static_cast<float>(std::sqrt(std::max(0.0, square_sum / weight - square(mean)))) : 0;
  density = is_flat ? density : ground_density;
  s.confidence = static_cast<float>(density / (density + kHalfDensity));
  s.reach = static_cast<float>(reach / weight);
  s.beneath = beneath(patches, s);
  s.clearance = std::numeric_limits<float>::infinity();
  return s;
}

}  // namespace

NodeView viewOf(const MapLeaves& map, const MapNode& node) {
  NodeView view;
  view.T_map_object = node.T_map_object;
  view.eyes = eyesOn(map.keyframes, node);
  view.views = static_cast<std::int32_t>(std::bit_floor(static_cast<std::uint32_t>(std::max(0, node.views))));
  return view;
}

PlacedSheet placeLeaf(const Leaf& leaf, const NodeView& view) {
  const LeafSheet sheet = sheetOf(transform(view.T_map_object, unpackLeaf(leaf)));
  return {sheet, view.views, isGround(sheet, view.eyes)};
}

Vec3 halfDrawn(const LeafSheet& sheet) {
  return halfBox(sheet) + Vec3::Constant(kSlab * std::min(sheet.thickness, kMostDepth));
}

bool mayTouch(const LeafSheet& sheet, const GridShape& shape) {
  const Vec3 half = halfDrawn(sheet), low = sheet.centre - half, high = sheet.centre + half;
  return low.x() < shape.x + shape.width * shape.resolution && high.x() > shape.x &&
         low.y() < shape.y + shape.height * shape.resolution && high.y() > shape.y;
}

void appendSheets(const MapLeaves& map, const MapNode& node, const GridShape& shape, std::vector<PlacedSheet>& sheets) {
  const NodeView view = viewOf(map, node);
  for (const Leaf& leaf : leavesOf(node)) {
    if (const PlacedSheet placed = placeLeaf(leaf, view); mayTouch(placed.sheet, shape)) {
      sheets.push_back(placed);
    }
  }
}

void appendPatches(const PlacedSheet& placed, std::int32_t index, const GridShape& shape,
                   std::vector<SheetPatch>& patches) {
  Raster raster;
  if (raster.begin(placed.sheet, shape)) {
    // What stands is as deep as its points lay off the sheet.
    const Vec3 depth = placed.carries ? Vec3::Zero() : Vec3(depthOf(placed.sheet));
    forEachSample(placed.sheet, shape.resolution / 2, [&](const Vec3& p) {
      raster.add(p, shape);
      if (!placed.carries) {
        raster.add(p - depth, shape), raster.add(p + depth, shape);
      }
    });
    raster.flush(placed, index, shape, patches);
  }
}

std::vector<SheetPatch> patchesOf(std::span<const PlacedSheet> sheets, const GridShape& shape,
                                  const ShareDone& progress) {
  PointDensity density;
  for (const PlacedSheet& placed : sheets) {
    density.add(placed.sheet);
  }
  std::vector<SheetPatch> patches;
  for (const PlacedSheet& placed : sheets) {
    if (density.believes(placed.sheet)) {
      appendPatches(placed, static_cast<std::int32_t>(&placed - sheets.data()), shape, patches);
    }
    if (progress) {
      progress(static_cast<double>(&placed - sheets.data() + 1) / static_cast<double>(sheets.size()));
    }
  }
  return patches;
}

Verdict verdictOn(std::span<const SheetPatch> column, std::size_t k) {
  const SheetPatch& p = column[k];
  float densest = 0, finer = 0;
  for (const SheetPatch& other : column) {
    if (other.bottom <= p.top) {  // a beam to what lies above need not have come by here
      densest = std::max(densest, other.density);
    }
    const bool is_within = other.height >= p.bottom && other.height <= p.top;
    const bool says_the_same = p.fuzz > kCloud || (p.carries && other.carries);
    finer += is_within && says_the_same && 2 * other.reach <= p.reach ? other.density : 0;
  }
  if (finer >= p.density) {
    return Verdict::kObsolete;
  }
  return p.density < kStray * densest ? Verdict::kStray : Verdict::kHolds;
}

void appendSurfaces(std::span<SheetPatch> patches, double gap, double step_height, std::vector<Support>& surfaces) {
  std::ranges::sort(patches, [](const SheetPatch& a, const SheetPatch& b) {
    return std::tie(a.bottom, a.top, a.height, a.density) < std::tie(b.bottom, b.top, b.height, b.density);
  });
  const std::size_t first_surface = surfaces.size();
  for (std::size_t begin = 0; begin < patches.size();) {
    float top = patches[begin].top;
    std::size_t end = begin + 1;
    while (end < patches.size() && patches[end].bottom <= top + static_cast<float>(gap)) {
      top = std::max(top, patches[end].top);
      ++end;
    }
    surfaces.push_back(surfaceOf(patches.subspan(begin, end - begin), patches[begin].bottom, top, step_height));
    begin = end;
  }
  for (std::size_t k = first_surface; k + 1 < surfaces.size(); ++k) {
    surfaces[k].clearance = std::max(0.0F, surfaces[k + 1].bottom - surfaces[k].height);
  }
}

}  // namespace hgg
