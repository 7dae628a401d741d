#include "stats.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace hgg {
namespace {

TEST(FrameCurve, HoldsEveryFrameWhileThereIsRoom) {
  FrameCurve curve(4);
  for (const double value : {3.0, 1.0, 2.0}) {
    curve.add(value);
  }
  ASSERT_EQ(curve.bins().size(), 3u);
  EXPECT_EQ(curve.bins()[1].mean(), 1.0);
  EXPECT_EQ(curve.bins()[1].last_frame, 2);
}

TEST(FrameCurve, StaysBoundedWithExactMeansAndMaxima) {
  for (const std::size_t max_bins : {4u, 5u, 7u, 200u}) {
    FrameCurve curve(max_bins);
    for (int frame = 1; frame <= 1000; ++frame) {
      curve.add(frame);
      ASSERT_LE(curve.bins().size(), max_bins);
    }
    std::int64_t before = 0;
    for (const FrameCurve::Bin& bin : curve.bins()) {
      ASSERT_EQ(bin.last_frame, before + bin.count);
      EXPECT_DOUBLE_EQ(bin.mean(), 0.5 * static_cast<double>(before + 1 + bin.last_frame));
      EXPECT_EQ(bin.max, static_cast<double>(bin.last_frame));
      before = bin.last_frame;
    }
    EXPECT_EQ(before, 1000);
    EXPECT_GE(2 * curve.bins().size() + 2, max_bins);
  }
}

TEST(FrameCurve, AllBinsButTheLastHoldTheSameNumber) {
  FrameCurve curve(5);
  for (int frame = 0; frame < 333; ++frame) {
    curve.add(1);
  }
  for (std::size_t k = 0; k + 1 < curve.bins().size(); ++k) {
    EXPECT_EQ(curve.bins()[k].count, curve.bins()[0].count);
  }
}

TEST(RunStats, TimeCurveIsInTheJson) {
  RunStats stats;
  for (int frame = 0; frame < 1000; ++frame) {
    stats.add({frame == 700 ? 50.0 : 2.0, {}}, 1.0);
  }
  const auto json = nlohmann::json::parse(stats.json({}, Map{}));
  ASSERT_LE(json["time"].size(), 200u);
  ASSERT_GE(json["time"].size(), 90u);
  double slowest = 0;
  for (const auto& bin : json["time"]) {
    slowest = std::max(slowest, bin["max_ms"].get<double>());
  }
  EXPECT_EQ(slowest, 50.0);
  EXPECT_EQ(json["time"].back()["frame"], 1000);
  EXPECT_EQ(json["time"][0]["mean_ms"], 2.0);
}

}  // namespace
}  // namespace hgg
