#include "traversability/octomap_export.h"

#include <gtest/gtest.h>
#include <octomap/ColorOcTree.h>
#include <octomap/OcTree.h>

#include <sstream>

#include "map/export.h"
#include "surfaces_world.h"

namespace hgg::octomap_export_test {
namespace {

/// A floor, and a wall across it at x = 1 that is seen from the origin.
SurfacesWorld floorAndWall() {
  SurfacesWorld world;
  world.addFloor(-2, -2, 1, 2);
  world.add({1.02, -2, 0}, {0, 4, 0}, {0, 0, 1.5});
  return world;
}

octomap::OcTree read(const std::string& bytes, double resolution) {
  octomap::OcTree tree(resolution);
  std::istringstream in(bytes);
  EXPECT_TRUE(tree.readBinary(in));
  return tree;
}

enum class State { kUnknown, kFree, kOccupied };

State stateAt(const octomap::OcTree& tree, double x, double y, double z) {
  const octomap::OcTreeNode* node = tree.search(x, y, z);
  return node == nullptr ? State::kUnknown : tree.isNodeOccupied(node) ? State::kOccupied : State::kFree;
}

TEST(OctomapExport, SurfacesAreOccupiedWhatWasSeenThroughIsFreeAndTheRestUnknown) {
  for (const double resolution : {0.1, 0.2}) {
    const Result<VoxelGrid> voxels = voxelsOf(floorAndWall().map(), {resolution, std::nullopt});
    ASSERT_TRUE(voxels) << voxels.error;
    const octomap::OcTree tree = read(octomapBinary(*voxels), resolution);
    EXPECT_EQ(tree.getResolution(), resolution);
    for (const double v : {-1.5, -0.25, 0.55}) {
      EXPECT_EQ(stateAt(tree, v, 0.05, 0.001), State::kOccupied) << v;
      EXPECT_EQ(stateAt(tree, 1.02, v, 0.75), State::kOccupied) << v;
    }
    EXPECT_EQ(stateAt(tree, 0.5, 0.05, 0.6), State::kFree);
    EXPECT_EQ(stateAt(tree, 1.55, 0.05, 0.6), State::kUnknown) << "behind the wall";
    EXPECT_EQ(stateAt(tree, 0.5, 0.05, -0.5), State::kUnknown) << "below the floor";
  }
}

TEST(OctomapExport, ARayDoesNotCarveThroughASurfaceThatIsKnown) {
  SurfacesWorld world = floorAndWall();
  world.add({2.02, -2, 0}, {0, 4, 0}, {0, 0, 1.5});  // behind the first wall, seen on some other day
  const Result<VoxelGrid> voxels = voxelsOf(world.map(), {0.1, std::nullopt});
  const octomap::OcTree tree = read(octomapBinary(*voxels), 0.1);
  for (double y = -1.85; y < 1.9; y += 0.1) {
    EXPECT_EQ(stateAt(tree, 1.02, y, 0.75), State::kOccupied) << y;
    EXPECT_EQ(stateAt(tree, 1.55, y, 0.6), State::kUnknown) << y;
  }
}

TEST(OctomapExport, ADistantLookGivesWayToFinerLeavesThatSayWhatIsThere) {
  SurfacesWorld world = floorAndWall();
  world.addFloor(-2, -2, 2, 2, 0.005, 3, 4);  // one leaf, which reaches behind the wall
  const Result<VoxelGrid> with = voxelsOf(world.map(), {0.1, std::nullopt});
  const Result<VoxelGrid> without = voxelsOf(floorAndWall().map(), {0.1, std::nullopt});
  EXPECT_EQ(octomapBinary(*with), octomapBinary(*without));
}

TEST(OctomapExport, TheRegionBoundsIt) {
  const Result<VoxelGrid> voxels = voxelsOf(floorAndWall().map(), {0.1, GridRegion{-1, -1, 0, 1}});
  ASSERT_TRUE(voxels) << voxels.error;
  voxels->forEach([&](const Voxel& v, float) {
    const Vec3 p = voxels->centreOf(v);
    EXPECT_TRUE(p.x() > -1 && p.x() < 0 && p.y() > -1 && p.y() < 1) << p.transpose();
  });
}

TEST(OctomapExport, EqualMapsGiveEqualBytesAndTheFullTreeKeepsProbabilities) {
  const Result<VoxelGrid> a = voxelsOf(floorAndWall().map(), {0.1, std::nullopt});
  const Result<VoxelGrid> b = voxelsOf(floorAndWall().map(), {0.1, std::nullopt});
  EXPECT_EQ(octomapBinary(*a), octomapBinary(*b));
  std::istringstream in(octomapFull(*a));
  const std::unique_ptr<octomap::AbstractOcTree> tree(octomap::AbstractOcTree::read(in));
  const auto* full = dynamic_cast<octomap::OcTree*>(tree.get());
  ASSERT_NE(full, nullptr);
  EXPECT_GT(full->search(0.55, 0.05, 0.001)->getOccupancy(), 0.9);
}

TEST(OctomapExport, PartsLieSideBySideAndAreTheWhole) {
  const Result<VoxelGrid> voxels = voxelsOf(floorAndWall().map(), {0.1, std::nullopt});
  const octomap::OcTree whole = read(octomapBinary(*voxels), 0.1);
  const std::vector<std::string> parts = octomapParts(*voxels, 600);
  ASSERT_GT(parts.size(), 3U);
  std::vector<octomap::OcTree> trees;
  for (const std::string& part : parts) {
    EXPECT_LE(part.size(), 600U);
    trees.push_back(read(part, 0.1));
  }
  voxels->forEach([&](const Voxel& v, float) {
    const Vec3 p = voxels->centreOf(v);
    int found = 0;
    for (const octomap::OcTree& tree : trees) {
      if (stateAt(tree, p.x(), p.y(), p.z()) != State::kUnknown) {
        ++found;
        EXPECT_EQ(stateAt(tree, p.x(), p.y(), p.z()), stateAt(whole, p.x(), p.y(), p.z()));
      }
    }
    EXPECT_EQ(found, 1);
  });
  EXPECT_EQ(octomapParts(*voxels, 1 << 20).size(), 1U);
}

TEST(OctomapExport, AColouredTreeHasTheColourOfTheClassAtEachOccupiedVoxel) {
  SurfacesWorld world = floorAndWall();
  Map map = world.map();
  MapUpdate update;
  MapNode wall = map.nodes().rbegin()->second;
  wall.label = 50;
  wall.classes = {};
  addViews(wall.classes, {{50, 1000.0F}});
  update.changed = {wall};
  map.apply(std::move(update));
  VoxelOptions options{0.1, std::nullopt};
  options.classes = true;
  const Result<VoxelGrid> voxels = voxelsOf(map, options);
  ASSERT_TRUE(voxels) << voxels.error;
  std::istringstream in(octomapColoured(*voxels));
  const std::unique_ptr<octomap::AbstractOcTree> tree(octomap::AbstractOcTree::read(in));
  auto* coloured = dynamic_cast<octomap::ColorOcTree*>(tree.get());
  ASSERT_NE(coloured, nullptr);
  const auto colourAt = [&](double x, double y, double z) {
    const auto* node = coloured->search(x, y, z);
    EXPECT_TRUE(node != nullptr && coloured->isNodeOccupied(node));
    return node == nullptr ? octomap::ColorOcTreeNode::Color() : node->getColor();
  };
  const auto expected = [](ClassId label) {
    const auto rgb = colourOf(label);
    return octomap::ColorOcTreeNode::Color(rgb[0], rgb[1], rgb[2]);
  };
  for (const double v : {-1.55, -0.25, 0.55}) {
    EXPECT_EQ(colourAt(v, 0.05, 0.001), expected(1));
    EXPECT_EQ(colourAt(1.02, v, 0.75), expected(50));
  }
  std::size_t known = 0, occupied = 0;
  voxels->forEach([&](const Voxel& v, float log_odds) {
    const Vec3 p = voxels->centreOf(v);
    const auto* node = coloured->search(p.x(), p.y(), p.z());
    known += node != nullptr && node->getLogOdds() == log_odds ? 1 : 0;
    occupied += 1;
  });
  EXPECT_EQ(known, occupied) << "pruning loses nothing";
}

TEST(OctomapExport, RefusesResolutionsThatAreNone) {
  for (const double resolution : {0.0, 1e-9, -1.0, 1e9}) {
    EXPECT_NE(voxelsOf(floorAndWall().map(), {resolution, std::nullopt}).error, "") << resolution;
  }
  EXPECT_NE(voxelsOf(Map(), {0.1, std::nullopt}).error, "");
  EXPECT_NE(voxelsOf(floorAndWall().map(), {0.1, GridRegion{50, 50, 60, 60}}).error, "");
}

TEST(Sample, PointsAreNoFartherApartThanAskedAndCoverTheSheet) {
  std::mt19937 random(3);
  for (int round = 0; round < 20; ++round) {
    const LeafSheet sheet = sheetOf(randomBelief(random, 2));
    const double spacing = 0.05;
    std::vector<Vec3> points;
    forEachSample(sheet, spacing, [&](const Vec3& p) { points.push_back(p); });
    for (int k = 0; k < 200; ++k) {  // any place of the ellipse has a sample near it
      const double angle = 0.1 * k, radius = std::sqrt((k % 17) / 17.0);
      const Vec3 p = sheet.centre + radius * (std::cos(angle) * sheet.half_along * sheet.along +
                                              std::sin(angle) * sheet.half_across * sheet.across);
      double nearest = 1e9;
      for (const Vec3& q : points) {
        nearest = std::min(nearest, (p - q).norm());
      }
      EXPECT_LT(nearest, 1.5 * spacing) << round << " " << k;
    }
  }
}

TEST(Sample, HasTheCovarianceOfTheLeaf) {
  Belief leaf;
  leaf.mean = {1, 2, 3};
  leaf.cov = Vec3(0.04, 0.01, 1e-6).asDiagonal();
  leaf.kappa = 10;
  std::vector<Vec3> points;
  forEachSample(sheetOf(leaf), 0.005, [&](const Vec3& p) { points.push_back(p); });
  const Belief sampled = beliefFromPoints(points);
  EXPECT_LT((sampled.mean - leaf.mean).norm(), 0.005);
  EXPECT_NEAR(sampled.cov(0, 0), 0.04, 0.002);
  EXPECT_NEAR(sampled.cov(1, 1), 0.01, 0.0005);
}

}  // namespace
}  // namespace hgg::octomap_export_test
