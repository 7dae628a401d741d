#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "eval/evaluate.h"
#include "eval/loops.h"
#include "eval/report.h"
#include "tools/scratch.h"

namespace hgg::loops_eval_test {
namespace {

constexpr Micros kStep_us = 100000;
constexpr RevisitScale kScale{2, 10, 100, 30};

/// Poses every metre of way through the corners, 0.1 s apart, looking ahead.
std::vector<PosePair> driveThrough(const std::vector<Vec3>& corners) {
  std::vector<PosePair> pairs;
  for (std::size_t leg = 0; leg + 1 < corners.size(); ++leg) {
    const Vec3 along = (corners[leg + 1] - corners[leg]).normalized();
    const int steps = static_cast<int>(std::lround((corners[leg + 1] - corners[leg]).norm()));
    for (int i = 0; i < steps; ++i) {
      Pose pose = Pose::Identity();
      pose.translation() = corners[leg] + i * along;
      pose.linear() = Eigen::AngleAxisd(std::atan2(along.y(), along.x()), Vec3::UnitZ()).toRotationMatrix();
      pairs.push_back({pose, Pose::Identity(), static_cast<Micros>(pairs.size()) * kStep_us});
    }
  }
  return pairs;
}

/// Round a block of 100 m x 50 m and 60 m along its first side again.
std::vector<PosePair> roundTheBlock() {
  return driveThrough(
      {Vec3(0, 0, 0), Vec3(100, 0, 0), Vec3(100, 50, 0), Vec3(0, 50, 0), Vec3(0, 0, 0), Vec3(60, 0, 0)});
}

/// The true loop between two poses, moved by `off` and turned by `deg`.
LoopRun loopBetween(const std::vector<PosePair>& pairs, std::size_t before, std::size_t now, double off = 0,
                    double deg = 0) {
  Pose E = Pose::Identity();
  E.translation() = Vec3(0, off, 0);
  E.linear() = Eigen::AngleAxisd(deg * M_PI / 180, Vec3::UnitZ()).toRotationMatrix();
  return {pairs[before].utime_us, pairs[now].utime_us, true,
          pairs[before].T_truth_body.inverse() * pairs[now].T_truth_body * E};
}

LoopRuns runsOf(std::vector<LoopRun> list) {
  const auto accepted = static_cast<std::size_t>(std::ranges::count(list, true, &LoopRun::accepted));
  return {accepted, list.size() - accepted, std::move(list)};
}

TEST(FindRevisits, OneRunAroundTheBlock) {
  const auto revisits = findRevisits(roundTheBlock(), kScale);
  ASSERT_EQ(revisits.size(), 1u);
  EXPECT_NEAR(revisits[0].first, 290, 2);  // 10 m before the way closes
  EXPECT_NEAR(revisits[0].last, 358, 2);   // 360 m in all
}

TEST(FindRevisits, NothingComesBackOnAStraightWay) {
  EXPECT_TRUE(findRevisits(driveThrough({Vec3(0, 0, 0), Vec3(400, 0, 0)}), kScale).empty());
}

TEST(FindRevisits, TurningBackIsOneOnlyOnceItIsLongAgo) {
  // 80 m out and back: what is passed on the way back was left 0 .. 160 m before.
  const auto revisits = findRevisits(driveThrough({Vec3(0, 0, 0), Vec3(80, 0, 0), Vec3(0, 0, 0)}), kScale);
  ASSERT_EQ(revisits.size(), 1u);
  // At 80 + b back one is at 80 - b and meets 80 - b - 10 at the earliest: 2 b + 10 > 100.
  EXPECT_NEAR(revisits[0].first, 126, 2);
}

TEST(FindRevisits, TwoCrossingsAreTwo) {
  // A long way out, then a meander that crosses it twice, 100 m apart.
  const auto revisits = findRevisits(driveThrough({Vec3(0, 0, 0), Vec3(300, 0, 0), Vec3(300, 60, 0), Vec3(200, 60, 0),
                                                   Vec3(200, -60, 0), Vec3(100, -60, 0), Vec3(100, 60, 0)}),
                                     kScale);
  ASSERT_EQ(revisits.size(), 2u);
  EXPECT_NEAR(revisits[0].last - revisits[0].first, 20, 2);
}

TEST(FindRevisits, AShortWayAndNoWayHaveNone) {
  EXPECT_TRUE(findRevisits({}, kScale).empty());
  EXPECT_TRUE(findRevisits(driveThrough({Vec3(0, 0, 0), Vec3(1, 0, 0)}), kScale).empty());
}

TEST(RevisitScale, IsSmallerIndoors) {
  EXPECT_EQ(revisitScale(1.5).left, 100);
  EXPECT_EQ(revisitScale(0.5).left, 15);
}

TEST(ScoreLoops, ATrueLoopClosesItsRevisit) {
  const auto pairs = roundTheBlock();
  const LoopScore s = scoreLoops(runsOf({loopBetween(pairs, 5, 305, 0.5, 2)}), pairs, kScale);
  EXPECT_EQ(s.asked, 1u);
  EXPECT_EQ(s.accepted, 1u);
  EXPECT_EQ(s.checked, 1u);
  EXPECT_EQ(s.wrong, 0u);
  EXPECT_NEAR(s.worst, 0.5, 1e-9);
  EXPECT_NEAR(s.worst_deg, 2, 1e-9);
  EXPECT_EQ(s.revisits, 1u);
  EXPECT_EQ(s.revisits_asked, 1u);
  EXPECT_EQ(s.revisits_closed, 1u);
}

TEST(ScoreLoops, FarOffOrTurnedIsFalseAndClosesNothing) {
  const auto pairs = roundTheBlock();
  for (const LoopRun& loop : {loopBetween(pairs, 5, 305, 1.1, 0), loopBetween(pairs, 5, 305, 0, 3.1)}) {
    const LoopScore s = scoreLoops(runsOf({loop}), pairs, kScale);
    EXPECT_EQ(s.wrong, 1u);
    EXPECT_EQ(s.revisits_asked, 1u);
    EXPECT_EQ(s.revisits_closed, 0u);
  }
}

TEST(ScoreLoops, AMotionThatIsNoNumberIsFalse) {
  const auto pairs = roundTheBlock();
  EXPECT_EQ(scoreLoops(runsOf({loopBetween(pairs, 5, 305, NAN, 0)}), pairs, kScale).wrong, 1u);
}

TEST(ScoreLoops, RefusedOnesOnlyCountAsAsked) {
  const auto pairs = roundTheBlock();
  LoopRun refused = loopBetween(pairs, 5, 305, 9, 0);
  refused.accepted = false;
  const LoopScore s = scoreLoops(runsOf({refused}), pairs, kScale);
  EXPECT_EQ(s.asked, 1u);
  EXPECT_EQ(s.accepted + s.checked + s.wrong, 0u);
  EXPECT_TRUE(std::isnan(s.worst));
  EXPECT_EQ(s.revisits_asked, 1u);
  EXPECT_EQ(s.revisits_closed, 0u);
}

TEST(ScoreLoops, LoopsElsewhereDoNotCloseIt) {
  const auto pairs = roundTheBlock();
  EXPECT_EQ(scoreLoops(runsOf({loopBetween(pairs, 5, 200)}), pairs, kScale).revisits_closed, 0u);
  EXPECT_EQ(scoreLoops(runsOf({loopBetween(pairs, 5, 255)}), pairs, kScale).revisits_closed, 0u);
}

TEST(ScoreLoops, APlaceIsSeenBeforeItIsReached) {
  const auto pairs = roundTheBlock();
  EXPECT_EQ(scoreLoops(runsOf({loopBetween(pairs, 5, 265)}), pairs, kScale).revisits_closed, 1u);
}

TEST(ScoreLoops, AShortRevisitMayBeClosedALittleLater) {
  const auto pairs = driveThrough({Vec3(0, 0, 0), Vec3(200, 0, 0), Vec3(200, 60, 0), Vec3(100, 60, 0),
                                   Vec3(100, -100, 0)});  // meets its way at 410 .. 430 m
  EXPECT_EQ(scoreLoops(runsOf({loopBetween(pairs, 100, 438)}), pairs, kScale).revisits_closed, 1u);
  EXPECT_EQ(scoreLoops(runsOf({loopBetween(pairs, 100, 445)}), pairs, kScale).revisits_closed, 0u);
}

TEST(ScoreLoops, KeyframesWithoutATruePoseAreNotChecked) {
  auto pairs = roundTheBlock();
  LoopRun loop = loopBetween(pairs, 5, 305, 9, 0);
  loop.now_us += 40000;
  const LoopScore s = scoreLoops(runsOf({loop}), pairs, kScale);
  EXPECT_EQ(s.accepted, 1u);
  EXPECT_EQ(s.checked, 0u);
  EXPECT_EQ(s.wrong, 0u);
  loop.now_us -= 36000;  // 4 ms off is the same frame
  EXPECT_EQ(scoreLoops(runsOf({loop}), pairs, kScale).wrong, 1u);
}

const char* const kStats = R"({"loops_accepted": 3, "loops_rejected": 4, "loops": [
{"before_us": 500000, "now_us": 900000, "accepted": true, "score": 5, "T_before_now": [0,-1,0,4, 1,0,0,5, 0,0,1,6], "reason": ""},
{"before_us": 1, "now_us": 2, "accepted": false, "score": null, "T_before_now": null, "reason": "too little in common"}]})";

TEST(ReadLoops, ReadsWhatARunWrites) {
  const auto runs = readLoops(nlohmann::json::parse(kStats));
  ASSERT_TRUE(runs) << runs.error;
  EXPECT_EQ(runs->accepted, 3u);
  EXPECT_EQ(runs->rejected, 4u);
  ASSERT_EQ(runs->list.size(), 2u);
  EXPECT_EQ(runs->list[0].now_us, 900000);
  EXPECT_EQ(runs->list[0].T_before_now.translation(), Vec3(4, 5, 6));
  EXPECT_EQ(runs->list[0].T_before_now.linear()(1, 0), 1.0);
  EXPECT_FALSE(runs->list[1].accepted);
}

TEST(ReadLoops, AnythingElseIsAnError) {
  for (
      const char* text :
      {"{}", R"({"loops": []})", R"({"loops_accepted": -1, "loops_rejected": 0, "loops": []})",
       R"({"loops_accepted": 1, "loops_rejected": 0, "loops": {}})",
       R"({"loops_accepted": 1, "loops_rejected": 0, "loops": [7]})",
       R"({"loops_accepted": 1, "loops_rejected": 0, "loops": [{"before_us": 1, "now_us": 2, "accepted": true}]})",
       R"({"loops_accepted": 1, "loops_rejected": 0, "loops": [{"before_us": 1, "now_us": "2", "accepted": false}]})"}) {
    EXPECT_FALSE(readLoops(nlohmann::json::parse(text))) << text;
  }
}

/// A truth of two poses, the map of nothing and a run's stats.json.
EvalOptions tinyRun(const Scratch& scratch, const std::string& stats) {
  writeText(scratch / "truth/gt_objects.json", "[]");
  writeText(scratch / "truth/poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n0 -1 0 4 1 0 0 5 0 0 1 6\n");
  writeText(scratch / "trajectory.tum", "0.5 0 0 0 0 0 0 1\n0.9 1 0 0 0 0 0 1\n");
  writeText(scratch / "g.json", R"({"format":"hgg-graph","version":1,"classes":{},"objects":[],"edges":[]})");
  writeText(scratch / "stats.json", stats);
  EvalOptions options;
  options.truth = scratch / "truth";
  options.graph = scratch / "g.json";
  options.trajectory = scratch / "trajectory.tum";
  options.stats = scratch / "stats.json";
  return options;
}

TEST(Evaluate, LoopsOfTheRunAreCheckedAgainstTheTruth) {
  const Scratch scratch;
  const auto evaluation = evaluate(tinyRun(scratch, kStats));
  ASSERT_TRUE(evaluation) << evaluation.error;
  const auto json = toJson(*evaluation)["loops"];
  EXPECT_EQ(json["asked"], 7);
  EXPECT_EQ(json["accepted"], 3);
  EXPECT_EQ(json["checked"], 1);
  EXPECT_EQ(json["false"], 0);
  EXPECT_NEAR(json["worst_m"].get<double>(), 0, 1e-9);
  EXPECT_EQ(json["revisits"], 0);
  EXPECT_NE(formatTable(*evaluation).find("loops: 7 asked, 3 accepted, 0 of 1 checked are false"), std::string::npos);
}

TEST(Evaluate, ARunThatTellsOfNoLoopsIsNotScored) {
  const Scratch scratch;
  const auto evaluation = evaluate(tinyRun(scratch, "{}"));
  ASSERT_TRUE(evaluation) << evaluation.error;
  EXPECT_TRUE(toJson(*evaluation)["loops"].is_null());
  EXPECT_FALSE(evaluate(tinyRun(scratch, R"({"loops": 1})")));
}

}  // namespace
}  // namespace hgg::loops_eval_test
