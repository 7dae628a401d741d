#include "alignment/fit.h"

#include <gtest/gtest.h>

#include "core/units.h"

namespace hgg::fit_test {
namespace {

Mat3 turnedBy(double degrees, const Mat3& cov) {
  const Mat3 R = Eigen::AngleAxisd(degrees * kDegree, Vec3::UnitX()).toRotationMatrix();
  return R * cov * R.transpose();
}

/// A level piece of surface, half a metre wide and 1 cm thick.
Mat3 plate() { return Vec3(0.06, 0.06, 1e-4).asDiagonal(); }
Mat3 wall() { return turnedBy(90, plate()); }

TEST(IsUpright, LevelGroundIsNot) {
  EXPECT_FALSE(isUpright(plate()));
  EXPECT_FALSE(isUpright(Vec3(0.06, 0.06, 0).asDiagonal())) << "nor is a perfect plane";
}

TEST(IsUpright, AWallIs) { EXPECT_TRUE(isUpright(wall())); }

TEST(IsUpright, ASlopeIsGroundUpTo37Degrees) {
  for (const double degrees : {10.0, 30.0, 36.0, -36.0}) {
    EXPECT_FALSE(isUpright(turnedBy(degrees, plate()))) << degrees;
  }
  for (const double degrees : {38.0, 45.0, 80.0, -38.0}) {
    EXPECT_TRUE(isUpright(turnedBy(degrees, plate()))) << degrees;
  }
}

TEST(IsUpright, WhatIsNotFlatIs) {
  EXPECT_TRUE(isUpright(0.04 * Mat3::Identity())) << "a ball";
  EXPECT_TRUE(isUpright(Vec3(1e-3, 1e-3, 0.5).asDiagonal())) << "a pole";
  EXPECT_TRUE(isUpright(Vec3(0.5, 1e-3, 1e-3).asDiagonal())) << "a rail";
}

/// A frame of one object at the origin, and its leaves' partners in the map.
struct Scene {
  LocalGraph local;
  std::vector<ObjectPair> pairs{{0, 1, 0}};
  std::vector<LeafPair> leaf_pairs;
  std::vector<GaussianPair> gaussians;

  Scene() { local.objects.resize(1); }

  int addLeaf(const Mat3& cov) {
    auto& leaves = local.objects[0].leaves;
    leaves.push_back({Vec3::Zero(), cov, 10});
    return static_cast<int>(leaves.size()) - 1;
  }
  /// A partner that the leaf lies `deviations` from.
  void pairLeaf(int leaf, double deviations) {
    leaf_pairs.push_back({0, leaf, 0});
    GaussianPair pair;  // two unit Gaussians: their distance has a variance of 2
    pair.mean_map = Vec3(deviations * std::sqrt(2.0), 0, 0);
    gaussians.push_back(pair);
  }
  Fit fit(std::size_t stride = 1, const Pose& T = Pose::Identity()) const {
    return fitOf(local, pairs, leaf_pairs, gaussians, stride, T);
  }
};

TEST(FitOf, CountsUprightLeavesOfKnownObjectsAndThoseThatLieOnTheMap) {
  Scene scene;
  scene.pairLeaf(scene.addLeaf(wall()), 0.1);
  scene.pairLeaf(scene.addLeaf(wall()), 2.9);
  scene.pairLeaf(scene.addLeaf(wall()), 3.1);  // too far off
  scene.addLeaf(wall());                       // without a partner
  scene.pairLeaf(scene.addLeaf(plate()), 0);   // ground
  EXPECT_EQ(scene.fit().known, 4);
  EXPECT_EQ(scene.fit().fitting, 2);
  EXPECT_EQ(scene.fit().share(), 0.5);
}

TEST(FitOf, LeavesOfObjectsThatTheMapDoesNotKnowDoNotCount) {
  Scene scene;
  scene.pairLeaf(scene.addLeaf(wall()), 0);
  scene.local.objects.insert(scene.local.objects.begin(), LocalObject{});
  scene.local.objects[0].leaves.assign(7, {Vec3::Zero(), wall(), 10});
  scene.pairs[0].local = 1;
  EXPECT_EQ(scene.fit().known, 1);
  EXPECT_EQ(scene.fit().fitting, 1);
  scene.pairs.clear(), scene.leaf_pairs.clear(), scene.gaussians.clear();
  EXPECT_EQ(scene.fit().known, 0);
  EXPECT_EQ(scene.fit().share(), 0);
}

TEST(FitOf, LeavesThatWereNotLookedForAreNotMissed) {
  Scene scene;
  for (int k = 0; k < 7; ++k) {
    scene.addLeaf(wall());
  }
  EXPECT_EQ(scene.fit(1).known, 7);
  EXPECT_EQ(scene.fit(2).known, 4);  // 0 2 4 6
  EXPECT_EQ(scene.fit(3).known, 3);  // 0 3 6
}

TEST(FitOf, WhatIsUprightIsToldInTheMapsFrame) {
  Scene scene;
  scene.pairLeaf(scene.addLeaf(plate()), 0);
  Pose T_rolled = Pose::Identity();
  T_rolled.rotate(Eigen::AngleAxisd(90 * kDegree, Vec3::UnitX()));
  EXPECT_EQ(scene.fit(1).known, 0);
  EXPECT_EQ(scene.fit(1, T_rolled).known, 1);
  EXPECT_EQ(scene.fit(1, T_rolled).fitting, 1);
  scene.local.objects[0].T_body_object = T_rolled;
  EXPECT_EQ(scene.fit(1).known, 1) << "nor does the object's frame matter";
}

TEST(UsualFit, FollowsTheShareSlowly) {
  UsualFit usual;
  EXPECT_EQ(usual.share(), 0);
  usual.learn({100, 80});
  EXPECT_DOUBLE_EQ(usual.share(), 0.8);
  usual.learn({100, 60});
  EXPECT_DOUBLE_EQ(usual.share(), 0.78);
  for (int k = 0; k < 100; ++k) {
    usual.learn({100, 60});
  }
  EXPECT_NEAR(usual.share(), 0.6, 1e-3);
}

TEST(UsualFit, LessThanHalfOfWhatIsUsualIsACollapse) {
  UsualFit usual;
  EXPECT_FALSE(usual.hasCollapsed({100, 0})) << "nothing is usual yet";
  usual.learn({100, 80});
  EXPECT_FALSE(usual.hasCollapsed({1000, 401}));
  EXPECT_TRUE(usual.hasCollapsed({1000, 399}));
}

TEST(UsualFit, FewLeavesTellNothing) {
  EXPECT_FALSE(UsualFit::canTell({29, 29}));
  EXPECT_TRUE(UsualFit::canTell({30, 0}));
  UsualFit usual;
  usual.learn({29, 29});
  EXPECT_EQ(usual.share(), 0);
  usual.learn({100, 80});
  usual.learn({29, 0});
  EXPECT_DOUBLE_EQ(usual.share(), 0.8);
  EXPECT_FALSE(usual.hasCollapsed({29, 0}));
  EXPECT_TRUE(usual.hasCollapsed({30, 0}));
}

}  // namespace
}  // namespace hgg::fit_test
