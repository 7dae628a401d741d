#include "config.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <sstream>

#include "tools/scratch.h"

namespace hgg::config_test {
namespace {

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

auto linesIn(const std::string& text) { return std::count(text.begin(), text.end(), '\n') + 1; }

/// The complaints about a config, one a line; fails the test when there are none.
std::string complaints(const std::string& toml) {
  const Result<Config> config = parseConfig(toml, "f.toml");
  EXPECT_FALSE(config) << toml;
  return config.error;
}

/// "section.key" -> the comment behind its value.
std::map<std::string, std::string> commentsOf(const std::string& toml) {
  std::map<std::string, std::string> comments;
  std::istringstream lines(toml);
  std::string section;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('[')) {
      section = line.substr(1, line.find(']') - 1) + ".";
    } else if (const auto at = line.find(" = "); at != std::string::npos && !line.starts_with('#')) {
      const auto comment = line.find("  # ");
      comments[section + line.substr(0, at)] = comment == std::string::npos ? "" : line.substr(comment);
    }
  }
  return comments;
}

TEST(PrintConfig, ParsesBackToTheDefaults) {
  const auto config = parseConfig(printConfig(Config{}), "printed");
  ASSERT_TRUE(config) << config.error;
  EXPECT_EQ(printConfig(*config), printConfig(Config{}));
}

TEST(PrintConfig, ParsesBackToTheSameValuesWhateverTheyAre) {
  Config c;
  c.classes = "a \"quoted\" \\path\\ with\ttabs, # and \xc3\xa9.toml";
  c.lcm.url = "udpm://1.2.3.4:5?ttl=1";
  c.lcm.odometry = "O'DOM";
  c.frame.range_min = 0.1 + 0.2;
  c.frame.range_max = 81.0 / 7;
  c.frame.odometry_wait_ms = 10000;
  c.creation.beam_spacing_deg = 1e-7;
  c.creation.leaf_points = 99999;
  c.creation.sigma_floor = 1.0 / 3;
  c.map.active_radius = 1234.5678901234567;
  const auto parsed = parseConfig(printConfig(c), "printed");
  ASSERT_TRUE(parsed) << parsed.error << "\n" << printConfig(c);
  EXPECT_EQ(parsed->classes, c.classes);
  EXPECT_EQ(parsed->lcm.odometry, c.lcm.odometry);
  EXPECT_EQ(parsed->frame.range_min, c.frame.range_min);
  EXPECT_EQ(parsed->frame.range_max, c.frame.range_max);
  EXPECT_EQ(parsed->creation.beam_spacing_deg, c.creation.beam_spacing_deg);
  EXPECT_EQ(parsed->creation.leaf_points, c.creation.leaf_points);
  EXPECT_EQ(parsed->creation.sigma_floor, c.creation.sigma_floor);
  EXPECT_EQ(parsed->map.active_radius, c.map.active_radius);
  EXPECT_EQ(printConfig(*parsed), printConfig(c));
}

TEST(PrintConfig, ExplainsEveryKey) {
  const auto comments = commentsOf(printConfig(Config{}));
  EXPECT_GE(comments.size(), 20U);
  for (const auto& [key, comment] : comments) {
    EXPECT_GT(comment.size(), 10U) << key;
  }
}

TEST(ParseConfig, OfAnEmptyTextGivesTheDefaults) {
  const auto config = parseConfig("", "f.toml");
  ASSERT_TRUE(config) << config.error;
  EXPECT_EQ(printConfig(*config), printConfig(Config{}));
}

TEST(ParseConfig, SetsWhatIsGivenAndKeepsTheRest) {
  const auto config = parseConfig("[frame]\nrange_max = 15\n[map]\nleaf_size = 0.1\n[lcm]\nstatus = \"S\"\n", "f.toml");
  ASSERT_TRUE(config) << config.error;
  EXPECT_EQ(config->frame.range_max, 15);
  EXPECT_EQ(config->map.leaf_size, 0.1);
  EXPECT_EQ(config->lcm.status, "S");
  EXPECT_EQ(config->frame.range_min, Config{}.frame.range_min);
}

TEST(ParseConfig, ListsEveryUnknownKeyAndBadValueAtOnceWithItsLine) {
  const std::string error = complaints(
      "speed = 3\n"                  // 1
      "[frame]\n"                    // 2
      "range_max = 5000\n"           // 3
      "range_mim = 1\n"              // 4
      "min_confidence = \"high\"\n"  // 5
      "[creation]\n"                 // 6
      "leaf_points = 64.5\n"         // 7
      "tile_size = true\n"           // 8
      "sigma_floor = nan\n"          // 9
      "[lcm]\n"                      // 10
      "odometry = 7\n"               // 11
      "status = \"\"\n"              // 12
      "[magic]\n"                    // 13
      "power = 9000\n");             // 14
  for (const char* expected :
       {"f.toml:1: unknown key 'speed'", "f.toml:3: 'frame.range_max' = 5000 is outside 1 .. 1000 m",
        "f.toml:4: unknown key 'frame.range_mim'", "f.toml:5: 'frame.min_confidence' must be a number",
        "f.toml:7: 'creation.leaf_points' must be an integer", "f.toml:8: 'creation.tile_size' must be a number",
        "f.toml:9: 'creation.sigma_floor' = nan is outside", "f.toml:11: 'lcm.odometry' must be a string",
        "f.toml:12: 'lcm.status' must not be empty", "f.toml:13: unknown key 'magic'"}) {
    EXPECT_TRUE(has(error, expected)) << "missing: " << expected << "\nin\n" << error;
  }
  EXPECT_EQ(linesIn(error), 10) << error;
}

TEST(ParseConfig, SwitchesAreTrueOrFalseAndNothingElse) {
  EXPECT_TRUE(parseConfig("[ablation]\nsymmetric_merge = true\n", "f")->ablation.symmetric_merge);
  EXPECT_FALSE(parseConfig("[ablation]\nsymmetric_merge = false\n", "f")->ablation.symmetric_merge);
  EXPECT_EQ(parseConfig("[ablation]\ncost = \"iou\"\n", "f")->ablation.cost, PairCost::kIou);
  EXPECT_TRUE(has(complaints("[ablation]\ncost = \"overlap\"\n"), "'ablation.cost' must be"));
  for (const char* value : {"1", "\"true\"", "0.5", "[]"}) {
    EXPECT_TRUE(has(complaints(std::string("[ablation]\nsymmetric_merge = ") + value),
                    "'ablation.symmetric_merge' must be true or false"))
        << value;
  }
}

TEST(ParseConfig, AcceptsTheEndsOfARangeAndNothingBeyond) {
  EXPECT_TRUE(parseConfig("[frame]\nrange_min = 0\n[creation]\nleaf_points = 4\n", "f"));
  EXPECT_TRUE(parseConfig("[frame]\nrange_max = 1000\n[map]\nmerge_overlap = 1\n", "f"));
  for (const char* toml :
       {"[frame]\nrange_min = -0.001", "[frame]\nrange_max = 1000.1", "[frame]\nrange_max = inf",
        "[creation]\nleaf_points = 0", "[creation]\nleaf_points = 4294967360", "[map]\nleaf_size = 1e-300"}) {
    EXPECT_TRUE(has(complaints(toml), "is outside")) << toml;
  }
}

TEST(ParseConfig, ASectionGivenAsAValueIsAnErrorNotSilence) {
  for (const char* toml : {"frame = 3", "frame = []", "[[frame]]\nrange_max = 15", "map = \"big\""}) {
    EXPECT_TRUE(has(complaints(toml), "f.toml:1:")) << toml;
  }
}

TEST(ParseConfig, AValueGivenAsASectionIsAnError) {
  EXPECT_TRUE(has(complaints("[classes]\nfile = \"x\""), "'classes' must be a string"));
  EXPECT_TRUE(has(complaints("[frame.range_max]\nfar = 1"), "'frame.range_max' must be a number"));
}

TEST(ParseConfig, AQuotedKeyWithADotIsNotThatKey) {
  EXPECT_TRUE(has(complaints("\"frame.range_max\" = 15"), "unknown key"));
}

TEST(ParseConfig, TakesTheMountingOfACloudChannelByItsName) {
  const auto config = parseConfig("[T_body_lidar]\nLIDAR_SEMANTIC = [1, -2.5, 0.5, 0, 30, 90]", "f");
  ASSERT_TRUE(config) << config.error;
  EXPECT_EQ(config->T_body_lidar.lidar_semantic, (Mounting{1, -2.5, 0.5, 0, 30, 90}));
  const auto renamed =
      parseConfig("[T_body_lidar]\n\"a.b c\" = [1, 2, 3, 4, 5, 6]\n[lcm]\nlidar_semantic = \"a.b c\"", "f");
  ASSERT_TRUE(renamed) << renamed.error;
  EXPECT_EQ(renamed->T_body_lidar.lidar_semantic, (Mounting{1, 2, 3, 4, 5, 6}));
  EXPECT_TRUE(has(printConfig(*renamed), "\n\"a.b c\" = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]"));
  EXPECT_EQ(printConfig(*parseConfig(printConfig(*renamed), "printed")), printConfig(*renamed));
}

TEST(ParseConfig, AMountingIsSixFiniteNumbersOfAKnownChannel) {
  for (const char* value : {"[1, 2, 3]", "[1, 2, 3, 4, 5, 6, 7]", "[0, 0, 0, 0, 0, \"90\"]", "1.5", "[]"}) {
    EXPECT_TRUE(has(complaints(std::string("[T_body_lidar]\nLIDAR_SEMANTIC = ") + value),
                    "f.toml:2: 'T_body_lidar.LIDAR_SEMANTIC' must be [x, y, z, roll, pitch, yaw]"))
        << value;
  }
  for (const char* value : {"[nan, 0, 0, 0, 0, 0]", "[0, inf, 0, 0, 0, 0]", "[0, 0, 0, 0, 0, 5000]"}) {
    EXPECT_TRUE(has(complaints(std::string("[T_body_lidar]\nLIDAR_SEMANTIC = ") + value), "outside -1000 .. 1000"));
  }
  EXPECT_TRUE(has(complaints("[T_body_lidar]\nVELODYNE = [0, 0, 0, 0, 0, 0]"),
                  "'T_body_lidar.VELODYNE': no cloud channel has this name (there is LIDAR_SEMANTIC)"));
  EXPECT_TRUE(has(complaints("T_body_lidar = [0, 0, 0, 0, 0, 0]"), "'T_body_lidar' must be a section"));
}

TEST(ParseConfig, ChecksKeysAgainstEachOther) {
  EXPECT_TRUE(
      has(complaints("[frame]\nrange_min = 20\nrange_max = 15"), "'frame.range_min' must be below 'frame.range_max'"));
  EXPECT_TRUE(has(complaints("[creation]\nbeam_spacing_deg = 3\nbeam_factor = 2.7"), "beam_factor"));
  EXPECT_TRUE(parseConfig("[creation]\nbeam_spacing_deg = 3\nbeam_factor = 2.5", "f"));
}

TEST(ParseConfig, NamesTheLineOfWrongSyntax) {
  EXPECT_TRUE(has(complaints("[frame]\nrange_max = = 3"), "f.toml:2:"));
  EXPECT_TRUE(has(complaints("[frame\n"), "f.toml:1:"));
  EXPECT_TRUE(has(complaints("[frame]\nrange_max = 3\nrange_max = 4\n"), "f.toml:3:"));
  EXPECT_TRUE(has(complaints("\xff"), "f.toml:1:"));
}

TEST(LoadConfig, WithoutAFileGivesTheDefaultsAndTheBuiltInClasses) {
  const auto loaded = loadConfig("");
  ASSERT_TRUE(loaded) << loaded.error;
  EXPECT_EQ(printConfig(loaded->config), printConfig(Config{}));
  EXPECT_EQ(loaded->classes.name(10), "car");
}

TEST(LoadConfig, OfAnEmptyFileGivesTheDefaults) {
  const Scratch scratch;
  writeText(scratch / "f.toml", "");
  const auto loaded = loadConfig((scratch / "f.toml").string());
  ASSERT_TRUE(loaded) << loaded.error;
  EXPECT_EQ(printConfig(loaded->config), printConfig(Config{}));
}

TEST(LoadConfig, SaysWhichFileCannotBeRead) {
  const Scratch scratch;
  for (const std::string& path : {(scratch / "none.toml").string(), (scratch / "").string()}) {
    const auto loaded = loadConfig(path);
    EXPECT_FALSE(loaded);
    EXPECT_TRUE(has(loaded.error, path + ": cannot read the config file")) << loaded.error;
    EXPECT_EQ(linesIn(loaded.error), 1);
  }
}

TEST(LoadConfig, FindsTheClassTableBesideTheConfig) {
  const Scratch scratch;
  writeText(scratch / "robot/f.toml", "classes = \"labels/c.toml\"\n");
  const std::string path = (scratch / "robot/f.toml").string();
  const auto missing = loadConfig(path);
  EXPECT_FALSE(missing);
  EXPECT_TRUE(has(missing.error, "robot/labels/c.toml: cannot read the class table")) << missing.error;

  writeText(scratch / "robot/labels/c.toml", "[[class]]\nid = 7\nname = \"rock\"\nkind = \"ignore\"\n");
  const auto loaded = loadConfig(path);
  ASSERT_TRUE(loaded) << loaded.error;
  EXPECT_EQ(loaded->classes.name(7), "rock");

  writeText(scratch / "robot/labels/c.toml", "[[class]]\nid = 7\n");
  EXPECT_TRUE(has(loadConfig(path).error, "c.toml:1: [[class]]: key 'name' is missing"));
}

class ShippedConfig : public testing::TestWithParam<const char*> {
 protected:
  std::string path() const { return std::string(HGG_SOURCE_DIR "/firmware_cfg/") + GetParam() + "/hggmap.toml"; }
};

TEST_P(ShippedConfig, LoadsWithTheClassTableBesideIt) {
  const auto loaded = loadConfig(path());
  ASSERT_TRUE(loaded) << loaded.error;
  EXPECT_TRUE(loaded->config.classes.ends_with("classes.toml"));
}

TEST_P(ShippedConfig, HoldsEveryKeyExplainedAsPrinted) {
  auto shipped = commentsOf(readText(path()));
  for (const auto& [key, comment] : commentsOf(printConfig(Config{}))) {
    EXPECT_EQ(shipped[key], comment) << key;
    shipped.erase(key);
  }
  EXPECT_EQ(shipped.size(), 0U) << shipped.begin()->first << " is no key";
}

INSTANTIATE_TEST_SUITE_P(Robots, ShippedConfig,
                         testing::Values("semantickitti", "indoor", "kitti_hdl64_cam", "rgbd", "spot_odin1"));

}  // namespace
}  // namespace hgg::config_test
