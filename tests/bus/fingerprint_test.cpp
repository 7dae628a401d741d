#include <gtest/gtest.h>

#include <bot_core/image_t.hpp>
#include <bot_core/pointcloud2_t.hpp>
#include <bot_core/pose_t.hpp>
#include <bot_core/rigid_transform_t.hpp>
#include <cstdint>
#include <octomap/raw_t.hpp>

namespace hgg {
namespace {

template <typename Message>
std::uint64_t fingerprint() {
  return static_cast<std::uint64_t>(Message::getHash());
}

// Published types of other projects: another hash and their programs no longer understand us.
TEST(Fingerprint, StandardTypesKeepTheirHash) {
  EXPECT_EQ(fingerprint<bot_core::pose_t>(), 0x2e16efb052b0105eu);
  EXPECT_EQ(fingerprint<bot_core::rigid_transform_t>(), 0xea9ffbf2acc5c5aeu);
  EXPECT_EQ(fingerprint<bot_core::image_t>(), 0x14739ffe13d5f5f0u);
  EXPECT_EQ(fingerprint<bot_core::pointcloud2_t>(), 0x0bcd5ce4bf5a1b4au);
  EXPECT_EQ(fingerprint<octomap::raw_t>(), 0xed9cc9dc4eb38ef8u);
}

}  // namespace
}  // namespace hgg
