#include <gtest/gtest.h>

#include <cmath>

#include "eval/retrieval.h"
#include "tools/scratch.h"

namespace hgg::retrieval_eval_test {
namespace {

const std::vector<TruthQuery> kQueries{
    {"the bench", 1, "bench"}, {"the lamp", 2, "lamp"}, {"the bin", 3, "bin"}, {"the plant", 4, "plant"}};
/// Truth 1 is node 11, 2 is 12, 3 is 13; 4 was missed.
const std::vector<ObjectMatch> kMatches{{11, 1, 0.1}, {12, 2, 0.1}, {13, 3, 0.1}};

TEST(ScoreRetrieval, CountsTheRankOfTheTargetsNode) {
  const std::vector<QueryAnswer> answers{
      {"the bench", {11, 50}}, {"the lamp", {50, 51, 12}}, {"the bin", {50, 13}}, {"the plant", {50, 51, 52}}};
  const auto score = scoreRetrieval(kQueries, answers, kMatches);
  ASSERT_TRUE(score) << score.error;
  EXPECT_EQ(score->queries, 4u);
  EXPECT_EQ(score->mapped, 3u);
  EXPECT_DOUBLE_EQ(score->recallAt(1), 0.25);
  EXPECT_DOUBLE_EQ(score->recallAt(2), 0.5);
  EXPECT_DOUBLE_EQ(score->recallAt(3), 0.75);
}

TEST(ScoreRetrieval, RankFourAndNoAnswerAreMisses) {
  const std::vector<QueryAnswer> answers{
      {"the bench", {50, 51, 52, 11}}, {"the lamp", {}}, {"the bin", {13}}, {"the plant", {}}};
  EXPECT_DOUBLE_EQ(scoreRetrieval(kQueries, answers, kMatches)->recallAt(3), 0.25);
}

TEST(ScoreRetrieval, AnotherNodeOnTheSameObjectIsNotTheInstance) {
  const std::vector<TruthQuery> query{kQueries[0]};
  EXPECT_EQ(scoreRetrieval(query, std::vector<QueryAnswer>{{"the bench", {99}}}, kMatches)->recallAt(3), 0.0);
}

TEST(ScoreRetrieval, AnswersToOtherQueriesAreAnError) {
  const std::vector<QueryAnswer> fewer{{"the bench", {11}}};
  const std::vector<QueryAnswer> swapped{{"the lamp", {}}, {"the bench", {}}, {"the bin", {}}, {"the plant", {}}};
  for (const auto& answers : {fewer, swapped}) {
    const auto score = scoreRetrieval(kQueries, answers, kMatches);
    ASSERT_FALSE(score);
    EXPECT_NE(score.error.find("queries.jsonl"), std::string::npos);
  }
}

TEST(ScoreRetrieval, NoQueriesHaveNoScore) {
  const auto score = scoreRetrieval({}, {}, kMatches);
  ASSERT_TRUE(score);
  EXPECT_TRUE(std::isnan(score->recallAt(1)));
}

TEST(ReadAnswers, ReadsTheBatchOutput) {
  const Scratch scratch;
  writeText(scratch / "a.jsonl",
            R"({"text":"the bench","status":"ok","answers":[{"id":11,"name":"bench","probability":0.9},{"id":7}]})"
            "\n"
            R"({"text":"the moon","status":"not_found","answers":[]})"
            "\n");
  const auto answers = readAnswers(scratch / "a.jsonl");
  ASSERT_TRUE(answers) << answers.error;
  ASSERT_EQ(answers->size(), 2u);
  EXPECT_EQ((*answers)[0].nodes, (std::vector<NodeId>{11, 7}));
  EXPECT_TRUE((*answers)[1].nodes.empty());
}

TEST(ReadAnswers, BrokenLinesAreNamed) {
  const Scratch scratch;
  for (const char* second :
       {"{", "[]", "{}", R"({"text":"x","answers":[{"name":"y"}]})", R"({"text":7,"answers":[]})"}) {
    writeText(scratch / "a.jsonl", std::string(R"({"text":"x","answers":[]})") + "\n" + second + "\n");
    const auto answers = readAnswers(scratch / "a.jsonl");
    ASSERT_FALSE(answers) << second;
    EXPECT_NE(answers.error.find("a.jsonl line 2"), std::string::npos) << answers.error;
  }
  EXPECT_FALSE(readAnswers(scratch / "none.jsonl"));
}

}  // namespace
}  // namespace hgg::retrieval_eval_test
