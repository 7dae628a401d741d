#include "correction/loop_agreement.h"

#include <gtest/gtest.h>

#include "core/units.h"

namespace hgg::loop_agreement_test {
namespace {

const LoopConfig kConfig = loopConfigOf(10, 0.4, 3);  // m: tiles, leaves, gate

Pose at(double x, double y, double yaw_deg = 0) {
  Pose T = Pose::Identity();
  T.translation() = Vec3(x, y, 0);
  T.rotate(Eigen::AngleAxisd(yaw_deg * kDegree, Vec3::UnitZ()));
  return T;
}

/// A hundred keyframes along x, 2 m apart, with some turn so that frames matter.
KeyframeGraph chain() {
  KeyframeGraph graph;
  for (int k = 0; k < 100; ++k) {
    graph.add({k, at(2.0 * k, 0, 7 * k)});
  }
  return graph;
}

/// A loop that says: keyframe b is really where `T_map_map` moves it. All loops of one T_map_map agree.
VerifiedLoop loop(const KeyframeGraph& graph, KeyframeId a, KeyframeId b, const Pose& T_map_map,
                  double deviations = 1) {
  const auto pose = [&](KeyframeId k) { return graph.poses()[static_cast<std::size_t>(k)].T_map_body; };
  return {{a, b, pose(a).inverse() * T_map_map * pose(b), 0.1, 0.01, true}, deviations};
}

struct Agreement {
  KeyframeGraph graph = chain();
  LoopAgreement loops{kConfig};

  void add(KeyframeId a, KeyframeId b, const Pose& T_map_map, double deviations = 1) {
    loops.add(loop(graph, a, b, T_map_map, deviations));
  }
  std::size_t agreeing() const { return loops.agreeingWithNewest(graph).size(); }
  std::vector<VerifiedLoop> overruling() const { return loops.overruling(graph); }
};

const Pose kShift = at(-3, 40, 25);  // of the map's end
Pose off(double metres, double degrees) { return at(metres, 0, 0) * kShift * at(0, 0, degrees); }

TEST(LoopAgreement, LoopsThatMoveTheirPlacesAlikeAgree) {
  Agreement a;
  a.add(3, 80, kShift);
  EXPECT_EQ(a.agreeing(), 0U) << "one alone agrees with nothing";
  a.add(5, 82, kShift);
  EXPECT_EQ(a.agreeing(), 1U);
  a.add(1, 84, kShift);
  EXPECT_EQ(a.agreeing(), 2U);
}

TEST(LoopAgreement, LoopsThatMoveTheirPlacesDifferentlyDoNot) {
  // At the newest keyframe itself, so that a turn does not swing it.
  const auto agree = [](const Pose& difference) {
    Agreement a;
    a.add(3, 80, kShift);
    VerifiedLoop second = loop(a.graph, 3, 80, kShift);
    second.loop.T_a_b = second.loop.T_a_b * difference;
    a.loops.add(second);
    return a.agreeing() == 1;
  };
  EXPECT_TRUE(agree(at(0.9 * kConfig.agree_distance, 0)));
  EXPECT_FALSE(agree(at(1.1 * kConfig.agree_distance, 0)));
  EXPECT_TRUE(agree(at(0, 0, 0.9 * kConfig.agree_turn / kDegree)));
  EXPECT_FALSE(agree(at(0, 0, 1.1 * kConfig.agree_turn / kDegree)));
  EXPECT_FALSE(agree(at(0, 0, 180)));
}

TEST(LoopAgreement, LoopsOfLongAgoAreNotAsked) {
  Agreement near, far;
  near.add(3, 50, kShift), near.add(5, 80, kShift);
  far.add(3, 49, kShift), far.add(5, 80, kShift);
  EXPECT_EQ(near.agreeing(), 1U);
  EXPECT_EQ(far.agreeing(), 0U);
}

TEST(LoopAgreement, OnlyTheLastSixAreKept) {
  Agreement a;
  a.add(3, 80, kShift);
  for (int k = 0; k < 5; ++k) {
    a.add(3, 81 + k, off(50.0 * (k + 1), 0));
  }
  EXPECT_EQ(a.agreeing(), 0U);
  a.add(3, 90, kShift);  // the first one has gone
  EXPECT_EQ(a.agreeing(), 0U);
}

TEST(LoopAgreement, ClearedNothingIsLeft) {
  Agreement a;
  a.add(3, 80, kShift), a.add(5, 82, kShift), a.add(7, 84, kShift);
  a.loops.clear();
  EXPECT_TRUE(a.overruling().empty());
  a.add(5, 86, kShift);
  EXPECT_EQ(a.agreeing(), 0U);
}

TEST(LoopAgreement, ThreeThatAgreeOverruleTheKeyframes) {
  Agreement a;
  a.add(3, 80, kShift), a.add(5, 82, kShift);
  EXPECT_TRUE(a.overruling().empty()) << "two may be chance";
  a.add(7, 84, kShift);
  ASSERT_EQ(a.overruling().size(), 3U);
  EXPECT_EQ(a.overruling().back().loop.b, 84) << "the newest last";
}

TEST(LoopAgreement, ADissenterAmongTheLastThreeStopsThem) {
  for (int dissenter = 0; dissenter < 3; ++dissenter) {
    Agreement a;
    for (int k = 0; k < 3; ++k) {
      a.add(3 + k, 80 + k, k == dissenter ? off(5, 0) : kShift);
    }
    EXPECT_TRUE(a.overruling().empty()) << dissenter;
  }
  Agreement early;  // one before the last three does not
  early.add(2, 79, off(5, 0)), early.add(3, 80, kShift), early.add(4, 81, kShift), early.add(5, 82, kShift);
  EXPECT_EQ(early.overruling().size(), 3U);
}

TEST(LoopAgreement, LoopsFarApartDoNotOverrule) {
  Agreement a;
  a.add(3, 49, kShift), a.add(5, 65, kShift), a.add(7, 80, kShift);  // 31 keyframes from first to last
  EXPECT_TRUE(a.overruling().empty());
}

TEST(LooseningFor, IsWhatAllOfTheLoopsSpanByTheLargestDeviation) {
  const KeyframeGraph graph = chain();
  const Loosening loosening =
      looseningFor({loop(graph, 3, 80, kShift, 7), loop(graph, 9, 84, kShift, 20), loop(graph, 5, 82, kShift, 6)});
  EXPECT_EQ(loosening.from, 9);
  EXPECT_EQ(loosening.to, 80);
  EXPECT_EQ(loosening.factor, 20);
}

TEST(LooseningFor, NeverTightens) { EXPECT_EQ(looseningFor({loop(chain(), 3, 80, kShift, 0.2)}).factor, 1); }

}  // namespace
}  // namespace hgg::loop_agreement_test
