#include "place/surfaces.h"

#include <nanoflann.hpp>

namespace hgg {
namespace {

constexpr double kFarthest = 1e9;  // m: no map is that large, and squared distances of what is nearer stay finite
/// Points in a leaf of the tree: of 10, 16 and 32 the last answered fastest (bench/place_bench).
constexpr std::size_t kLeafPoints = 32;

/// The means that are indexed, as nanoflann asks for them.
struct Means {
  std::vector<Vec3> points;
  std::vector<std::size_t> index;  // of the surface, one a point

  explicit Means(std::span<const Surface> surfaces) {
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
      if ((surfaces[i].mean.array().abs() < kFarthest).all()) {
        points.push_back(surfaces[i].mean);
        index.push_back(i);
      }
    }
  }
  std::size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const { return points[i][static_cast<Eigen::Index>(axis)]; }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using MeansTree =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Means>, Means, 3, std::size_t>;

/// Collects what lies within a radius without the distances, which nobody asks for. The names are nanoflann's.
struct Within {
  using DistanceType = double;
  double square_radius;
  const std::vector<std::size_t>& index;
  std::vector<std::size_t>& found;

  std::size_t size() const { return found.size(); }
  bool full() const { return true; }  // the radius bounds the search from the start
  double worstDist() const { return square_radius; }
  bool addPoint(double square, std::size_t i) {
    if (square < square_radius) {
      found.push_back(index[i]);
    }
    return true;
  }
};

}  // namespace

struct SurfaceIndex::Tree {
  Means means;
  MeansTree tree;
  explicit Tree(std::span<const Surface> surfaces) : means(surfaces), tree(3, means, {kLeafPoints}) {}
};

SurfaceIndex::SurfaceIndex(std::span<const Surface> surfaces) : tree_(std::make_unique<const Tree>(surfaces)) {}

SurfaceIndex::~SurfaceIndex() = default;

void SurfaceIndex::near(const Vec3& p, double radius, std::vector<std::size_t>& found) const {
  found.clear();
  if (radius > 0 && (p.array().abs() < 2 * kFarthest).all()) {
    Within within{radius * radius, tree_->means.index, found};
    tree_->tree.findNeighbors(within, p.data(), {});
  }
}

}  // namespace hgg
