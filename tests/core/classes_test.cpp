#include "core/classes.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tools/scratch.h"

namespace hgg::classes_test {
namespace {

std::string entry(const std::string& lines) { return "[[class]]\n" + lines + "\n"; }

std::string carWith(const std::string& line) {
  return entry("id = 10\nname = \"car\"\nkind = \"thing\"\nradius = 0.5\nmin_points = 20\n" + line);
}

/// The complaints about a table, one a line; fails the test when there are none.
std::string complaints(const std::string& toml) {
  const Result<ClassTable> table = ClassTable::parse(toml, "c.toml");
  EXPECT_FALSE(table) << toml;
  return table.error;
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(ClassTable, AnswersEveryLabelOfAClassWithThatClass) {
  const auto table = ClassTable::parse(carWith("also = [252, 65534]\ndynamic = true"), "c.toml");
  ASSERT_TRUE(table) << table.error;
  for (const ClassId label : std::initializer_list<ClassId>{10, 252, 65534}) {
    ASSERT_NE(table->find(label), nullptr) << label;
    EXPECT_EQ(table->find(label)->id, 10);
    EXPECT_EQ(table->name(label), "car");
  }
  const ClassInfo& car = *table->find(252);
  EXPECT_EQ(car.kind, ClassKind::kThing);
  EXPECT_TRUE(car.dynamic);
  EXPECT_EQ(car.cluster_radius, 0.5);
  EXPECT_EQ(car.min_points, 20);
}

TEST(ClassTable, AnswersALabelOutsideTheTableWithNothing) {
  const auto table = ClassTable::parse(carWith(""), "c.toml");
  ASSERT_TRUE(table) << table.error;
  EXPECT_EQ(table->find(11), nullptr);
  EXPECT_EQ(table->find(0), nullptr);
  EXPECT_EQ(table->name(11), "class 11");
}

TEST(ClassTable, KeepsTheOrderOfTheFile) {
  const auto table = ClassTable::parse(entry("id = 9\nname = \"b\"\nkind = \"stuff\"\nmin_points = 5") +
                                           entry("id = 3\nname = \"a\"\nkind = \"ignore\""),
                                       "c.toml");
  ASSERT_TRUE(table) << table.error;
  ASSERT_EQ(table->classes().size(), 2U);
  EXPECT_EQ(table->classes()[0].name, "b");
  EXPECT_EQ(table->classes()[1].name, "a");
  EXPECT_EQ(table->classes()[1].kind, ClassKind::kIgnore);
}

TEST(ClassTable, RejectsALabelThatBelongsToTwoClasses) {
  const std::string other = entry("id = 11\nname = \"van\"\nkind = \"ignore\"\nalso = [10]");
  const std::string error = complaints(carWith("") + other);
  EXPECT_TRUE(has(error, "label 10 already belongs to 'car'")) << error;
  EXPECT_TRUE(has(error, "c.toml:")) << error;
}

TEST(ClassTable, RejectsALabelTwiceInOneClass) {
  EXPECT_TRUE(has(complaints(carWith("also = [10]")), "label 10 already belongs to 'car'"));
  EXPECT_TRUE(has(complaints(carWith("also = [7, 7]")), "label 7 already belongs to 'car'"));
}

TEST(ClassTable, RejectsLabelsThatDoNotFitTheWire) {
  EXPECT_TRUE(has(complaints(carWith("also = [-1]")), "label -1 is outside 0 .. 65534"));
  EXPECT_TRUE(has(complaints(carWith("also = [65535]")), "label 65535 is outside 0 .. 65534"));
  EXPECT_TRUE(has(complaints(entry("id = 70000\nname = \"x\"\nkind = \"ignore\"")), "label 70000 is outside"));
}

TEST(ClassTable, ListsEveryComplaintAtOnceWithItsLine) {
  const std::string error = complaints(
      "colour = 1\n"                                                                                          // 1
      "[[class]]\nid = \"ten\"\nname = 3\nkind = \"blob\"\n"                                                  // 2
      "[[class]]\nid = 11\nname = \"van\"\nkind = \"thing\"\nradius = 99\nmin_points = 0\nshape = \"box\"\n"  // 6
      "[[class]]\nid = 12\nkind = \"stuff\"\nalso = [1, \"x\"]\n");                                           // 13
  for (const char* expected :
       {"unknown key 'colour'", "c.toml:2: [[class]]: 'id' has the wrong type",
        "c.toml:2: [[class]]: 'name' has the wrong type",
        "c.toml:2: [[class]]: kind 'blob' is none of thing, stuff, ignore", "c.toml:6: [[class]]: radius must be",
        "c.toml:6: [[class]]: min_points must be", "c.toml:6: [[class]]: unknown key 'shape'",
        "c.toml:13: [[class]]: key 'name' is missing", "c.toml:13: [[class]]: key 'min_points' is missing",
        "c.toml:13: [[class]]: 'also' must be an array of label ids"}) {
    EXPECT_TRUE(has(error, expected)) << "missing: " << expected << "\nin\n" << error;
  }
}

TEST(ClassTable, RejectsValuesOfTheWrongKind) {
  EXPECT_TRUE(has(complaints(entry("id = 1\nname = \"x\"\nkind = \"thing\"\nradius = nan\nmin_points = 5")), "radius"));
  EXPECT_TRUE(
      has(complaints(entry("id = 1\nname = \"x\"\nkind = \"thing\"\nradius = true\nmin_points = 5")), "radius"));
  EXPECT_TRUE(has(complaints(entry("id = 1\nname = \"x\"\nkind = \"stuff\"\nmin_points = true")), "min_points"));
  EXPECT_TRUE(has(complaints(entry("id = 1\nname = \"x\"\nkind = \"stuff\"\nmin_points = 2.5")), "min_points"));
  EXPECT_TRUE(has(complaints(entry("id = true\nname = \"x\"\nkind = \"ignore\"")), "id"));
  EXPECT_TRUE(has(complaints(entry("id = 1\nname = \"x\"\nkind = \"ignore\"\ndynamic = 1")), "dynamic"));
  EXPECT_TRUE(has(complaints(entry("id = 1\nname = \"x\"\nkind = 7")), "kind"));
}

TEST(ClassTable, RejectsNamesThatNoFormatCarries) {
  EXPECT_TRUE(has(complaints(entry("id = 1\nname = \"\"\nkind = \"ignore\"")), "name"));
  EXPECT_TRUE(has(complaints(entry("id = 1\nname = \"" + std::string(70000, 'x') + "\"\nkind = \"ignore\"")), "name"));
}

TEST(ClassTable, NeedsEntries) {
  EXPECT_TRUE(has(complaints(""), "no [[class]] entries"));
  EXPECT_TRUE(has(complaints("class = 3"), "[[class]]"));
  EXPECT_TRUE(has(complaints("class = [1, 2]"), "array of tables"));
  EXPECT_TRUE(has(complaints("[class]\nid = 1"), "[[class]]"));
}

TEST(ClassTable, NamesTheLineOfWrongSyntax) {
  EXPECT_TRUE(has(complaints("[[class]]\nid = 1\nname = \n"), "c.toml:3:"));
  EXPECT_TRUE(has(complaints("[[class]]\nid = 1\nid = 2\n"), "c.toml:3:"));
  EXPECT_TRUE(has(complaints("\xff\xfe"), "c.toml:1:"));
}

TEST(ClassTable, SaysWhichFileCannotBeRead) {
  const Scratch scratch;
  for (const std::string& path : {(scratch / "none.toml").string(), (scratch / "").string()}) {
    const auto table = ClassTable::load(path);
    EXPECT_FALSE(table);
    EXPECT_TRUE(has(table.error, path)) << table.error;
    EXPECT_FALSE(has(table.error, "config")) << table.error;  // not every table is named by one
    EXPECT_EQ(std::count(table.error.begin(), table.error.end(), '\n'), 0);
  }
}

TEST(ClassTable, SimilarClassesAreRead) {
  const std::string classes = "[[class]]\nid = 1\nname = \"chair\"\nkind = \"thing\"\nradius = 0.1\nmin_points = 1\n";
  const auto table =
      ClassTable::parse(classes + "[[similar]]\na = \"chair\"\nb = \"armchair\"\nsimilarity = 0.8\n", "t");
  ASSERT_TRUE(table) << table.error;
  ASSERT_EQ(table->similar().size(), 1U);
  EXPECT_EQ(table->similar()[0].a, "chair");
  EXPECT_EQ(table->similar()[0].b, "armchair");
  EXPECT_EQ(table->similar()[0].similarity, 0.8);
  const auto none = ClassTable::parse("similar = []\n" + classes, "t");
  EXPECT_TRUE(none && none->similar().empty()) << none.error;
  for (const char* bad :
       {"[[similar]]\na = \"chair\"\nb = \"stool\"\n", "[[similar]]\na = \"chair\"\nb = \"stool\"\nsimilarity = 1.5\n",
        "[[similar]]\na = \"chair\"\nb = \"stool\"\nsimilarity = 0.0\n",
        "[[similar]]\na = \"chair\"\nb = \"stool\"\nsimilarity = 0.5\ncolour = 1\n", "similar = 3\n"}) {
    EXPECT_FALSE(ClassTable::parse(bad + classes, "t")) << bad;
  }
}

TEST(ShippedClasses, BuiltinIsSemanticKittiWithMovingClassesFolded) {
  const ClassTable table = ClassTable::builtin();
  const std::pair<ClassId, ClassId> moving[] = {{252, 10}, {253, 31}, {254, 30}, {255, 32},
                                                {256, 16}, {257, 13}, {258, 18}, {259, 20}};
  for (const auto& [label, folded] : moving) {
    ASSERT_NE(table.find(label), nullptr) << label;
    EXPECT_EQ(table.find(label)->id, folded);
    EXPECT_TRUE(table.find(label)->dynamic) << table.name(label);
  }
}

TEST(ShippedClasses, BuiltinKnowsEveryLabelOfSemanticKitti) {
  const ClassTable table = ClassTable::builtin();
  for (const ClassId label :
       std::initializer_list<ClassId>{0,  1,  10, 11, 13, 15, 16, 18, 20, 30,  31,  32,  40,  44,  48,  49,  50,
                                      51, 52, 60, 70, 71, 72, 80, 81, 99, 252, 253, 254, 255, 256, 257, 258, 259}) {
    EXPECT_NE(table.find(label), nullptr) << label;
  }
  EXPECT_EQ(table.find(40)->kind, ClassKind::kStuff);
  EXPECT_EQ(table.find(0)->kind, ClassKind::kIgnore);
}

TEST(ShippedClasses, IndoorTableLoads) {
  const auto table = ClassTable::load(HGG_SOURCE_DIR "/firmware_cfg/indoor/classes.toml");
  ASSERT_TRUE(table) << table.error;
  const auto hasName = [&](const char* name) {
    return std::any_of(table->classes().begin(), table->classes().end(),
                       [&](const ClassInfo& c) { return c.name == name; });
  };
  EXPECT_TRUE(hasName("wall") && hasName("floor") && hasName("chair"));
}

}  // namespace
}  // namespace hgg::classes_test
