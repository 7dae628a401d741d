#include "core/class_belief.h"

#include <gtest/gtest.h>

namespace hgg::class_belief_test {
namespace {

constexpr ClassId kCar = 10, kTruck = 18, kRoad = 40;

/// A belief after these views.
ClassBelief after(const ClassWeights& views) {
  ClassBelief belief;
  addViews(belief, views);
  return belief;
}

TEST(ClassBelief, ViewsAddUpByClassInOrder) {
  ClassBelief belief;
  addViews(belief, {{kTruck, 1}});
  addViews(belief, {{kCar, 0.5F}, {kTruck, 0.25F}});
  EXPECT_EQ(belief.views, (ClassWeights{{kCar, 0.5F}, {kTruck, 1.25F}}));
  EXPECT_DOUBLE_EQ(weightOf(belief.views, kTruck), 1.25);
  EXPECT_DOUBLE_EQ(weightOf(belief.views, kRoad), 0);
  EXPECT_DOUBLE_EQ(sumOf(belief.views), 1.75);
}

TEST(ClassBelief, TheLikeliestClassHasMostViewsAndTiesGoToTheSmallerId) {
  EXPECT_EQ(likeliestClass(after({{kCar, 2}, {kTruck, 3}}), kRoad), kTruck);
  EXPECT_EQ(likeliestClass(after({{kCar, 3}, {kTruck, 3}}), kRoad), kCar);
  EXPECT_EQ(likeliestClass({}, kRoad), kRoad);
}

TEST(ClassBelief, ProbabilitiesAreSharesOfTheViews) {
  EXPECT_EQ(classProbabilities(after({{kCar, 3}, {kTruck, 1}})), (ClassWeights{{kCar, 0.75F}, {kTruck, 0.25F}}));
  EXPECT_TRUE(classProbabilities({}).empty());
}

TEST(ClassBelief, AFewPointsSeenOnceAreNotBelieved) {
  EXPECT_LT(existence(after({{kCar, 1}}), kCar, 30), 0.5);
  EXPECT_GT(existence(after({{kCar, 3}}), kCar, 90), 0.5) << "seen again and again";
  EXPECT_GT(existence(after({{kCar, 1}}), kCar, 5000), 0.5) << "seen once, and well";
  EXPECT_EQ(existence({}, kCar, 5000), 0);
}

TEST(ClassBelief, ExistenceGrowsWithFindsAndFallsWithMisses) {
  double last = 0;
  for (int finds = 1; finds < 20; ++finds) {
    const double now = existence(after({{kCar, static_cast<float>(finds)}, {kRoad, 5}}), kCar, 500);
    EXPECT_GT(now, last);
    last = now;
  }
  for (int misses = 6; misses < 200; ++misses) {
    const double now = existence(after({{kCar, 19}, {kRoad, static_cast<float>(misses)}}), kCar, 500);
    EXPECT_LT(now, last);
    last = now;
  }
  EXPECT_LT(last, 0.5) << "the road is seen where the car should be";
}

TEST(ClassBelief, SegmentersMissMoreThanTheyMakeUp) {
  EXPECT_GT(existence(after({{kCar, 100}, {kRoad, 200}}), kCar, 1000), 0.5);
  EXPECT_LT(existence(after({{kCar, 100}, {kRoad, 400}}), kCar, 1000), 0.5);
}

TEST(ClassBelief, AYearOfViewsCanStillBeOutvoted) {
  ClassBelief belief;
  for (int k = 0; k < 100'000; ++k) {
    addViews(belief, {{kCar, 1}});
  }
  for (int k = 0; k < 1'000; ++k) {
    addViews(belief, {{kTruck, 1}});
  }
  EXPECT_EQ(likeliestClass(belief, kRoad), kTruck);
}

/// After `finds` views of a thing, `gone` views through its place.
double existenceAfter(int finds, int gone) {
  ClassBelief belief;
  for (int k = 0; k < finds; ++k) {
    addPlaceView(belief, {{{kCar, 0.9F}}, 0.9, 0.05, 1}, kCar);
  }
  for (int k = 0; k < gone; ++k) {
    addPlaceView(belief, {{}, 0.05, 0.8, 0}, kCar);
  }
  return existence(belief, kCar, 1000);
}

TEST(FreeSpace, AThingSeenAThousandTimesFadesWithinOneGoodLook) {
  EXPECT_GT(existenceAfter(1000, 0), 0.9);
  EXPECT_GT(existenceAfter(1000, 4), 0.9) << "not at once";
  EXPECT_LT(existenceAfter(1000, 20), 0.5) << "two seconds";
  EXPECT_LT(existenceAfter(1000, 30), 0.1);
}

TEST(FreeSpace, ATrailFadesFaster) {
  EXPECT_GT(existenceAfter(3, 0), 0.5);
  EXPECT_LT(existenceAfter(3, 4), 0.5);
}

TEST(FreeSpace, AThingWronglySeenThroughComesBack) {
  ClassBelief belief = after({{kCar, 50}});
  for (int k = 0; k < 10; ++k) {
    addPlaceView(belief, {{}, 0, 0.9, 0}, kCar);
  }
  EXPECT_LT(existence(belief, kCar, 1000), 0.5);
  addPlaceView(belief, {{{kCar, 0.8F}}, 0.8, 0.1, 1}, kCar);
  EXPECT_GT(existence(belief, kCar, 1000), 0.9);
}

TEST(FreeSpace, WhatIsTakenUnderAnotherNameIsNotGone) {
  ClassBelief belief = after({{kCar, 20}});
  for (int k = 0; k < 40; ++k) {
    addPlaceView(belief, {{{kRoad, 0.5F}}, 0.6, 0.1, 0}, kCar);
  }
  EXPECT_LT(belief.seen_through, 0.5);
}

TEST(FreeSpace, WhatAlwaysLetBeamsThroughIsNotGoneForIt) {
  ClassBelief foliage;
  for (int k = 0; k < 200; ++k) {
    addPlaceView(foliage, {{{kCar, 0.3F}}, 0.3, 0.5, 1}, kCar);
  }
  for (int k = 0; k < 100; ++k) {
    addPlaceView(foliage, {{}, 0.3, 0.5, 0}, kCar);
  }
  EXPECT_GT(existence(foliage, kCar, 1000), 0.9);
}

}  // namespace
}  // namespace hgg::class_belief_test
