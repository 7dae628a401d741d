#include "frame/stamp_judge.h"

#include <gtest/gtest.h>

#include <vector>

namespace hgg::stamp_judge_test {
namespace {

constexpr Micros kPeriod_us = 50'000;
constexpr Micros kStart_us = 1'000'000'000;
constexpr Micros kSecond_us = 1'000'000;

using Verdicts = std::vector<StampVerdict>;

Verdicts judgeAll(StampJudge& judge, const std::vector<Micros>& stamps_us) {
  Verdicts out;
  for (const Micros t : stamps_us) {
    out.push_back(judge.judge(t));
  }
  return out;
}

/// A judge that has seen a second of a steady stream; the newest stamp is kStart_us.
StampJudge steadyJudge() {
  StampJudge judge;
  for (Micros t = kStart_us - kSecond_us; t <= kStart_us; t += kPeriod_us) {
    EXPECT_EQ(judge.judge(t), StampVerdict::kNext);
  }
  return judge;
}

TEST(StampJudge, AStreamOfAnyRateIsBelievedWhole) {
  for (const Micros period_us : {Micros{1000}, Micros{50'000}, Micros{500'000}, 2 * kSecond_us, 60 * kSecond_us}) {
    StampJudge judge;
    std::int64_t believed = 0;
    for (int k = 0; k < 20; ++k) {
      const StampVerdict verdict = judge.judge(k * period_us);
      believed += verdict == StampVerdict::kNext ? 1 : verdict == StampVerdict::kConfirms ? 2 : 0;
    }
    EXPECT_EQ(believed + (judge.believesTheLast() ? 1 : 0), 20) << period_us;
    EXPECT_EQ(judge.usualInterval_us(), period_us);
  }
}

TEST(StampJudge, OnAscendingStampsNoneIsLostHoweverUnevenTheyAre) {
  StampJudge judge;
  std::int64_t believed = 0;
  const std::vector<Micros> tenths{0, 1, 2, 10, 11, 12, 27, 28, 60, 200, 201, 900, 5000, 5001, 90'000};
  for (const Micros t : tenths) {
    const StampVerdict verdict = judge.judge(t * 100'000);
    believed += verdict == StampVerdict::kNext ? 1 : verdict == StampVerdict::kConfirms ? 2 : 0;
  }
  EXPECT_EQ(believed + (judge.believesTheLast() ? 1 : 0), std::ssize(tenths));
}

TEST(StampJudge, AnOutlierOfAnySizeIsOverruledByTheNextStamp) {
  for (const Micros off_us : {kSecond_us / 2, 2 * kSecond_us, 8 * kSecond_us, 3600 * kSecond_us, -2 * kSecond_us,
                              -3600 * kSecond_us, -kStart_us}) {
    StampJudge judge = steadyJudge();
    EXPECT_EQ(judgeAll(judge, {kStart_us + off_us, kStart_us + kPeriod_us, kStart_us + 2 * kPeriod_us}),
              (Verdicts{StampVerdict::kApart, StampVerdict::kNext, StampVerdict::kNext}))
        << off_us;
    EXPECT_FALSE(judge.believesTheLast());
  }
}

TEST(StampJudge, TwoWrongStampsMakeNoNewClock) {
  StampJudge judge = steadyJudge();
  EXPECT_EQ(judgeAll(judge, {5, 500 * kSecond_us, kStart_us + kPeriod_us}),
            (Verdicts{StampVerdict::kApart, StampVerdict::kApart, StampVerdict::kNext}));
}

TEST(StampJudge, AClockThatIsSetIsFollowedFromTheSecondStampOn) {
  struct Case {
    Micros step_us;
    StampStep expected;
  };
  for (const auto& [step_us, expected] :
       {Case{-5 * kSecond_us, StampStep::kWentBack}, Case{-900 * kSecond_us, StampStep::kWentBack},
        Case{5 * kSecond_us, StampStep::kSteady}, Case{kPause_us + kSecond_us, StampStep::kPaused}}) {
    StampJudge judge = steadyJudge();
    const Micros anew_us = kStart_us + step_us;
    EXPECT_EQ(judgeAll(judge, {anew_us, anew_us + kPeriod_us, anew_us + 2 * kPeriod_us}),
              (Verdicts{StampVerdict::kApart, StampVerdict::kConfirms, StampVerdict::kNext}))
        << step_us;
    EXPECT_EQ(judge.step(), expected) << step_us;
  }
}

TEST(StampJudge, WhatIsALittleOlderIsLateAndNoOutlier) {
  StampJudge judge = steadyJudge();
  EXPECT_EQ(judgeAll(judge, {kStart_us, kStart_us - kPeriod_us, kStart_us - kLate_us, kStart_us + kPeriod_us}),
            (Verdicts{StampVerdict::kLate, StampVerdict::kLate, StampVerdict::kLate, StampVerdict::kNext}));
}

TEST(StampJudge, AFirstStampThatIsWrongIsOverruledToo) {
  for (const Micros wrong_us : {Micros{0}, 2 * kStart_us}) {
    StampJudge judge;
    EXPECT_EQ(judgeAll(judge, {wrong_us, kStart_us, kStart_us + kPeriod_us, kStart_us + 2 * kPeriod_us}),
              (Verdicts{StampVerdict::kNext, StampVerdict::kApart, StampVerdict::kConfirms, StampVerdict::kNext}));
  }
}

TEST(StampJudge, AtTheEndALastStampAheadIsBelievedAndOneBackIsNot) {
  StampJudge ahead = steadyJudge(), back = steadyJudge();
  EXPECT_EQ(ahead.judge(kStart_us + 4 * kSecond_us), StampVerdict::kApart);
  EXPECT_TRUE(ahead.believesTheLast());
  EXPECT_EQ(back.judge(kStart_us - 4 * kSecond_us), StampVerdict::kApart);
  EXPECT_FALSE(back.believesTheLast());
}

}  // namespace
}  // namespace hgg::stamp_judge_test
