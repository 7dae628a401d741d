#include "frame/rig.h"

#include <gtest/gtest.h>

namespace hgg::rig_test {
namespace {

const char* const kPose = "[0, 0, 1, 0.1, -1, 0, 0, 0, 0, -1, 0, 0.2]";

std::string camera(const std::string& more = "", const std::string& pose = kPose) {
  return "[[camera]]\nname = \"front\"\nwidth = 640\nheight = 480\nfx = 500\nfy = 500\ncx = 320\ncy = 240\n"
         "T_body_camera = " +
         pose + "\n" + more;
}

std::string lidar(const std::string& more = "") {
  return "[[lidar]]\nT_body_lidar = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]\n" + more;
}

Result<Rig> parse(const std::string& text) { return parseRig(text, "rig.toml", ClassTable::builtin()); }

int lines(const std::string& text) { return static_cast<int>(1 + std::count(text.begin(), text.end(), '\n')); }

TEST(Rig, SaysWhatItHolds) {
  const auto rig =
      parse("wait_s = 0.3\nmax_age_s = 1\n" + lidar("time_offset_s = -0.01\n") +
            camera("labels = \"SEG\"\ndepth = \"DEPTH\"\nmodel = \"fisheye\"\ndistortion = [0.1, 0, 0, 0]\n"
                   "time_offset_s = 0.02\nmargin = 3\ndepth_stride = 2\n"));
  ASSERT_TRUE(rig) << rig.error;
  EXPECT_EQ(rig->wait_us, 300'000);
  EXPECT_EQ(rig->max_age_us, 1'000'000);
  ASSERT_EQ(rig->lidars.size(), 1U);
  EXPECT_EQ(rig->lidars[0].channel, "LIDAR");
  EXPECT_EQ(rig->lidars[0].offset_us, -10'000);
  ASSERT_EQ(rig->cameras.size(), 1U);
  const RigCamera& c = rig->cameras[0];
  EXPECT_EQ(c.labels, "SEG");
  EXPECT_EQ(c.model.lens, Lens::kFisheye);
  EXPECT_EQ(c.model.distortion[0], 0.1);
  EXPECT_EQ(c.offset_us, 20'000);
  EXPECT_EQ(c.margin, 3);
  EXPECT_EQ(c.T_body_camera.translation(), Vec3(0.1, 0, 0.2));
  const auto sources = cloudSources(*rig);
  ASSERT_EQ(sources.size(), 2U);
  EXPECT_EQ(sources[0].channel, "LIDAR");
  EXPECT_EQ(sources[1].channel, "DEPTH");
}

TEST(Rig, TellsEveryMistakeAtOnce) {
  const auto rig = parse(
      "wait = 1\n"
      "[[camera]]\nname = \"front\"\nwidth = 640\nheight = \"tall\"\nfx = -5\nfy = 500000\ncx = 320\ncy = 240\n"
      "distortion = [1, 2]\nmodel = \"cinema\"\nT_body_camera = [1, 1, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]\nmargin = -1\n"
      "label_set = \"moon\"\n" +
      lidar("colour = 3\n"));
  ASSERT_FALSE(rig);
  for (const char* what : {"unknown key 'wait'", "'height'", "'fx'", "'fy'", "'distortion' has 2 numbers", "cinema",
                           "rotation of 'T_body_camera'", "'margin'", "'moon'", "unknown key 'colour'"}) {
    EXPECT_NE(rig.error.find(what), std::string::npos) << what << " is missing in\n" << rig.error;
  }
  EXPECT_GE(lines(rig.error), 10);
}

TEST(Rig, RefusesRotationsThatAreNone) {
  EXPECT_TRUE(parse(lidar() + camera()));
  EXPECT_NE(parse(lidar() + camera("", "[0, 0, 1, 0, -1, 0, 0, 0, 0, 1, 0, 0]")).error.find("mirrors"),
            std::string::npos);
  EXPECT_NE(parse(lidar() + camera("", "[0, 0, 2, 0, -1, 0, 0, 0, 0, -1, 0, 0]")).error.find("orthonormal"),
            std::string::npos);
  EXPECT_NE(parse(lidar() + camera("", "[0, 0, 1, 0]")).error.find("has 4 numbers"), std::string::npos);
  EXPECT_NE(parse(lidar() + camera("", "[0, 0, 1, 900, -1, 0, 0, 0, 0, -1, 0, 0]")).error.find("metres"),
            std::string::npos);
}

TEST(Rig, RefusesALensThatFoldsItsImage) {
  EXPECT_NE(parse(lidar() + camera("distortion = [-9, 0, 0, 0]\n")).error.find("folds"), std::string::npos);
  EXPECT_TRUE(parse(lidar() + camera("distortion = [-0.28, 0.07, 0.0002, -0.0003, 0.01]\n")));
}

TEST(Rig, NeedsSomethingThatMeasuresRanges) {
  EXPECT_NE(parse(camera()).error.find("nothing measures ranges"), std::string::npos);
  EXPECT_TRUE(parse(camera("depth = \"DEPTH_front\"\n")));
  EXPECT_TRUE(parse(lidar()));
  EXPECT_FALSE(parse(""));
}

TEST(Rig, NamesAndChannelsAreThereOnce) {
  const auto rig = parse(lidar() + lidar() + camera() + camera());
  EXPECT_NE(rig.error.find("the name 'lidar' is there twice"), std::string::npos);
  EXPECT_NE(rig.error.find("the channel 'LIDAR' is there twice"), std::string::npos);
  EXPECT_NE(rig.error.find("the channel 'CAMERA_LABELS_front' is there twice"), std::string::npos);
}

TEST(Rig, WithoutALabelSetNumbersAreThoseOfTheClassTable) {
  const auto rig = parse(lidar() + camera());
  ASSERT_TRUE(rig);
  const LabelSet& set = rig->cameras[0].label_set;
  EXPECT_EQ(set.at(10), 10);
  EXPECT_EQ(set.at(252), 252);  // folds into car, later
  EXPECT_EQ(set.at(0), kUnknownClass);
  EXPECT_EQ(set.at(9999), LabelSet::kForeign);
  EXPECT_EQ(set.at(65535), LabelSet::kForeign);
}

TEST(Rig, ALabelSetTurnsTheSegmentersNumbersIntoClasses) {
  const std::string set =
      "[[label_set]]\nname = \"city\"\nno_class = [255]\nclasses = { 0 = \"road\", 13 = \"car\" }\n";
  const auto rig = parse(set + lidar() + camera("label_set = \"city\"\n"));
  ASSERT_TRUE(rig) << rig.error;
  const LabelSet& numbers = rig->cameras[0].label_set;
  EXPECT_EQ(numbers.at(0), 40);
  EXPECT_EQ(numbers.at(13), 10);
  EXPECT_EQ(numbers.at(255), kUnknownClass);
  EXPECT_EQ(numbers.at(1), LabelSet::kForeign);
  EXPECT_NE(parse("[[label_set]]\nname = \"city\"\nclasses = { 0 = \"lava\" }\n" + lidar()).error.find("'lava'"),
            std::string::npos);
}

TEST(Rig, TheUnknownClassIsStuffBesideTheOthers) {
  const ClassTable table = ClassTable::builtin().withUnknown();
  ASSERT_NE(table.find(kUnknownClass), nullptr);
  EXPECT_EQ(table.find(kUnknownClass)->kind, ClassKind::kStuff);
  EXPECT_EQ(table.classes().size(), ClassTable::builtin().classes().size() + 1);
  EXPECT_EQ(ClassTable::builtin().find(kUnknownClass), nullptr);
}

}  // namespace
}  // namespace hgg::rig_test
