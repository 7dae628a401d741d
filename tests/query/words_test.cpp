#include "query/words.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace hgg::words_test {
namespace {

using Words = std::vector<std::string>;

TEST(Words, AreLowerCaseWithBreaks) {
  EXPECT_EQ(wordsOf("Go to the Bench, next-to the TREE."),
            (Words{"go", "to", "the", "bench", ",", "next", "to", "the", "tree", "."}));
  EXPECT_EQ(wordsOf("it's the bed's side"), (Words{"it", "is", "the", "bed", "side"}));
  EXPECT_TRUE(wordsOf(" \t\n").empty());
}

TEST(Words, SingularsFollowSpelling) {
  for (const auto& [plural, singular] : std::vector<std::pair<std::string, std::string>>{{"chairs", "chair"},
                                                                                         {"boxes", "box"},
                                                                                         {"benches", "bench"},
                                                                                         {"shelves", "shelf"},
                                                                                         {"bodies", "body"},
                                                                                         {"glass", "glass"},
                                                                                         {"people", "person"},
                                                                                         {"bus", "bus"},
                                                                                         {"houses", "house"},
                                                                                         {"shoes", "shoe"}}) {
    EXPECT_EQ(singularOf(plural), singular);
  }
}

/// The recursion that defines the distance.
int bruteDistance(const std::string& a, const std::string& b) {
  if (a.empty() || b.empty()) {
    return static_cast<int>(a.size() + b.size());
  }
  const std::string a1 = a.substr(1), b1 = b.substr(1);
  int least =
      std::min({bruteDistance(a1, b) + 1, bruteDistance(a, b1) + 1, bruteDistance(a1, b1) + (a[0] == b[0] ? 0 : 1)});
  if (a.size() > 1 && b.size() > 1 && a[0] == b[1] && a[1] == b[0]) {
    least = std::min(least, bruteDistance(a.substr(2), b.substr(2)) + 1);
  }
  return least;
}

TEST(Words, SpellingDistanceIsThatOfTheRecursion) {
  const std::vector<std::string> words{"chair", "cahir", "hair", "char", "table", "tabel", "a", "", "chairs"};
  for (const std::string& a : words) {
    for (const std::string& b : words) {
      EXPECT_EQ(spellingDistance(a, b, 10), bruteDistance(a, b)) << a << " " << b;
      EXPECT_EQ(spellingDistance(a, b, 1), std::min(bruteDistance(a, b), 2)) << a << " " << b;
    }
  }
}

TEST(Words, Utf8IsTold) {
  EXPECT_TRUE(isUtf8("caf\xc3\xa9 \xe2\x80\x99 \xf0\x9f\x98\x80"));
  EXPECT_FALSE(isUtf8("\xff\xfe"));
  EXPECT_FALSE(isUtf8("\xc3"));
  EXPECT_FALSE(isUtf8("\xe2\x28\xa1"));
}

}  // namespace
}  // namespace hgg::words_test
