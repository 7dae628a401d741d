#include "query/wordnet.h"

#include <gtest/gtest.h>

namespace hgg::wordnet_test {
namespace {

// thing <- seat <- chair <- throne; seat <- sofa
const Wordnet kSmall("chair 2\nseat 1\nsofa 4\nthing 0\nthrone 3\n\n0\n1 0\n2 1\n3 2\n4 1\n");

TEST(Wordnet, CountsStepsUp) {
  EXPECT_EQ(kSmall.stepsUp(3, 1), 2);
  EXPECT_EQ(kSmall.stepsUp(3, 3), 0);
  EXPECT_FALSE(kSmall.stepsUp(4, 2));
  EXPECT_EQ(kSmall.depthOf(3), 3);
  EXPECT_EQ(kSmall.sensesOf("throne"), std::vector<Wordnet::Synset>{3});
  EXPECT_FALSE(kSmall.knows("banana"));
}

TEST(Wordnet, MayBeEmpty) {
  const Wordnet none("");
  EXPECT_TRUE(none.empty());
  EXPECT_TRUE(none.sensesOf("chair").empty());
}

TEST(Wordnet, BakedInKnowsWhatIsAKindOfWhat) {
  const Wordnet& wordnet = Wordnet::builtin();
  if (wordnet.empty()) {
    GTEST_SKIP() << "built without wordnet-base";
  }
  EXPECT_TRUE(wordnet.stepsUp(wordnet.sensesOf("spaniel").front(), wordnet.sensesOf("dog").front()));
  EXPECT_FALSE(wordnet.stepsUp(wordnet.sensesOf("dog").front(), wordnet.sensesOf("spaniel").front()));
}

}  // namespace
}  // namespace hgg::wordnet_test
