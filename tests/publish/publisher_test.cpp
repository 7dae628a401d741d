#include "publish/publisher.h"

#include <gtest/gtest.h>

#include <set>
#include <utility>

#include "map/test_map.h"
#include "publish/graph_update.h"
#include "small_world.h"

namespace hgg::publisher_test {
namespace {

constexpr Micros kSecond_us = 1'000'000;

/// A sink that keeps what it is given.
struct Listener {
  std::vector<PoseUpdate> poses;
  std::vector<GraphUpdate> graphs;
  std::vector<Status> statuses;
  std::vector<std::string> warnings;
  std::int64_t unsent = 0;

  Sink sink() {
    return {[this](const PoseUpdate& pose) { poses.push_back(pose); },
            [this](const GraphUpdate& graph) { graphs.push_back(graph); },
            [this](const Status& status) { statuses.push_back(status); },
            [this](const std::string& line) { warnings.push_back(line); }, [this] { return std::exchange(unsent, 0); }};
  }
};

/// A publisher with a listener and a clock that goes when it is told to.
class PublisherTest : public ::testing::Test {
 protected:
  Publisher publisher(std::vector<Sink> sinks) {
    return Publisher(mapper_, std::move(sinks), [this] { return now_us_; });
  }

  /// Lets time pass in ticks of a tenth of a second, with `frames` in each.
  void pass(Publisher& publisher, Micros duration_us, int frames) {
    for (const Micros end_us = now_us_ + duration_us; now_us_ < end_us;) {
      now_us_ += kSecond_us / 10;
      counts_.frames += frames;
      publisher.tick(counts_);
    }
  }

  Mapper mapper_{Config{}, ClassTable::builtin()};
  Listener listener_;
  Micros now_us_ = 77 * kSecond_us;
  RunCounts counts_;
};

TEST_F(PublisherTest, AFrameIsPublishedAsItsPosesAndWhatItChanged) {
  Publisher publisher = this->publisher({listener_.sink()});
  for (int i = 0; i < 3; ++i) {
    const auto odometry = SmallWorld::odometry(i);
    const auto report = mapper_.step({odometry.utime_us, odometry.T_odom_body, SmallWorld::points(i)});
    publisher.publishFrame(report, {});
    ASSERT_EQ(listener_.poses.size(), static_cast<std::size_t>(i + 1));
    EXPECT_EQ(listener_.poses.back().utime_us, SmallWorld::timeOf(i));
    EXPECT_TRUE(listener_.poses.back().T_map_body.isApprox(report.T_map_body));
    EXPECT_TRUE(listener_.poses.back().T_map_odom.isApprox(report.T_map_odom));
    ASSERT_EQ(listener_.graphs.size(), static_cast<std::size_t>(i + 1));
    const GraphUpdate& graph = listener_.graphs.back();
    const GraphUpdate expected = changedGraph(mapper_, report);
    EXPECT_FALSE(graph.complete);
    EXPECT_FALSE(graph.objects.empty());
    EXPECT_EQ(graph.revision, expected.revision);
    EXPECT_EQ(graph.objects.size(), expected.objects.size());
    EXPECT_EQ(graph.edges.size(), expected.edges.size());
  }
  EXPECT_TRUE(listener_.statuses.empty());  // these come by the clock, which stands
}

TEST_F(PublisherTest, WhatALoopMovesIsToldOverTheFramesThatFollow) {
  constexpr NodeId kNodes = 2500;
  std::vector<MapNode> nodes;
  for (NodeId id = 1; id <= kNodes; ++id) {
    nodes.push_back(nodeAt(10, Vec3(static_cast<double>(id), 0, 0)));
    nodes.back().id = id;
  }
  const Mapper mapper(Config{}, ClassTable::builtin(), Map::restore(std::move(nodes), {}, {}, 1));
  Publisher publisher(mapper, {listener_.sink()}, [this] { return now_us_; });
  StepReport loop;
  for (NodeId id = 1; id <= kNodes; ++id) {
    loop.delta.moved.push_back(id);
  }
  publisher.publishFrame(loop, {});
  StepReport next;
  next.delta.changed = {2000, 2400};  // told of as changed, and not again as moved
  publisher.publishFrame(next, {});
  publisher.publishFrame({}, {});
  publisher.publishFrame({}, {});
  ASSERT_EQ(listener_.graphs.size(), 4U);
  EXPECT_EQ(listener_.graphs[0].objects.size(), MoveQueue::kMostAtOnce);
  EXPECT_EQ(listener_.graphs[1].objects.size(), MoveQueue::kMostAtOnce + 2);
  EXPECT_EQ(listener_.graphs[2].objects.size(), 498U);
  EXPECT_TRUE(listener_.graphs[3].objects.empty());
  std::set<NodeId> told;
  for (const GraphUpdate& graph : listener_.graphs) {
    for (const ObjectSummary& object : graph.objects) {
      EXPECT_TRUE(told.insert(object.id).second) << object.id << " twice";
    }
  }
  EXPECT_EQ(told.size(), static_cast<std::size_t>(kNodes));
}

TEST_F(PublisherTest, TheCostOfPublishingIsAStageOfTheFrame) {
  Sink slow = listener_.sink();
  slow.graph = [this](const GraphUpdate&) { now_us_ += 3000; };
  Publisher publisher = this->publisher({slow});
  StepReport report;
  report.utime_us = 123;
  report.source = PoseSource::kOdometry;
  report.degenerate = 2;
  const FrameTiming timing = publisher.publishFrame(report, {10, {{"decode", 10}}});
  const std::vector<std::pair<std::string, double>> expected = {{"decode", 10}, {"publish", 3}};
  EXPECT_EQ(timing.stage_ms, expected);
  EXPECT_DOUBLE_EQ(timing.frame_ms, 13);
  pass(publisher, kSecond_us, 1);
  const Status& status = listener_.statuses.at(0);
  EXPECT_EQ(status.utime_us, 123);
  EXPECT_EQ(status.stage_ms, expected);
  EXPECT_DOUBLE_EQ(status.frame_ms, 13);
  EXPECT_EQ(status.alignment, nameOf(PoseSource::kOdometry));
  EXPECT_EQ(status.degenerate, 2);
}

TEST_F(PublisherTest, StatusComesOnceASecondWithTheRateOfThatSecond) {
  Publisher publisher = this->publisher({listener_.sink()});
  pass(publisher, kSecond_us, 0);
  ASSERT_EQ(listener_.statuses.size(), 1U);
  EXPECT_EQ(listener_.statuses[0].frame_rate, 0);
  counts_.drops = {1, 2, 3, {}};
  counts_.unknown_labels = 4;
  pass(publisher, 5 * kSecond_us, 2);
  ASSERT_EQ(listener_.statuses.size(), 6U);
  const Status& last = listener_.statuses.back();
  EXPECT_DOUBLE_EQ(last.frame_rate, 20);
  EXPECT_EQ(last.frames, 100);
  EXPECT_EQ(last.dropped_busy, 1);
  EXPECT_EQ(last.dropped_odometry, 2);
  EXPECT_EQ(last.dropped_invalid, 3);
  EXPECT_EQ(last.unknown_labels, 4);
}

TEST_F(PublisherTest, AStatusThatComesLateCountsTheRateOverAllThatTime) {
  Publisher publisher = this->publisher({listener_.sink()});
  now_us_ += 4 * kSecond_us;  // one long step
  counts_.frames = 2;
  publisher.tick(counts_);
  ASSERT_EQ(listener_.statuses.size(), 1U);
  EXPECT_DOUBLE_EQ(listener_.statuses[0].frame_rate, 0.5);
}

TEST_F(PublisherTest, TheWholeGraphComesAtOnceAndEveryTenSecondsForThoseWhoJoinLate) {
  std::vector<Micros> times_us;
  Sink sink;
  sink.graph = [&](const GraphUpdate& graph) {
    EXPECT_TRUE(graph.complete);
    EXPECT_EQ(graph.revision, mapper_.map().revision());
    times_us.push_back(now_us_);
  };
  const Micros start_us = now_us_;
  Publisher publisher = this->publisher({sink});
  pass(publisher, 30 * kSecond_us, 1);
  EXPECT_EQ(times_us,
            (std::vector<Micros>{start_us + kSecond_us, start_us + 11 * kSecond_us, start_us + 21 * kSecond_us}));
}

TEST_F(PublisherTest, AWholeGraphThatTakesLongComesSoRarelyThatItTakesTwoPercentOfTheTime) {
  std::vector<Micros> times_us;
  Sink sink;
  sink.graph = [&](const GraphUpdate&) {
    times_us.push_back(now_us_);
    now_us_ += kSecond_us / 2;
  };
  Publisher publisher = this->publisher({sink});
  pass(publisher, 60 * kSecond_us, 1);
  ASSERT_EQ(times_us.size(), 3U);
  EXPECT_EQ(times_us[1] - times_us[0], 25 * kSecond_us);
  EXPECT_EQ(times_us[2] - times_us[1], 25 * kSecond_us);
}

TEST_F(PublisherTest, IdlenessIsSaidAtOnceAndThenOnceAMinute) {
  Publisher publisher = this->publisher({listener_.sink()});
  pass(publisher, kSecond_us, 0);
  ASSERT_EQ(listener_.warnings.size(), 1U);
  EXPECT_EQ(listener_.warnings[0],
            "no frames: clouds on LIDAR_SEMANTIC do not come, odometry on POSE_ODOM does not come");
  pass(publisher, 59 * kSecond_us, 0);
  EXPECT_EQ(listener_.warnings.size(), 1U);
  pass(publisher, kSecond_us, 0);
  EXPECT_EQ(listener_.warnings.size(), 2U);
  pass(publisher, 10 * kSecond_us, 1);
  EXPECT_EQ(listener_.warnings.size(), 2U);
  pass(publisher, kSecond_us, 0);  // said at once again: it is a new silence
  EXPECT_EQ(listener_.warnings.size(), 3U);
}

TEST_F(PublisherTest, IdlenessSaysWhatComesAndWhatDoesNot) {
  Publisher publisher = this->publisher({listener_.sink()});
  counts_.drops.odometry = 3;
  pass(publisher, kSecond_us, 0);
  pass(publisher, kSecond_us, 1);
  counts_.odometry_samples = 9;
  pass(publisher, kSecond_us, 0);
  EXPECT_EQ(listener_.warnings,
            (std::vector<std::string>{"no frames: clouds on LIDAR_SEMANTIC come but are dropped, odometry on POSE_ODOM "
                                      "does not come",
                                      "no frames: clouds on LIDAR_SEMANTIC do not come, odometry on POSE_ODOM comes"}));
}

TEST_F(PublisherTest, ATroubleIsSaidOnceEachTimeItComes) {
  Publisher publisher = this->publisher({listener_.sink()});
  pass(publisher, kSecond_us, 1);
  EXPECT_TRUE(listener_.warnings.empty());
  counts_.decode_errors["cloud: truncated"] = 2;
  counts_.restarts = 1;
  listener_.unsent = 4;
  pass(publisher, 5 * kSecond_us, 1);
  EXPECT_EQ(listener_.warnings, (std::vector<std::string>{"2 messages unreadable: cloud: truncated (2 in all)",
                                                          "time went back: going on from the new time and odometry",
                                                          "4 messages could not be published"}));
  listener_.warnings.clear();
  counts_.decode_errors["cloud: truncated"] = 5;
  counts_.decode_errors["odometry: truncated"] = 1;
  pass(publisher, 5 * kSecond_us, 1);
  EXPECT_EQ(listener_.warnings, (std::vector<std::string>{"3 messages unreadable: cloud: truncated (5 in all)",
                                                          "1 messages unreadable: odometry: truncated (1 in all)"}));
}

TEST_F(PublisherTest, EverySinkGetsWhatItTakesAndLossesOfAllAreSummed) {
  Listener other;
  Publisher publisher = this->publisher({listener_.sink(), Sink{}, other.sink()});
  publisher.publishFrame({}, {});
  listener_.unsent = 1, other.unsent = 2;
  pass(publisher, kSecond_us, 1);
  for (const Listener* listener : {&std::as_const(listener_), &std::as_const(other)}) {
    EXPECT_EQ(listener->poses.size(), 1U);
    EXPECT_EQ(listener->graphs.size(), 2U);  // of the frame, and the whole
    EXPECT_EQ(listener->statuses.size(), 1U);
    EXPECT_EQ(listener->warnings, std::vector<std::string>{"3 messages could not be published"});
  }
}

}  // namespace
}  // namespace hgg::publisher_test
