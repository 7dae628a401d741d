#include <gtest/gtest.h>

#include <hgg/regions_t.hpp>

#include "bus/codec.h"
#include "generated_codec.h"

namespace hgg::regions_codec_test {
namespace {

TEST(RegionsCodec, SendsAllOfALevel) {
  RegionsUpdate update;
  update.utime_us = 5, update.revision = 6;
  Mat3 cov = Vec3(1, 2, 3).asDiagonal();
  cov(0, 1) = cov(1, 0) = 0.5;
  update.found.regions = {{3, "kitchen", {Vec3(1, 2, 3), cov, 40}, {3, 8, 9}}, {4, "", {Vec3::Zero(), cov, 1}, {4}}};
  update.found.edges = {{3, 4, 0.25F}};
  const auto message = decodeGenerated<hgg::regions_t>(encodeRegions(update));
  EXPECT_EQ(message.utime, 5);
  EXPECT_EQ(message.revision, 6);
  ASSERT_EQ(message.num_regions, 2);
  const hgg::region_t& kitchen = message.regions[0];
  EXPECT_EQ(kitchen.id, 3);
  EXPECT_EQ(kitchen.name, "kitchen");
  EXPECT_EQ(kitchen.mean[1], 2);
  EXPECT_EQ(kitchen.cov[1], 0.5);
  EXPECT_EQ(kitchen.cov[8], 3);
  EXPECT_EQ(kitchen.kappa, 40);
  EXPECT_EQ(kitchen.objects, (std::vector<std::int64_t>{3, 8, 9}));
  EXPECT_EQ(message.regions[1].num_objects, 1);
  ASSERT_EQ(message.num_edges, 1);
  EXPECT_EQ(message.edges[0].b, 4);
  EXPECT_EQ(message.edges[0].weight, 0.25F);
}

}  // namespace
}  // namespace hgg::regions_codec_test
