#include "publish/goal_publisher.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "small_world.h"

namespace hgg::goal_publisher_test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A street that was driven along, and what is answered. The thread writes replies; they are read after settle().
class GoalPublisherTest : public ::testing::Test {
 protected:
  GoalPublisherTest() : mapper_(Config{}, ClassTable::builtin()), goals_(mapper_, {sink()}) {}

  Sink sink() {
    Sink sink;
    sink.goal = [this](const GoalReply& reply) { replies_.push_back(reply); };
    return sink;
  }

  void drive(int frames) {
    for (const int end = next_ + frames; next_ < end; ++next_) {
      const auto odometry = SmallWorld::odometry(next_);
      report_ = mapper_.step({odometry.utime_us, odometry.T_odom_body, SmallWorld::points(next_)});
      goals_.follow(report_);
    }
  }

  GoalQuery queryOf(const std::string& text) {
    GoalQuery query;
    query.client = "test", query.request_id = ++request_;
    query.text = text, query.with_goal = true;
    return query;
  }

  GoalReply answerTo(const GoalQuery& query) {
    const std::size_t before = replies_.size();
    goals_.ask(query);
    goals_.settle();
    EXPECT_EQ(replies_.size(), before + 1) << "each query is answered once";
    EXPECT_EQ(replies_.back().client, query.client);
    EXPECT_EQ(replies_.back().request_id, query.request_id);
    return replies_.back();
  }

  /// The car of the map whose middle is nearest to a place.
  const MapNode& carNearestTo(double x, double y) const {
    const MapNode* best = nullptr;
    const auto distance = [&](const MapNode& node) { return (node.belief.mean - Vec3(x, y, 0)).head<2>().norm(); };
    for (const auto& [id, node] : mapper_.map().nodes()) {
      if (isConfirmed(node) && node.label == 10 && (best == nullptr || distance(node) < distance(*best))) {
        best = &node;
      }
    }
    EXPECT_NE(best, nullptr);
    return *best;
  }

  std::vector<GoalReply> replies_;
  Mapper mapper_;
  StepReport report_;
  int next_ = 0;
  std::int64_t request_ = 0;
  GoalPublisher goals_;  // last: its thread calls the sink
};

TEST_F(GoalPublisherTest, ACarIsFoundWithAGoalNearItAndAWayThatBeginsAtTheRobot) {
  drive(20);
  const GoalReply reply = answerTo(queryOf("go to the car closest to me"));
  ASSERT_EQ(reply.status, GoalStatus::kOk) << reply.text;
  EXPECT_EQ(reply.utime_us, SmallWorld::timeOf(19));
  EXPECT_EQ(reply.revision, mapper_.map().revision());
  ASSERT_FALSE(reply.answers.empty());
  EXPECT_EQ(reply.answers[0].name, "car");
  const MapNode& car = carNearestTo(19, 0);
  EXPECT_EQ(reply.answers[0].id, car.id);
  EXPECT_EQ(reply.answers[0].cov, car.belief.cov);
  EXPECT_NE(reply.parse.find("car"), std::string::npos);
  ASSERT_EQ(reply.goal_kind, GoalKind::kNearest) << "the road ends 1.1 m beside the cars";
  EXPECT_NE(reply.goal_reason.find("1.0 m"), std::string::npos) << reply.goal_reason;
  ASSERT_FALSE(reply.path.empty());
  EXPECT_LT((reply.path.front() - report_.T_map_body.translation()).head<2>().norm(), 0.3);
  EXPECT_LT((reply.path.back() - reply.goal).norm(), 0.3);
  EXPECT_NEAR(reply.goal.z(), -1.5, 0.1);
  EXPECT_GT(reply.path_length, 0);
  EXPECT_GT(reply.path_confidence, 0);
  const Vec3 towards = reply.answers[0].mean - reply.goal;
  EXPECT_LT(std::abs(std::remainder(std::atan2(towards.y(), towards.x()) - reply.goal_yaw, 2 * M_PI)), 0.5);
}

TEST_F(GoalPublisherTest, AStartThatIsGivenCountsInsteadOfTheRobot) {
  drive(60);
  const GoalReply here = answerTo(queryOf("the car closest to me"));
  GoalQuery query = queryOf("the car closest to me");
  query.start = {{20, 0, kNaN, 0}};
  const GoalReply there = answerTo(query);
  EXPECT_EQ(there.answers.at(0).id, carNearestTo(20, 0).id);
  EXPECT_NE(there.answers.at(0).id, here.answers.at(0).id);
  EXPECT_EQ(there.path.at(0).x(), 20);
  query = queryOf("the car closest to me");
  query.start = {{kNaN, 0, 0, 0}};
  const GoalReply reply = answerTo(query);
  EXPECT_EQ(reply.status, GoalStatus::kNotUnderstood);
  EXPECT_NE(reply.text.find("finite"), std::string::npos) << reply.text;
}

TEST_F(GoalPublisherTest, BeforeThereIsAMapOneIsToldToAskAgainAndThenIsAnswered) {
  const GoalQuery query = queryOf("the car");
  const GoalReply early = answerTo(query);
  EXPECT_EQ(early.status, GoalStatus::kFailed);
  EXPECT_NE(early.text.find("no map yet"), std::string::npos);
  drive(12);
  EXPECT_NE(answerTo(query).status, GoalStatus::kFailed) << "a failure is not remembered";
}

TEST_F(GoalPublisherTest, AskedAgainIsAnsweredFromMemoryAndAnotherTextUnderTheSameNumberIsNot) {
  drive(6);
  GoalQuery query = queryOf("the car closest to me");
  const GoalReply first = answerTo(query);
  drive(8);
  EXPECT_EQ(answerTo(query).revision, first.revision);
  query.text = "the pole closest to me";
  const GoalReply other = answerTo(query);
  EXPECT_NE(other.revision, first.revision);
  EXPECT_EQ(other.answers.at(0).name, "pole");
}

TEST_F(GoalPublisherTest, WhatIsNotThereAndWhatIsNoRequestIsSaid) {
  drive(8);
  EXPECT_EQ(answerTo(queryOf("the banana")).status, GoalStatus::kNotFound);
  for (const std::string& text : {std::string(), std::string(10'000, 'a'), std::string("\xff\xfe the car"),
                                  std::string("%s%s%n"), std::string("{{{")}) {
    const GoalReply reply = answerTo(queryOf(text));
    EXPECT_EQ(reply.status, GoalStatus::kNotUnderstood) << text.substr(0, 40);
    EXPECT_FALSE(reply.text.empty());
    EXPECT_EQ(reply.goal_kind, GoalKind::kNone);
  }
}

TEST_F(GoalPublisherTest, AsManyAnswersComeAsAreAskedForAndNoGoalUnlessWanted) {
  drive(30);
  GoalQuery query = queryOf("a car");
  query.max_answers = 2, query.with_goal = false;
  const GoalReply reply = answerTo(query);
  EXPECT_EQ(reply.answers.size(), 2U);
  EXPECT_EQ(reply.goal_kind, GoalKind::kNone);
  EXPECT_TRUE(reply.path.empty());
  query = queryOf("a car");
  query.max_answers = -7;
  EXPECT_GE(answerTo(query).answers.size(), 3U) << "as many as are usual";
}

TEST_F(GoalPublisherTest, ALostRobotHasNoWay) {
  drive(12);
  report_.tracking = Tracking::kLost;
  goals_.follow(report_);
  const GoalQuery query = queryOf("a car");
  const GoalReply reply = answerTo(query);
  EXPECT_FALSE(reply.answers.empty());
  EXPECT_EQ(reply.goal_kind, GoalKind::kNone);
  EXPECT_NE(reply.goal_reason.find("does not know where it is"), std::string::npos);
  report_.tracking = Tracking::kHeld;
  goals_.follow(report_);
  EXPECT_NE(answerTo(query).goal_kind, GoalKind::kNone) << "asked again, now that it knows";
}

}  // namespace
}  // namespace hgg::goal_publisher_test
