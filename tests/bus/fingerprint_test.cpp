// Holds the rule of docs/lcm-interface.md, "Changing a type": a fingerprint or a constant that changes here no longer
// is what other programs and recorded logs were built with. Change a golden value only with the steps written there.
#include <gtest/gtest.h>

#include <bot_core/image_metadata_t.hpp>
#include <bot_core/image_t.hpp>
#include <bot_core/pointcloud2_t.hpp>
#include <bot_core/pointfield_t.hpp>
#include <bot_core/pose_t.hpp>
#include <bot_core/rigid_transform_t.hpp>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <hgg/alarm_t.hpp>
#include <hgg/command_reply_t.hpp>
#include <hgg/command_t.hpp>
#include <hgg/edge_t.hpp>
#include <hgg/fragment_t.hpp>
#include <hgg/geometry_update_t.hpp>
#include <hgg/goal_answer_t.hpp>
#include <hgg/goal_query_t.hpp>
#include <hgg/goal_reply_t.hpp>
#include <hgg/graph_update_t.hpp>
#include <hgg/grid_layer_t.hpp>
#include <hgg/keyframe_edge_t.hpp>
#include <hgg/keyframe_t.hpp>
#include <hgg/keyframes_t.hpp>
#include <hgg/label_image_t.hpp>
#include <hgg/object_geometry_t.hpp>
#include <hgg/object_t.hpp>
#include <hgg/region_t.hpp>
#include <hgg/regions_t.hpp>
#include <hgg/sensor_t.hpp>
#include <hgg/status_t.hpp>
#include <hgg/traversability_t.hpp>
#include <iomanip>
#include <iterator>
#include <map>
#include <octomap/raw_t.hpp>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace hgg::fingerprint_test {
namespace {

namespace fs = std::filesystem;

/// A type of lcmtypes/ by the name of its file, its fingerprint as built and as it has to be.
struct Pinned {
  std::string file;
  std::uint64_t fingerprint, golden;
};

template <typename Message>
Pinned pin(const std::string& file, std::uint64_t golden) {
  return {file, static_cast<std::uint64_t>(Message::getHash()), golden};
}

/// Types of other projects: another fingerprint and their programs no longer understand us.
std::vector<Pinned> standardTypes() {
  return {pin<bot_core::image_metadata_t>("bot_core_image_metadata_t", 0x9a4b634d0577fb8eu),
          pin<bot_core::image_t>("bot_core_image_t", 0x14739ffe13d5f5f0u),
          pin<bot_core::pointcloud2_t>("bot_core_pointcloud2_t", 0x0bcd5ce4bf5a1b4au),
          pin<bot_core::pointfield_t>("bot_core_pointfield_t", 0xb24e10825e0b476du),
          pin<bot_core::pose_t>("bot_core_pose_t", 0x2e16efb052b0105eu),
          pin<bot_core::rigid_transform_t>("bot_core_rigid_transform_t", 0xea9ffbf2acc5c5aeu),
          pin<octomap::raw_t>("octomap_raw_t", 0xed9cc9dc4eb38ef8u)};
}

std::vector<Pinned> ownTypes() {
  return {pin<hgg::alarm_t>("hgg_alarm_t", 0x43d12ac3834ac4ceu),
          pin<hgg::command_reply_t>("hgg_command_reply_t", 0x7f43119f965b79b6u),
          pin<hgg::command_t>("hgg_command_t", 0x1ee47f3cbfe785b6u),
          pin<hgg::edge_t>("hgg_edge_t", 0xdd9c5be78489fb68u),
          pin<hgg::fragment_t>("hgg_fragment_t", 0xa45a0a81fabc616au),
          pin<hgg::geometry_update_t>("hgg_geometry_update_t", 0xc4b78c4594b67a31u),
          pin<hgg::goal_answer_t>("hgg_goal_answer_t", 0x99257111dbe9fa4bu),
          pin<hgg::goal_query_t>("hgg_goal_query_t", 0x574fdbdf93cb6ceau),
          pin<hgg::goal_reply_t>("hgg_goal_reply_t", 0x0480584837ede91au),
          pin<hgg::graph_update_t>("hgg_graph_update_t", 0xb514592b2e97a056u),
          pin<hgg::grid_layer_t>("hgg_grid_layer_t", 0x992ae9b0dbb2b721u),
          pin<hgg::keyframe_edge_t>("hgg_keyframe_edge_t", 0xa73aca87dede2a63u),
          pin<hgg::keyframe_t>("hgg_keyframe_t", 0x6ba7109176b9f565u),
          pin<hgg::keyframes_t>("hgg_keyframes_t", 0xbb4152b9962cfc3eu),
          pin<hgg::label_image_t>("hgg_label_image_t", 0x77707cdd111dfc29u),
          pin<hgg::object_geometry_t>("hgg_object_geometry_t", 0xef0beffde146583du),
          pin<hgg::object_t>("hgg_object_t", 0xf73966cc49ecb015u),
          pin<hgg::region_t>("hgg_region_t", 0x9949bf5e3045d737u),
          pin<hgg::regions_t>("hgg_regions_t", 0xfa9edb8a5b6e96f4u),
          pin<hgg::sensor_t>("hgg_sensor_t", 0xe0e99fd7c73070d0u),
          pin<hgg::status_t>("hgg_status_t", 0x430a4bb4595b1e1au),
          pin<hgg::traversability_t>("hgg_traversability_t", 0xf7a8a26172165bc6u)};
}

std::vector<Pinned> allTypes() {
  auto all = standardTypes();
  const auto own = ownTypes();
  all.insert(all.end(), own.begin(), own.end());
  return all;
}

/// LCM leaves constants out of the fingerprint, so they are pinned as text. New ones may be added at the end.
const std::map<std::string, std::string>& goldenConstants() {
  static const std::map<std::string, std::string> kConstants{
      {"hgg_alarm_t", "WARNING = 1, SERIOUS = 2"},
      {"hgg_command_t",
       "SAVE = 1, RESET = 2, RESEND_ALL = 3, PUBLISH_GEOMETRY = 4, PUBLISH_OCTOMAP = 5, PUBLISH_TRAVERSABILITY = 6"},
      {"hgg_goal_answer_t", "OBJECT = 1, REGION = 2"},
      {"hgg_goal_reply_t",
       "OK = 1, AMBIGUOUS = 2, NOT_FOUND = 3, NOT_UNDERSTOOD = 4, FAILED = 5, NO_GOAL = 0, REACHABLE = 1, NEAREST = 2"},
      {"hgg_grid_layer_t", "UINT8 = 1, FLOAT32 = 2, RAW = 0, ZSTD = 1"},
      {"hgg_keyframe_edge_t", "TRACK = 1, LOOP = 2, JOIN = 3"},
      {"hgg_keyframe_t", "UNKNOWN = 0, ALIGNED = 1, DEGENERATE = 2, ODOMETRY = 3, LOST = 4"},
      {"hgg_label_image_t", "RAW = 0, ZSTD = 1"},
      {"hgg_status_t", "STATE_UNKNOWN = 0, STATE_OK = 1, STATE_DEGRADED = 2, STATE_LOST = 3"},
      {"hgg_traversability_t", "COST_FREE = 0, COST_WORST = 252, COST_BLOCKED = 254, COST_UNKNOWN = 255"}};
  return kConstants;
}

std::string readText(const fs::path& path) {
  std::ifstream in(path);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The text of each file of lcmtypes/ by its name without extension.
std::map<std::string, std::string> typeFiles() {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::directory_iterator(fs::path(HGG_SOURCE_DIR) / "lcmtypes")) {
    if (entry.path().extension() == ".lcm") {  // as CMakeLists.txt takes them
      files[entry.path().stem().string()] = readText(entry.path());
    }
  }
  return files;
}

std::vector<std::string> matches(const std::string& text, const std::string& pattern) {
  const std::regex regex(pattern);
  std::vector<std::string> found;
  for (std::sregex_iterator it(text.begin(), text.end(), regex), end; it != end; ++it) {
    found.push_back((*it)[1]);
  }
  return found;
}

/// "A = 1, B = 2": the constants of a type in the order of its file.
std::string constantsOf(const std::string& text) {
  std::string joined;
  for (const std::string& constants : matches(text, R"(const\s+\w+\s+([^;]+);)")) {
    joined += (joined.empty() ? "" : ", ") + constants;
  }
  return joined;
}

std::string inHex(std::uint64_t fingerprint) {
  std::ostringstream out;
  out << "0x" << std::hex << std::setw(16) << std::setfill('0') << fingerprint;
  return out.str();
}

TEST(Fingerprint, StandardTypesKeepTheirs) {
  for (const Pinned& type : standardTypes()) {
    EXPECT_EQ(inHex(type.fingerprint), inHex(type.golden)) << type.file;
  }
}

TEST(Fingerprint, OwnTypesKeepTheirs) {
  for (const Pinned& type : ownTypes()) {
    EXPECT_EQ(inHex(type.fingerprint), inHex(type.golden)) << type.file << ": see docs/lcm-interface.md";
  }
}

TEST(Fingerprint, EveryTypeIsPinned) {
  std::set<std::string> files, pinned;
  for (const auto& [name, text] : typeFiles()) {
    files.insert(name);
  }
  for (const Pinned& type : allTypes()) {
    pinned.insert(type.file);
  }
  EXPECT_EQ(files, pinned);
}

TEST(Fingerprint, ConstantsKeepTheirValues) {
  std::map<std::string, std::string> constants;
  for (const auto& [name, text] : typeFiles()) {
    if (const std::string found = constantsOf(text); !found.empty()) {
      constants[name] = found;
    }
  }
  EXPECT_EQ(constants, goldenConstants());
}

// The fingerprint does not cover a type's name: two types with the same fields would be taken for each other.
TEST(Fingerprint, NoTwoTypesShareOne) {
  std::map<std::uint64_t, std::string> seen;
  for (const Pinned& type : allTypes()) {
    const auto [it, is_new] = seen.emplace(type.fingerprint, type.file);
    EXPECT_TRUE(is_new) << type.file << " and " << it->second;
  }
}

TEST(Fingerprint, AFileHoldsTheOneTypeItIsNamedAfter) {
  for (const auto& [name, text] : typeFiles()) {
    const auto packages = matches(text, R"((?:^|\n)package (\w+);)"), types = matches(text, R"(\nstruct (\w+)\s*\{)");
    ASSERT_EQ(packages.size(), 1U) << name;
    ASSERT_EQ(types.size(), 1U) << name;
    EXPECT_EQ(packages[0] + "_" + types[0], name);
  }
}

TEST(Fingerprint, TheDocumentationListsEachOfOurs) {
  const std::string page = readText(fs::path(HGG_SOURCE_DIR) / "docs" / "lcm-interface.md");
  for (const Pinned& type : ownTypes()) {
    const std::string name = type.file.substr(std::string("hgg_").size());
    EXPECT_NE(page.find("| " + name + " | `" + inHex(type.fingerprint) + "` |"), std::string::npos)
        << name << " " << inHex(type.fingerprint);
  }
}

}  // namespace
}  // namespace hgg::fingerprint_test
