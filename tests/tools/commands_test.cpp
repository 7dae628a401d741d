#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cstdio>

#include "tools/scratch.h"

namespace hgg::commands_test {
namespace {

struct Outcome {
  int exit_code;
  std::string output, errors;
};

/// In the scratch folder, so that relative paths lead there.
Outcome runCommand(const Scratch& scratch, const std::string& command) {
  const auto errors = scratch / "stderr";
  std::FILE* pipe = popen(
      ("cd " + (scratch / "").string() + " && " HGG_BINARY_DIR "/" + command + " 2>" + errors.string()).c_str(), "r");
  std::string output;
  std::array<char, 4096> buffer{};
  while (const std::size_t n = std::fread(buffer.data(), 1, buffer.size(), pipe)) {
    output.append(buffer.data(), n);
  }
  return {WEXITSTATUS(pclose(pipe)), output, readText(errors)};
}

TEST(Commands, HelpShowsAnExample) {
  const Scratch scratch;
  for (const char* command :
       {"hgg-convert", "hgg-convert semantickitti", "hgg-convert kitti-truth", "hgg-sim", "hgg-eval"}) {
    const Outcome help = runCommand(scratch, std::string(command) + " --help");
    EXPECT_EQ(help.exit_code, 0) << command;
    EXPECT_NE(help.output.find("Example"), std::string::npos) << command;
  }
}

TEST(Commands, BadUsageAndBadInputAreOneLineAndExit2) {
  const Scratch scratch;
  for (const char* command : {"hgg-convert",
                              "hgg-convert semantickitti",
                              "hgg-convert semantickitti /nonexistent -o x",
                              "hgg-sim",
                              "hgg-sim atlantis -o x --truth y",
                              "hgg-sim yard -o /nonexistent/x --truth y",
                              "hgg-sim yard -o x",
                              "hgg-sim yard --truth y",
                              "hgg-sim -o x --truth y",
                              "hgg-sim yard -o x --truth y --labels excellent",
                              "hgg-sim yard --path a b -o x --truth y",
                              "hgg-sim --path a b -o x --truth y",
                              "hgg-sim yard -o x --truth y --dynamics=2",
                              "hgg-sim yard -o x --truth y --seed -1",
                              "hgg-sim yard -o x --truth y --cameras 2",
                              "hgg-sim yard -o x --truth y --no-semantic",
                              "hgg-sim yard -o x --truth y --sensor rgbd --motion-distortion",
                              "hgg-eval",
                              "hgg-eval --truth x",
                              "hgg-eval --truth x --map /nonexistent.hgg",
                              "hgg-eval --truth x --map a --graph b",
                              "hgg-eval --truth x --map a --radius -1"}) {
    const Outcome outcome = runCommand(scratch, command);
    EXPECT_EQ(outcome.exit_code, 2) << command;
    EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1) << command << ": " << outcome.errors;
  }
}

TEST(Commands, NotANumberIsInNoRange) {
  const Scratch scratch;
  for (const char* option : {"--rate ", "--dynamics=", "--range-noise ", "--dropout ", "--speckle ", "--unknown ",
                             "--bleed ", "--confusion ", "--missed ", "--odometry-dropout ", "--odometry-jumps "}) {
    for (const char* value : {"nan", "-nan", "inf", "-1"}) {
      const Outcome outcome =
          runCommand(scratch, std::string("hgg-sim yard --frames 1 --sensor lidar16 -o x --truth y ") + option + value);
      EXPECT_EQ(outcome.exit_code, 2) << option << value;
      EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1) << option << value;
    }
  }
}

TEST(Commands, EvaluatorRefusesRadiusAndSpacingThatAreNoNumbers) {
  const Scratch scratch;
  writeText(scratch / "g.json", R"({"format":"hgg-graph","version":1,"objects":[]})");
  writeText(scratch / "gt_objects.json", "[]");
  const std::string evaluate = "hgg-eval --graph g.json --truth . ";
  ASSERT_EQ(runCommand(scratch, evaluate + "--radius 2 --spacing 0.2").exit_code, 0);
  for (const char* option : {"--radius nan", "--radius inf", "--spacing nan", "--spacing -nan"}) {
    const Outcome outcome = runCommand(scratch, evaluate + option);
    EXPECT_EQ(outcome.exit_code, 2) << option;
    EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1) << option << outcome.errors;
  }
}

TEST(Commands, SimulatorPutsTheClassTableOfTheWorldIntoTheTruth) {
  const Scratch scratch;
  for (const auto& [world, space] : {std::pair("yard", "semantickitti"), std::pair("office", "indoor")}) {
    const std::string drive = std::string("hgg-sim ") + world + " --frames 1 --sensor lidar16 -o log --truth truth";
    ASSERT_EQ(runCommand(scratch, drive).exit_code, 0);
    EXPECT_EQ(readText(scratch / "truth/classes.toml"),
              readText(std::filesystem::path(HGG_SOURCE_DIR) / "firmware_cfg" / space / "classes.toml"));
  }
}

TEST(Commands, ATruthDirectoryThatCannotBeMadeIsKnownBeforeTheDrive) {
  const Scratch scratch;
  writeText(scratch / "file", "not a directory");
  const Outcome outcome = runCommand(scratch, "hgg-sim yard --frames 1 --sensor lidar16 -o log --truth file");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.errors.find("file"), std::string::npos) << outcome.errors;
  EXPECT_FALSE(exists(scratch / "log"));
  EXPECT_FALSE(exists(scratch / "log.part"));
}

TEST(Commands, AFailedDriveLeavesNoTruthOfAnOlderOne) {
  const Scratch scratch;
  const std::string drive = "hgg-sim yard --frames 1 --sensor lidar16 --truth truth -o ";
  ASSERT_EQ(runCommand(scratch, drive + "log").exit_code, 0);
  ASSERT_TRUE(exists(scratch / "truth/gt_objects.json"));
  EXPECT_EQ(runCommand(scratch, drive + "/nonexistent/log").exit_code, 2);
  EXPECT_TRUE(std::filesystem::is_empty(scratch / "truth"));
}

TEST(Commands, SimulatorNamesItsWorldsAndSensors) {
  const Scratch scratch;
  const Outcome list = runCommand(scratch, "hgg-sim --list");
  EXPECT_EQ(list.exit_code, 0);
  for (const char* name : {"yard", "street", "lidar128", "rig"}) {
    EXPECT_NE(list.output.find(name), std::string::npos) << name;
  }
}

TEST(Commands, SimulatedTruthIsReadableByTheEvaluator) {
  const Scratch scratch;
  const std::string truth = (scratch / "truth").string();
  ASSERT_EQ(runCommand(scratch, "hgg-sim yard --frames 1 --sensor lidar16 -o " + (scratch / "log").string() +
                                    " --truth " + truth)
                .exit_code,
            0);
  writeText(scratch / "empty.json", R"({"format":"hgg-graph","version":1,"objects":[]})");
  const Outcome outcome =
      runCommand(scratch, "hgg-eval --graph " + (scratch / "empty.json").string() + " --truth " + truth + " --json");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_NE(outcome.output.find("\"recall\": 0.0"), std::string::npos) << outcome.output;
}

}  // namespace
}  // namespace hgg::commands_test
