#include <gtest/gtest.h>
#include <octomap/OcTree.h>
#include <zstd.h>

#include <cmath>
#include <cstring>
#include <hgg/command_reply_t.hpp>
#include <hgg/command_t.hpp>
#include <hgg/traversability_t.hpp>
#include <limits>
#include <octomap/raw_t.hpp>
#include <random>
#include <sstream>

#include "bus/codec.h"
#include "generated_codec.h"

namespace hgg::ground_codec_test {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

/// Costs and heights at random in the first level, a few in the second, none in the third.
GroundGrid someGrid(std::int32_t width, std::int32_t height) {
  std::mt19937 random(5);
  GroundGrid grid;
  grid.utime_us = 11, grid.revision = 12;
  grid.x = -3.5, grid.y = 2, grid.resolution = 0.25, grid.reference_z = -1.5;
  grid.width = width, grid.height = height, grid.levels = 3;
  const std::size_t cells = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  grid.cost.assign(3 * cells, 255);
  grid.layers = {{"height", std::vector<float>(3 * cells, kNaN)}};
  for (std::size_t k = 0; k < cells; ++k) {
    grid.cost[k] = static_cast<std::uint8_t>(random());
    grid.layers[0].values[k] = static_cast<float>(random() % 1000) * 0.01F;
  }
  grid.cost[cells + 1] = 3, grid.layers[0].values[cells + 1] = -std::numeric_limits<float>::infinity();
  return grid;
}

template <typename T>
std::vector<T> valuesOf(const hgg::grid_layer_t& layer) {
  const std::size_t size = ZSTD_getFrameContentSize(layer.data.data(), layer.data.size());
  std::vector<T> values(size / sizeof(T));
  EXPECT_EQ(ZSTD_decompress(values.data(), size, layer.data.data(), layer.data.size()), size);
  return values;
}

/// Values are sent to a thousandth.
bool isSame(float a, float b) { return a == b || std::abs(a - b) <= 0.0005F || (std::isnan(a) && std::isnan(b)); }

TEST(GroundCodec, PartsOfAGridLieSideBySideAndSayWhatTheWholeSays) {
  const GroundGrid grid = someGrid(70, 45);
  for (const std::size_t most_bytes : {std::size_t{1} << 20, std::size_t{3000}}) {
    const auto messages = encodeTraversability(grid, most_bytes);
    EXPECT_EQ(messages.size() > 1, most_bytes == 3000);
    std::vector<int> told(static_cast<std::size_t>(grid.width * grid.height), 0);
    for (const Message& bytes : messages) {
      EXPECT_LE(bytes.size(), most_bytes);
      const auto part = decodeGenerated<hgg::traversability_t>(bytes);
      EXPECT_EQ(part.utime, 11);
      EXPECT_EQ(part.revision, 12);
      EXPECT_EQ(part.reference_z, -1.5);
      ASSERT_EQ(part.num_layers, 2);
      EXPECT_EQ(part.layers[0].name, "cost");
      EXPECT_EQ(part.layers[0].format, hgg::grid_layer_t::UINT8);
      EXPECT_EQ(part.layers[1].name, "height");
      EXPECT_EQ(part.layers[1].format, hgg::grid_layer_t::FLOAT32);
      const auto cost = valuesOf<std::uint8_t>(part.layers[0]);
      const auto height = valuesOf<float>(part.layers[1]);
      ASSERT_EQ(cost.size(), static_cast<std::size_t>(part.num_levels * part.height * part.width));
      ASSERT_EQ(height.size(), cost.size());
      const auto column = static_cast<std::int32_t>(std::lround((part.origin[0] - grid.x) / grid.resolution));
      const auto row = static_cast<std::int32_t>(std::lround((part.origin[1] - grid.y) / grid.resolution));
      for (std::int32_t level = 0; level < part.num_levels; ++level) {
        for (std::int32_t r = 0; r < part.height; ++r) {
          for (std::int32_t c = 0; c < part.width; ++c) {
            const auto here = static_cast<std::size_t>((level * part.height + r) * part.width + c);
            const auto there = static_cast<std::size_t>((level * grid.height + row + r) * grid.width + column + c);
            ASSERT_EQ(cost[here], grid.cost[there]);
            ASSERT_TRUE(isSame(height[here], grid.layers[0].values[there]));
            told[there % told.size()] += level == 0 ? 1 : 0;
          }
        }
      }
    }
    EXPECT_EQ(told, std::vector<int>(told.size(), 1)) << "each cell in one part";
  }
}

TEST(GroundCodec, LevelsWithoutAnythingAreNotSent) {
  const auto messages = encodeTraversability(someGrid(20, 20));
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_EQ(decodeGenerated<hgg::traversability_t>(messages[0]).num_levels, 2);
}

TEST(GroundCodec, AnOctomapIsReadByOctomap) {
  octomap::OcTree tree(0.1);
  tree.updateNode(octomap::point3d(1.05F, 2.05F, 0.55F), true);
  tree.updateNode(octomap::point3d(-1.05F, 2.05F, 0.55F), false);
  std::ostringstream out;
  ASSERT_TRUE(tree.writeBinaryConst(out));
  const auto raw = decodeGenerated<octomap::raw_t>(encodeOctomap({17, out.str()}));
  EXPECT_EQ(raw.utime, 17);
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c < 4; ++c) {
      EXPECT_EQ(raw.transform[r][c], r == c ? 1 : 0);
    }
  }
  std::istringstream in(std::string(raw.data.begin(), raw.data.end()));
  octomap::OcTree read(1);
  ASSERT_TRUE(read.readBinary(in));
  EXPECT_EQ(read.getResolution(), 0.1);
  ASSERT_NE(read.search(1.05, 2.05, 0.55), nullptr);
  EXPECT_TRUE(read.isNodeOccupied(read.search(1.05, 2.05, 0.55)));
  EXPECT_FALSE(read.isNodeOccupied(read.search(-1.05, 2.05, 0.55)));
}

hgg::command_t someCommand() {
  hgg::command_t c{};
  c.utime = 5;
  c.client = "nav";
  c.request_id = -7;
  c.command = hgg::command_t::PUBLISH_TRAVERSABILITY;
  c.has_region = 1;
  c.region[0] = -1, c.region[1] = -2, c.region[2] = 3, c.region[3] = 4;
  c.reference_z = 0.5;
  c.resolution = 0.2;
  return c;
}

TEST(CommandCodec, TakesWhatTheGeneratedTypeWrites) {
  const auto command = decodeCommand(encodeGenerated(someCommand()));
  ASSERT_TRUE(command) << command.error;
  EXPECT_EQ(command->client, "nav");
  EXPECT_EQ(command->request_id, -7);
  EXPECT_EQ(command->kind, CommandKind::kPublishTraversability);
  EXPECT_EQ(command->region, (std::array<double, 4>{-1, -2, 3, 4}));
  EXPECT_EQ(command->reference_z, 0.5);
  EXPECT_EQ(command->resolution, 0.2);
  auto whole = someCommand();
  whole.has_region = 0;
  EXPECT_FALSE(decodeCommand(encodeGenerated(whole))->region.has_value());
}

TEST(CommandCodec, NumbersThatMakeNoSenseAreTakenSoThatTheyCanBeAnswered) {
  auto odd = someCommand();
  odd.region[2] = std::nan("");
  odd.resolution = -1e300;
  odd.command = 99;
  const auto command = decodeCommand(encodeGenerated(odd));
  ASSERT_TRUE(command) << command.error;
  EXPECT_TRUE(std::isnan((*command->region)[2]));
  EXPECT_EQ(static_cast<int>(command->kind), 99);
}

TEST(CommandCodec, RefusesWhatIsNoCommand) {
  Message bytes = encodeGenerated(someCommand());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_NE(decodeCommand(Bytes(bytes).first(size)).error, "") << size;
  }
  bytes.push_back(0);
  EXPECT_EQ(decodeCommand(bytes).error, "surplus bytes");
  EXPECT_EQ(decodeCommand(encodePose(1, Pose::Identity())).error, "foreign fingerprint");
  auto chatty = someCommand();
  chatty.client = std::string(300, 'x');
  EXPECT_NE(decodeCommand(encodeGenerated(chatty)).error, "");
}

TEST(CommandCodec, AReplyIsWhatTheGeneratedTypeReads) {
  CommandReply reply;
  reply.utime_us = 1, reply.client = "nav", reply.request_id = 2, reply.kind = CommandKind::kPublishOctomap;
  reply.ok = true, reply.text = "sent", reply.revision = 3, reply.ms = 4.5;
  const auto read = decodeGenerated<hgg::command_reply_t>(encodeCommandReply(reply));
  EXPECT_EQ(read.utime, 1);
  EXPECT_EQ(read.client, "nav");
  EXPECT_EQ(read.request_id, 2);
  EXPECT_EQ(read.command, hgg::command_t::PUBLISH_OCTOMAP);
  EXPECT_EQ(read.ok, 1);
  EXPECT_EQ(read.text, "sent");
  EXPECT_EQ(read.revision, 3);
  EXPECT_EQ(read.ms, 4.5);
}

}  // namespace
}  // namespace hgg::ground_codec_test
