#include "truth/cloud.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

namespace hgg {
namespace {

constexpr std::size_t kRecordBytes = 3 * sizeof(float) + sizeof(ClassId) + sizeof(std::uint32_t);

std::string headerOf(std::size_t points) {
  return "ply\nformat binary_little_endian 1.0\ncomment reference cloud, map frame\nelement vertex " +
         std::to_string(points) +
         "\nproperty float x\nproperty float y\nproperty float z\nproperty ushort label\nproperty uint object\n"
         "end_header\n";
}

template <typename T>
char* pack(char* to, const T& value) {
  std::memcpy(to, &value, sizeof(T));
  return to + sizeof(T);
}

template <typename T>
const char* unpack(const char* from, T& value) {
  std::memcpy(&value, from, sizeof(T));
  return from + sizeof(T);
}

CloudPoint pointOf(const char* record) {
  CloudPoint p{};
  record = unpack(unpack(unpack(record, p.x), p.y), p.z);
  unpack(unpack(record, p.label), p.object);
  return p;
}

/// The number of points that a header of ours announces, read off its start; nullopt when it is another's.
std::optional<std::size_t> announcedPoints(const std::string& bytes) {
  const std::string key = "element vertex ";
  const std::size_t at = bytes.find(key);
  std::size_t points = 0;
  if (at == std::string::npos || !(std::istringstream(bytes.substr(at + key.size(), 20)) >> points)) {
    return std::nullopt;
  }
  return bytes.starts_with(headerOf(points)) ? std::optional(points) : std::nullopt;
}

}  // namespace

std::string writeCloud(const std::vector<CloudPoint>& cloud, const std::filesystem::path& path) {
  std::ofstream out(path, std::ios::binary);
  out << headerOf(cloud.size());
  std::vector<char> bytes(cloud.size() * kRecordBytes);
  char* to = bytes.data();
  for (const CloudPoint& p : cloud) {
    to = pack(pack(pack(pack(pack(to, p.x), p.y), p.z), p.label), p.object);
  }
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  return out ? "" : "cannot write " + path.string();
}

Result<std::vector<CloudPoint>> readCloud(const std::filesystem::path& path) {
  using Cloud = Result<std::vector<CloudPoint>>;
  std::ifstream in(path, std::ios::binary);
  std::stringstream text;
  if (!in || !(text << in.rdbuf())) {
    return Cloud::fail("cannot read " + path.string() + ": " + std::strerror(errno));
  }
  const std::string bytes = std::move(text).str();
  const auto points = announcedPoints(bytes);
  if (!points) {
    return Cloud::fail(path.string() + " is not a reference cloud as hgg-sim writes it: make it anew");
  }
  const std::size_t start = headerOf(*points).size();
  if ((bytes.size() - start) / kRecordBytes != *points || (bytes.size() - start) % kRecordBytes != 0) {
    return Cloud::fail(path.string() + " is cut short or too long: make it anew");
  }
  std::vector<CloudPoint> cloud;
  cloud.reserve(*points);
  for (std::size_t i = 0; i < *points; ++i) {
    cloud.push_back(pointOf(bytes.data() + start + i * kRecordBytes));
  }
  return Cloud::ok(std::move(cloud));
}

}  // namespace hgg
