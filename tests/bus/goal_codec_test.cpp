#include <gtest/gtest.h>

#include <cmath>
#include <hgg/goal_query_t.hpp>
#include <hgg/goal_reply_t.hpp>

#include "bus/codec.h"
#include "generated_codec.h"

namespace hgg::goal_codec_test {
namespace {

hgg::goal_query_t someQuery() {
  hgg::goal_query_t q{};
  q.utime = 5;
  q.client = "nav";
  q.request_id = -7;
  q.text = "the bench next to the tree";
  q.has_start = 1;
  q.start[0] = 1, q.start[1] = 2, q.start[2] = 3, q.start[3] = 0.5;
  q.max_answers = 4;
  q.with_goal = 1;
  return q;
}

TEST(GoalQueryCodec, TakesWhatTheGeneratedTypeWrites) {
  const auto query = decodeGoalQuery(encodeGenerated(someQuery()));
  ASSERT_TRUE(query) << query.error;
  EXPECT_EQ(query->client, "nav");
  EXPECT_EQ(query->request_id, -7);
  EXPECT_EQ(query->text, "the bench next to the tree");
  EXPECT_EQ(query->start, (std::array<double, 4>{1, 2, 3, 0.5}));
  EXPECT_EQ(query->max_answers, 4);
  EXPECT_TRUE(query->with_goal);
  auto from_robot = someQuery();
  from_robot.has_start = 0;
  EXPECT_FALSE(decodeGoalQuery(encodeGenerated(from_robot))->start.has_value());
}

TEST(GoalQueryCodec, TakesTextsThatWillBeRefusedSoThatTheyCanBeAnswered) {
  for (const std::string& text : {std::string(10'000, 'x'), std::string("\xff\xfe"), std::string()}) {
    auto odd = someQuery();
    odd.text = text;
    odd.start[2] = std::nan("");
    odd.max_answers = -1;
    const auto query = decodeGoalQuery(encodeGenerated(odd));
    ASSERT_TRUE(query) << query.error;
    EXPECT_EQ(query->text, text);
  }
}

TEST(GoalQueryCodec, RefusesWhatIsNoQuery) {
  Message bytes = encodeGenerated(someQuery());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_NE(decodeGoalQuery(Bytes(bytes).first(size)).error, "") << size;
  }
  bytes.push_back(0);
  EXPECT_EQ(decodeGoalQuery(bytes).error, "surplus bytes");
  EXPECT_EQ(decodeGoalQuery(encodePose(1, Pose::Identity())).error, "foreign fingerprint");
  auto endless = someQuery();
  endless.text = std::string(70'000, 'x');
  EXPECT_NE(decodeGoalQuery(encodeGenerated(endless)).error, "");
}

TEST(GoalReplyCodec, IsWhatTheGeneratedTypeReads) {
  GoalReply reply;
  reply.utime_us = 1, reply.client = "nav", reply.request_id = 2, reply.revision = 3;
  reply.status = GoalStatus::kAmbiguous, reply.text = "two fit", reply.parse = "{}";
  reply.answers.push_back({42, "bench", 0.6, {1, 2, 3}, Vec3(4, 5, 6).asDiagonal(), "a bench"});
  reply.goal_kind = GoalKind::kNearest, reply.goal = {7, 8, 9}, reply.goal_yaw = 0.5, reply.goal_reason = "a wall";
  reply.path_length = 10, reply.path_confidence = 0.25;
  reply.path = {{0, 1, 2}, {3, 4, 5}};
  const auto read = decodeGenerated<hgg::goal_reply_t>(encodeGoalReply(reply));
  EXPECT_EQ(read.utime, 1);
  EXPECT_EQ(read.client, "nav");
  EXPECT_EQ(read.request_id, 2);
  EXPECT_EQ(read.revision, 3);
  EXPECT_EQ(read.status, hgg::goal_reply_t::AMBIGUOUS);
  EXPECT_EQ(read.text, "two fit");
  EXPECT_EQ(read.parse, "{}");
  ASSERT_EQ(read.num_answers, 1);
  EXPECT_EQ(read.answers[0].kind, hgg::goal_answer_t::OBJECT);
  EXPECT_EQ(read.answers[0].id, 42);
  EXPECT_EQ(read.answers[0].name, "bench");
  EXPECT_EQ(read.answers[0].probability, 0.6);
  EXPECT_EQ(read.answers[0].mean[2], 3);
  EXPECT_EQ(read.answers[0].cov[4], 5);
  EXPECT_EQ(read.answers[0].reason, "a bench");
  EXPECT_EQ(read.goal_kind, hgg::goal_reply_t::NEAREST);
  EXPECT_EQ(read.goal[1], 8);
  EXPECT_EQ(read.goal[3], 0.5);
  EXPECT_EQ(read.goal_reason, "a wall");
  EXPECT_EQ(read.path_length, 10);
  EXPECT_EQ(read.path_confidence, 0.25);
  EXPECT_EQ(read.path_x, (std::vector<double>{0, 3}));
  EXPECT_EQ(read.path_y, (std::vector<double>{1, 4}));
  EXPECT_EQ(read.path_z, (std::vector<double>{2, 5}));
}

TEST(GoalReplyCodec, SendsNoMoreThanItPromises) {
  GoalReply reply;
  reply.answers.resize(150);
  reply.path.resize(20'000, Vec3::Zero());
  const auto read = decodeGenerated<hgg::goal_reply_t>(encodeGoalReply(reply));
  EXPECT_EQ(read.num_answers, 100);
  EXPECT_EQ(read.num_waypoints, 10'000);
}

}  // namespace
}  // namespace hgg::goal_codec_test
