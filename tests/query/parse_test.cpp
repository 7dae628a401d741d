#include "query/parse.h"

#include <gtest/gtest.h>

#include "query/answer.h"

namespace hgg::parse_test {
namespace {

const std::map<ClassId, std::string> kNames{
    {1, "chair"},   {2, "table"},     {3, "bed"},   {4, "lamp"},   {5, "door"},  {6, "window"}, {7, "pillow"},
    {8, "monitor"}, {9, "trash can"}, {10, "tree"}, {11, "bench"}, {12, "desk"}, {13, "wall"}};

/// The readings of a text, as `hggmap query` shows them.
std::vector<std::string> readings(const std::string& text) {
  static const Lexicon kLexicon(kNames, {});
  std::vector<std::string> all;
  for (const Request& r : parseText(text, kLexicon).readings) {
    all.push_back(describe(r));
  }
  return all;
}

std::string read(const std::string& text) {
  const std::vector<std::string> all = readings(text);
  return all.empty() ? "" : all.front();
}

TEST(Parse, SkipsWhatWrapsARequest) {
  for (const std::string text : {"go to the bench next to the tree", "Find the bench that is next to the tree.",
                                 "I need the bench beside the tree", "Please choose the bench near the tree",
                                 "this is the bench that is close to a tree"}) {
    EXPECT_EQ(read(text), "bench (near tree)") << text;
  }
}

TEST(Parse, ReadsRelations) {
  EXPECT_EQ(read("the chair closest to the door"), "chair (closest to door)");
  EXPECT_EQ(read("the closest chair to the door"), "chair (closest to door)");
  EXPECT_EQ(read("the lamp farthest from the bed"), "lamp (far from bed)");
  EXPECT_EQ(read("the table between the bed and the window"), "table (between bed window)");
  EXPECT_EQ(read("the pillow on top of the bed"), "pillow (on bed)");
  EXPECT_EQ(read("the trash can under the table"), "trash can (below table)");
  EXPECT_EQ(read("the lamp to the left of the bed"), "lamp (left of bed)");
  EXPECT_EQ(read("the chair in front of the desk"), "chair (in front of desk)");
  EXPECT_EQ(read("the table with a lamp on it"), "table (with on it lamp)");
  EXPECT_EQ(read("the desk with a monitor on top"), "desk (with on it monitor)");
  EXPECT_EQ(read("the table with no chair"), "table (not with chair)");
}

TEST(Parse, ReadsWhatTellsAThingFromItsLike) {
  EXPECT_EQ(read("the largest table"), "table (largest)");
  EXPECT_EQ(read("the smaller of the two lamps"), "lamps (smaller)");
  EXPECT_EQ(read("the lamp on the left"), "lamp (left)");
  EXPECT_EQ(read("the leftmost window"), "window (left)");
  EXPECT_EQ(read("the second chair from the right"), "chair (right #2)");
  EXPECT_EQ(read("the red chair in the corner"), "chair (red; corner)");
  EXPECT_EQ(read("the chair that is not black"), "chair (not black)");
}

TEST(Parse, ReadsChainsBothWays) {
  const std::vector<std::string> all = readings("the lamp on the table near the window");
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0], "lamp (on table (near window))");
  EXPECT_EQ(all[1], "lamp (on table; near window)");
  EXPECT_EQ(read("the chair next to the bed and close to the door"), "chair (near bed; near door)");
}

TEST(Parse, ReadsViews) {
  EXPECT_EQ(read("facing the window, the chair on the left"), "chair (left), facing window");
  EXPECT_EQ(read("When you are looking at the beds, it is the one on the right"), "beds (right), facing beds");
  EXPECT_EQ(read("if you enter the room, the first chair on your right"), "chair (right #1), entering the room");
  EXPECT_EQ(read("facing the desk, choose the lamp that is on the left of it"), "lamp (left of desk), facing desk");
}

TEST(Parse, ReadsSeveralSentences) {
  EXPECT_EQ(read("There are three chairs. It is the one next to the door."), "chairs (near door)");
  EXPECT_EQ(read("The chair is next to the bed. It is not the one by the door."), "chair (near bed; not near door)");
  EXPECT_EQ(read("next to the bed, the lamp"), "lamp (near bed)");
}

TEST(Parse, ReadsWhereTheRobotIs) {
  EXPECT_EQ(read("the chair closest to me"), "chair (closest to me)");
  EXPECT_EQ(read("the closest chair"), "chair (closest to you)");
}

TEST(Parse, ForgivesSpelling) {
  EXPECT_EQ(read("the pilow on the bed"), "pilow (on bed)");
  EXPECT_EQ(read("teh trashcan nxet to the windwo"), "trashcan (near windwo)");
}

TEST(Parse, TakesTheWallForAThingWhereNothingIsSaidToBeOnIt) {
  EXPECT_EQ(read("the wall"), "wall");
  EXPECT_EQ(read("go to the wall"), "wall");
  EXPECT_EQ(read("the wall on the left"), "wall (left)");
  EXPECT_EQ(read("the wall next to the door"), "wall (near door)");
  EXPECT_EQ(read("the lamp on the wall"), "lamp (wall)");
  EXPECT_EQ(read("the desk against the wall"), "desk (wall)");
}

TEST(Parse, DeniesWhatAThingIsWithout) {
  EXPECT_EQ(read("the desk without a monitor"), "desk (not with monitor)");
  EXPECT_EQ(read("a table without chairs"), "table (not with chairs)");
  EXPECT_EQ(read("the desk with no monitor"), "desk (not with monitor)");
  for (const std::string& reading : readings("the chair without a desk next to it")) {
    EXPECT_NE(reading.find("not near desk"), std::string::npos) << reading;
    EXPECT_EQ(reading.find("; near desk"), std::string::npos) << reading;
  }
}

TEST(Parse, SeeksTheOtherThingWhereOneIsRejected) {
  EXPECT_EQ(read("go to the door, not the window"), "door");
  EXPECT_EQ(read("not the chair but the table"), "table");
  EXPECT_EQ(read("not the red chair near the bed but the table"), "table");
  EXPECT_EQ(read("go to the door, not the window next to the bed"), "door");
  EXPECT_EQ(read("not the chair by the door, the one in the corner"), "chair (corner)");
  EXPECT_EQ(read("not the chair"), "");
}

TEST(Parse, KeepsNegationsOfTheSameKindOfThing) {
  EXPECT_EQ(read("the chair near the bed, not the chair near the door"), "chair (near bed; not near door)");
  EXPECT_EQ(read("the chair that is not red"), "chair (not red)");
}

TEST(Parse, CountsPastTheFifth) {
  EXPECT_EQ(read("the sixth chair from the left"), "chair (left #6)");
  EXPECT_EQ(read("the twelfth chair from the left"), "chair (left #12)");
  EXPECT_EQ(read("the 1st chair from the left"), "chair (left #1)");
  EXPECT_EQ(read("the 10th chair from the left"), "chair (left #10)");
  EXPECT_EQ(read("the 21st chair from the left"), "chair (left #21)");
}

TEST(Parse, ReadsAnyNumberOfRelations) {
  std::string text;
  for (int k = 0; k < 120; ++k) {
    text += "chair near desk ";
  }
  EXPECT_EQ(readings(text).size(), 4U);  // of the choices past the bits of a word none is open
}

TEST(Parse, DoesNotUnderstandWhatMeansAnyThing) {
  for (const std::string text : {"1", "7", "the object", "the thing", "go to the object", "the one"}) {
    EXPECT_EQ(read(text), "") << text;
  }
  EXPECT_EQ(read("the object next to the door"), "object (near door)");
}

TEST(Parse, SaysWhyItUnderstandsNothing) {
  const Lexicon lexicon(kNames, {});
  for (const std::string& text :
       {std::string{}, std::string(" ,.! "), std::string("\xff\xfe"), std::string(10'000, 'x'),
        std::string("int main() { return x->y; }"), std::string("qwrt zxcvb plgh"),
        std::string("über dem flüssigen Gänseblümchen steht nichts")}) {
    const Parse parse = parseText(text, lexicon);
    EXPECT_TRUE(parse.readings.empty()) << text;
    EXPECT_FALSE(parse.reason.empty()) << text;
  }
}

}  // namespace
}  // namespace hgg::parse_test
