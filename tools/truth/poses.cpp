#include "truth/poses.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <system_error>

namespace hgg {
namespace {

constexpr double kRotationTolerance = 1e-2;

bool isBlank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

/// Fills `row` with exactly its size of finite numbers; false when the line holds anything else.
bool parseRow(const std::string& line, std::span<double> row) {
  const char* at = line.data();
  const char* const end = at + line.size();
  for (double& value : row) {
    while (at != end && isBlank(*at)) {
      ++at;
    }
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc() || !std::isfinite(value)) {
      return false;
    }
    at = next;
  }
  while (at != end && isBlank(*at)) {
    ++at;
  }
  return at == end;
}

bool isSkipped(const std::string& line) {
  const std::size_t first = line.find_first_not_of(" \t\r");
  return first == std::string::npos || line[first] == '#';
}

/// Reads every record of `path` through `make`, which returns nothing when the numbers make no sense.
template <typename Record, std::size_t kColumns>
Result<std::vector<Record>> readRecords(const std::filesystem::path& path, const std::string& expected,
                                        std::optional<Record> (*make)(const std::array<double, kColumns>&)) {
  using Records = Result<std::vector<Record>>;
  std::ifstream in(path);
  if (!in) {
    return Records::fail("cannot read " + path.string() + ": " + std::strerror(errno));
  }
  std::vector<Record> records;
  std::string line;
  for (std::size_t number = 1; std::getline(in, line); ++number) {
    if (isSkipped(line)) {
      continue;
    }
    std::array<double, kColumns> row{};
    const std::optional<Record> record = parseRow(line, row) ? make(row) : std::nullopt;
    if (!record) {
      return Records::fail(path.string() + " line " + std::to_string(number) + ": expected " + expected);
    }
    records.push_back(*record);
  }
  return Records::ok(std::move(records));
}

Micros toMicros(double seconds) { return std::llround(seconds * 1e6); }

bool isTime(double seconds) { return std::abs(seconds) < 1e12; }

std::optional<Micros> microsOfRow(const std::array<double, 1>& row) {
  return isTime(row[0]) ? std::optional(toMicros(row[0])) : std::nullopt;
}

std::optional<TimedPose> timedPoseOfRow(const std::array<double, 8>& row) {
  const Eigen::Quaterniond q(row[7], row[4], row[5], row[6]);
  if (!isTime(row[0]) || std::abs(q.norm() - 1.0) > kRotationTolerance) {
    return std::nullopt;
  }
  Pose pose = Pose::Identity();
  pose.linear() = q.normalized().toRotationMatrix();
  pose.translation() = Vec3(row[1], row[2], row[3]);
  return TimedPose{toMicros(row[0]), pose};
}

}  // namespace

std::optional<Pose> poseOfRow(const std::array<double, 12>& row) {
  const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> matrix(row.data());
  const Mat3 given = matrix.leftCols<3>();
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::Quaterniond(given).normalized().toRotationMatrix();
  pose.translation() = matrix.col(3);
  const bool is_rotation = (given - pose.linear()).cwiseAbs().maxCoeff() < kRotationTolerance;
  return is_rotation ? std::optional(pose) : std::nullopt;
}

Result<std::vector<Pose>> readPoses(const std::filesystem::path& path) {
  return readRecords(path, "12 numbers, the rows of a 3x4 rigid transform", &poseOfRow);
}

Result<std::vector<Micros>> readTimes(const std::filesystem::path& path) {
  return readRecords(path, "one number, a time in seconds", &microsOfRow);
}

Result<std::vector<TimedPose>> readTum(const std::filesystem::path& path) {
  return readRecords(path, "8 numbers: t x y z qx qy qz qw with a unit quaternion", &timedPoseOfRow);
}

std::string writePoses(const std::vector<Pose>& poses, const std::filesystem::path& path) {
  std::ofstream out(path);
  out.precision(17);
  for (const Pose& pose : poses) {
    for (int i = 0; i < 12; ++i) {
      out << (i == 0 ? "" : " ") << pose.matrix()(i / 4, i % 4);
    }
    out << "\n";
  }
  out.close();
  return out ? "" : "cannot write " + path.string();
}

}  // namespace hgg
