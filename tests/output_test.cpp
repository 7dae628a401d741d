#include "output.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "map/file.h"
#include "test_scene.h"
#include "tools/scratch.h"

namespace hgg {
namespace {

StepReport reportAt(Micros utime_us, const Vec3& position, double yaw) {
  StepReport report;
  report.utime_us = utime_us;
  report.T_map_body.linear() = Eigen::AngleAxisd(yaw, Vec3::UnitZ()).toRotationMatrix();
  report.T_map_body.translation() = position;
  return report;
}

TEST(OutputDirectory, LeavesMapTrajectoryAndStatistics) {
  const Scratch scratch;
  const std::string directory = (scratch / "new/deep").string();
  Mapper mapper({}, testClasses());
  auto out = OutputDirectory::open(directory);
  ASSERT_TRUE(out) << out.error;
  out->add(reportAt(1'000'007, Vec3(1, 2, 3), M_PI / 2), {12, {}}, mapper.map());
  out->add(reportAt(2'500'000, Vec3(123456.789, -0.001, 0), 0), {14, {}}, mapper.map());
  ASSERT_EQ(out->finish(mapper, {2, 0, 0, 0, 0, 0}), "");

  EXPECT_TRUE(loadMap(directory + "/map.hgg"));
  EXPECT_EQ(nlohmann::json::parse(readText(directory + "/stats.json"))["frames"], 2);
  std::istringstream lines(readText(directory + "/trajectory.tum"));
  std::vector<std::vector<double>> rows;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    rows.emplace_back(std::istream_iterator<double>(words), std::istream_iterator<double>());
  }
  ASSERT_EQ(rows.size(), 2U);
  const std::vector<std::vector<double>> expected{{1.000007, 1, 2, 3, 0, 0, std::sqrt(0.5), std::sqrt(0.5)},
                                                  {2.5, 123456.789, -0.001, 0, 0, 0, 0, 1}};
  for (std::size_t r = 0; r < 2; ++r) {
    ASSERT_EQ(rows[r].size(), 8U);
    for (std::size_t k = 0; k < 8; ++k) {
      EXPECT_NEAR(rows[r][k], expected[r][k], 1e-6) << "row " << r << ", column " << k;
    }
  }
}

TEST(OutputDirectory, KeepsTimesOfOurEraToTheMicrosecond) {
  const Scratch scratch;
  const Mapper mapper({}, testClasses());
  auto out = OutputDirectory::open((scratch / "").string());
  ASSERT_TRUE(out) << out.error;
  out->add(reportAt(1'700'000'000'000'042, Vec3(0, 0, 0), 0), {1, {}}, mapper.map());
  ASSERT_EQ(out->finish(mapper, {}), "");
  EXPECT_TRUE(readText(scratch / "trajectory.tum").starts_with("1700000000.000042 "));
}

TEST(OutputDirectory, ThatCannotBeMadeIsAnErrorThatNamesIt) {
  const Scratch scratch;
  writeText(scratch / "file", "in the way");
  const auto out = OutputDirectory::open((scratch / "file/sub").string());
  EXPECT_FALSE(out);
  EXPECT_NE(out.error.find((scratch / "file/sub").string()), std::string::npos) << out.error;
}

}  // namespace
}  // namespace hgg
