#include "publish/ground_publisher.h"

#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <cmath>
#include <sstream>

#include "region/regions.h"
#include "small_world.h"
#include "traversability/grid_layers.h"

namespace hgg::ground_publisher_test {
namespace {

constexpr Micros kSecond_us = 1'000'000;

/// What comes out. The thread writes grids and trees; they are read after settle(), which waits for it.
struct Listener {
  std::vector<GroundGrid> grids;
  std::vector<OctomapBytes> octomaps;
  std::vector<CommandReply> replies;
  std::vector<RegionsUpdate> regions;

  Sink sink() {
    Sink sink;
    sink.ground = [this](const GroundGrid& grid) { grids.push_back(grid); };
    sink.octomap = [this](const OctomapBytes& octomap) { octomaps.push_back(octomap); };
    sink.reply = [this](const CommandReply& reply) { replies.push_back(reply); };
    return sink;
  }
};

Config configOf(double grid_rate, double octomap_rate) {
  Config config;
  config.traversability.publish_rate = grid_rate;
  config.traversability.octomap_rate = octomap_rate;
  config.traversability.publish_size = 10;
  return config;
}

class GroundPublisherTest : public ::testing::Test {
 protected:
  void drive(Mapper& mapper, GroundPublisher& publisher, int frames) {
    for (const int end = next_ + frames; next_ < end; ++next_) {
      const auto odometry = SmallWorld::odometry(next_);
      last_ = mapper.step({odometry.utime_us, odometry.T_odom_body, SmallWorld::points(next_)});
      publisher.follow(last_);
    }
  }
  /// Frames that change nothing, until every part of the grid has had its turn.
  void rest(GroundPublisher& publisher, Micros now_us) {
    for (int frame = 0; frame < 2 * GroundMaker::kTurns; ++frame) {
      publisher.follow(last_);
      publisher.tick(now_us);
      publisher.settle(now_us);
    }
    publisher.follow(last_);
  }

  CommandReply ask(GroundPublisher& publisher, CommandKind kind, std::optional<std::array<double, 4>> region,
                   double resolution = 0, double reference_z = 0) {
    Command command;
    command.client = "test", command.request_id = ++request_;
    command.kind = kind, command.region = region, command.resolution = resolution, command.reference_z = reference_z;
    const std::size_t before = listener_.replies.size();
    publisher.ask(command);
    publisher.settle(0);
    EXPECT_EQ(listener_.replies.size(), before + 1) << "each command is answered";
    EXPECT_EQ(listener_.replies.back().request_id, request_);
    return listener_.replies.back();
  }

  Listener listener_;
  int next_ = 0;
  StepReport last_;
  std::int64_t request_ = 0;
};

/// The grid of the map as it is, as GroundGrid has it.
void expectGridOf(const Mapper& mapper, const GroundGrid& grid) {
  const GridRegion region{grid.x, grid.y, grid.x + grid.width * grid.resolution,
                          grid.y + grid.height * grid.resolution};
  const auto shape = gridShape(region, grid.resolution);
  const GridLayers expected =
      layersOf(buildCostGrid(mapper.map(), *shape, mapper.config().traversability), grid.reference_z);
  EXPECT_EQ(grid.cost, expected.cost);
  ASSERT_EQ(grid.layers.size(), expected.layers.size());
  EXPECT_EQ(grid.layers[0].name, "height");
  for (std::size_t k = 0; k < grid.layers[0].values.size(); ++k) {
    const float a = grid.layers[0].values[k], b = expected.layers[0].values[k];
    ASSERT_TRUE(a == b || (std::isnan(a) && std::isnan(b))) << k;
  }
}

TEST_F(GroundPublisherTest, TheGridAroundTheRobotIsThatOfTheMapOnceAllHadTheirTurn) {
  Mapper mapper(configOf(1, 0), ClassTable::builtin());
  GroundPublisher publisher(mapper, {listener_.sink()});
  for (int second = 1; second <= 3; ++second) {
    drive(mapper, publisher, 3);
    if (second > 1) {  // the first one is made as a whole
      rest(publisher, second * kSecond_us - 1);
      ASSERT_EQ(listener_.grids.size(), static_cast<std::size_t>(second - 1)) << "each frame is followed, none is due";
    }
    publisher.tick(second * kSecond_us);
    publisher.settle(second * kSecond_us);
    ASSERT_EQ(listener_.grids.size(), static_cast<std::size_t>(second));
    const GroundGrid& grid = listener_.grids.back();
    EXPECT_EQ(grid.utime_us, SmallWorld::timeOf(next_ - 1));
    EXPECT_EQ(grid.revision, mapper.map().revision());
    EXPECT_NEAR(grid.x + 5, next_ - 1, 1.01) << "in steps of 2 m";
    EXPECT_EQ(grid.width, 100);
    EXPECT_NEAR(grid.reference_z, -1.5, 0.1);
    expectGridOf(mapper, grid);
  }
  EXPECT_TRUE(listener_.octomaps.empty());
  EXPECT_TRUE(listener_.replies.empty());
}

TEST_F(GroundPublisherTest, NoGridComesBeforeItsTimeNorWithoutANewFrame) {
  Mapper mapper(configOf(2, 0), ClassTable::builtin());
  GroundPublisher publisher(mapper, {listener_.sink()});
  publisher.tick(0);
  publisher.settle(0);
  EXPECT_TRUE(listener_.grids.empty()) << "nothing was seen yet";
  drive(mapper, publisher, 2);
  for (const Micros now_us : {0, 100'000, 400'000}) {
    publisher.tick(now_us);
    publisher.settle(now_us);
    EXPECT_EQ(listener_.grids.size(), 1U) << now_us;
  }
  publisher.tick(kSecond_us);
  publisher.settle(kSecond_us);
  EXPECT_EQ(listener_.grids.size(), 1U) << "the same frame again";
  drive(mapper, publisher, 1);
  publisher.tick(kSecond_us);
  publisher.settle(kSecond_us);
  EXPECT_EQ(listener_.grids.size(), 2U);
}

TEST_F(GroundPublisherTest, RegionsComeEveryFiveSecondsWhileFramesDo) {
  Mapper mapper(configOf(0, 0), ClassTable::builtin());
  Sink sink;
  sink.regions = [this](const RegionsUpdate& update) { listener_.regions.push_back(update); };
  sink.reply = [this](const CommandReply& reply) { listener_.replies.push_back(reply); };
  GroundPublisher publisher(mapper, {sink});
  std::size_t expected = 0;
  for (int second = 0; second <= 10; ++second) {
    drive(mapper, publisher, 1);
    publisher.tick(second * kSecond_us);
    publisher.settle(second * kSecond_us);
    expected += second % 5 == 0 ? 1 : 0;
    ASSERT_EQ(listener_.regions.size(), expected) << second;
  }
  const RegionsUpdate& last = listener_.regions.back();
  EXPECT_EQ(last.utime_us, SmallWorld::timeOf(next_ - 1));
  EXPECT_EQ(last.revision, mapper.map().revision());
  const Regions found = findRegions(mapper.map());
  ASSERT_EQ(last.found.regions.size(), found.regions.size());
  ASSERT_FALSE(found.regions.empty());
  for (std::size_t k = 0; k < found.regions.size(); ++k) {
    EXPECT_EQ(last.found.regions[k].objects, found.regions[k].objects);
    EXPECT_EQ(last.found.regions[k].name, found.regions[k].name);
  }
  EXPECT_FALSE(ask(publisher, CommandKind::kPublishTraversability, std::nullopt).ok) << "nobody takes it";
}

TEST_F(GroundPublisherTest, ARateOfZeroPublishesOnCommandOnly) {
  Mapper mapper(configOf(0, 0), ClassTable::builtin());
  GroundPublisher publisher(mapper, {listener_.sink()});
  drive(mapper, publisher, 5);
  publisher.tick(kSecond_us);
  publisher.settle(kSecond_us);
  EXPECT_TRUE(listener_.grids.empty() && listener_.octomaps.empty());
  const CommandReply reply = ask(publisher, CommandKind::kPublishTraversability, {{-2, -2, 6, 3}}, 0.2, -1.4);
  EXPECT_TRUE(reply.ok) << reply.text;
  EXPECT_EQ(reply.utime_us, SmallWorld::timeOf(4));
  EXPECT_EQ(reply.revision, mapper.map().revision());
  ASSERT_EQ(listener_.grids.size(), 1U);
  EXPECT_EQ(listener_.grids[0].width, 40);
  EXPECT_EQ(listener_.grids[0].resolution, 0.2);
  EXPECT_EQ(listener_.grids[0].reference_z, -1.4);
  expectGridOf(mapper, listener_.grids[0]);
}

TEST_F(GroundPublisherTest, OctomapsComeAtTheirRateAndAreReadByOctomap) {
  Mapper mapper(configOf(0, 1), ClassTable::builtin());
  GroundPublisher publisher(mapper, {listener_.sink()});
  drive(mapper, publisher, 5);
  publisher.tick(kSecond_us);
  publisher.settle(kSecond_us);
  EXPECT_TRUE(ask(publisher, CommandKind::kPublishOctomap, std::nullopt, 0.4).ok);
  ASSERT_EQ(listener_.octomaps.size(), 2U);
  for (const OctomapBytes& octomap : listener_.octomaps) {
    std::istringstream in(octomap.bytes);
    octomap::OcTree tree(1);
    ASSERT_TRUE(tree.readBinary(in));
    EXPECT_GT(tree.size(), 100U);
    EXPECT_EQ(octomap.utime_us, SmallWorld::timeOf(4));
  }
}

TEST_F(GroundPublisherTest, BadCommandsAreAnsweredWithTheReason) {
  Mapper mapper(configOf(0, 0), ClassTable::builtin());
  GroundPublisher publisher(mapper, {listener_.sink()});
  for (const CommandKind kind : {CommandKind::kPublishTraversability, CommandKind::kPublishOctomap}) {
    EXPECT_EQ(ask(publisher, kind, std::nullopt).text, "the map is empty");
  }
  drive(mapper, publisher, 3);
  const double nan = std::nan("");
  for (const CommandKind kind : {CommandKind::kPublishTraversability, CommandKind::kPublishOctomap}) {
    const auto text = [&](std::array<double, 4> region, double resolution) {
      const CommandReply reply = ask(publisher, kind, region, resolution);
      EXPECT_FALSE(reply.ok);
      return reply.text;
    };
    EXPECT_NE(text({-1, -1, nan, 1}, 0).find("no place in a map"), std::string::npos);
    EXPECT_NE(text({-1, -1, 1e300, 1}, 0).find("no place in a map"), std::string::npos);
    EXPECT_NE(text({2, -1, -2, 1}, 0).find("is empty"), std::string::npos);
    EXPECT_NE(text({900, 900, 910, 910}, 0).find("outside the map"), std::string::npos);
    EXPECT_NE(text({-1, -1, 1, 1}, 1e-9).find("resolution"), std::string::npos);
    EXPECT_NE(text({-1, -1, 1, 1}, -1).find("resolution"), std::string::npos);
    EXPECT_NE(text({-1, -1, 1, 1}, nan).find("resolution"), std::string::npos);
  }
  const CommandReply too_large =
      ask(publisher, CommandKind::kPublishTraversability, {{-900'000, -900'000, 900'000, 900'000}});
  EXPECT_FALSE(too_large.ok);
  EXPECT_NE(too_large.text.find("smaller region"), std::string::npos) << too_large.text;
  EXPECT_TRUE(listener_.grids.empty() && listener_.octomaps.empty());
}

TEST_F(GroundPublisherTest, ACommandAskedTwiceIsCarriedOutOnce) {
  Mapper mapper(configOf(0, 0), ClassTable::builtin());
  GroundPublisher publisher(mapper, {listener_.sink()});
  drive(mapper, publisher, 3);
  Command command;
  command.client = "test", command.request_id = 5, command.kind = CommandKind::kPublishTraversability;
  command.region = {{-2, -2, 2, 2}};
  publisher.ask(command);
  publisher.ask(command);
  publisher.settle(0);
  publisher.ask(command);
  EXPECT_EQ(listener_.grids.size(), 1U);
  ASSERT_EQ(listener_.replies.size(), 2U);
  EXPECT_TRUE(listener_.replies[0].ok && listener_.replies[1].ok);
}

TEST_F(GroundPublisherTest, WithoutASinkForThemCommandsAreRefused) {
  Mapper mapper(configOf(1, 1), ClassTable::builtin());
  Sink only_replies;
  only_replies.reply = listener_.sink().reply;
  GroundPublisher publisher(mapper, {only_replies});
  drive(mapper, publisher, 2);
  EXPECT_FALSE(ask(publisher, CommandKind::kPublishTraversability, std::nullopt).ok);
}

}  // namespace
}  // namespace hgg::ground_publisher_test
