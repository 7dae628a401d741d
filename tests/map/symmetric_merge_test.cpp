#include <gtest/gtest.h>

#include "core/classes.h"
#include "map/fuse.h"
#include "map/test_map.h"

namespace hgg::symmetric_merge_test {
namespace {

const Belief kSeenALot{Vec3(0, 0, 0), Vec3(1, 1, 1).asDiagonal(), 900};
const Belief kSeenOnce{Vec3(2, 0, 0), Vec3(3, 1, 1).asDiagonal(), 100};

TEST(MergeSymmetrically, IsBlindToEvidenceButAddsIt) {
  const Belief b = mergeSymmetrically(kSeenALot, kSeenOnce);
  EXPECT_EQ(b.mean, Vec3(1, 0, 0));
  EXPECT_TRUE(b.cov.isApprox(Mat3(Vec3(2.0 + 1.0, 1, 1).asDiagonal())));  // average plus (2 / 2)^2 between the means
  EXPECT_EQ(b.kappa, 1000.0);
}

TEST(MergeSymmetrically, OfEqualEvidenceIsTheConjugateMerge) {
  Belief other = kSeenOnce;
  other.kappa = kSeenALot.kappa;
  const Belief a = mergeSymmetrically(kSeenALot, other), b = merge(kSeenALot, other);
  EXPECT_TRUE(a.mean.isApprox(b.mean));
  EXPECT_TRUE(a.cov.isApprox(b.cov));
  EXPECT_EQ(a.kappa, b.kappa);
}

/// The one node of a map after it was seen again, 0.2 m beside itself, with a ninth of its evidence.
Belief seenAgain(bool symmetric) {
  Config config;
  config.ablation.symmetric_merge = symmetric;
  const Map map = mapOf({nodeAt(10, Vec3(5, 0, 0), 0.5, 900)});
  LocalGraph local;
  LocalObject object;
  object.label = 10;
  object.belief = {Vec3(5.2, 0, 0), 0.25 * Mat3::Identity(), 100};
  local.objects = {object};
  const MapUpdate update = fuse(map, local, Pose::Identity(), {{0, 1}}, {}, ClassTable::builtin(), config);
  EXPECT_EQ(update.changed.size(), 1U);
  return update.changed.at(0).belief;
}

TEST(Fuse, SwitchesToTheSymmetricMerge) {
  EXPECT_NEAR(seenAgain(false).mean.x(), 5.02, 1e-12);
  EXPECT_NEAR(seenAgain(true).mean.x(), 5.1, 1e-12);
  EXPECT_EQ(seenAgain(true).kappa, 1000.0);
}

TEST(FuseLeaves, FollowTheRule) {
  const Belief old_leaf{Vec3(0.1, 0.1, 0.1), 0.001 * Mat3::Identity(), 90},
      new_leaf{Vec3(0.2, 0.1, 0.1), 0.001 * Mat3::Identity(), 10};
  for (const auto& [rule, x] : {std::pair{MergeRule(merge), 0.11}, std::pair{MergeRule(mergeSymmetrically), 0.15}}) {
    std::vector<Leaf> leaves{packLeaf(old_leaf)};
    leaves = fuseLeaves(leaves, std::vector{new_leaf}, Pose::Identity(), 0.4, rule);
    ASSERT_EQ(leaves.size(), 1U);
    EXPECT_NEAR(leaves[0].mean[0], x, 1e-6);
  }
}

}  // namespace
}  // namespace hgg::symmetric_merge_test
