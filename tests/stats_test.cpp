#include "stats.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "map/test_map.h"

namespace hgg::stats_test {
namespace {

using Json = nlohmann::ordered_json;

/// Smallest value that at least a share q of the values do not exceed.
double quantileBySorting(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  const auto rank = static_cast<std::size_t>(std::ceil(q * static_cast<double>(values.size())));
  return values[std::max<std::size_t>(rank, 1) - 1];
}

void expectQuantiles(const std::vector<double>& values) {
  Distribution d;
  double sum = 0;
  for (const double v : values) {
    d.add(v);
    sum += v;
  }
  for (const double q : {0.0, 0.01, 0.5, 0.9, 0.99, 1.0}) {
    const double expected = quantileBySorting(values, q);
    EXPECT_NEAR(d.quantile(q), expected, 0.005 * expected) << "q " << q << " of " << values.size();
  }
  EXPECT_NEAR(d.mean(), sum / static_cast<double>(values.size()), 1e-9 * sum);
  EXPECT_EQ(d.max(), *std::max_element(values.begin(), values.end()));
}

TEST(Distribution, QuantilesEqualThoseOfSorting) {
  std::mt19937 random(1);
  for (const int n : {1, 2, 3, 10, 100, 5000}) {
    std::vector<double> flat, skewed, wide;
    for (int k = 0; k < n; ++k) {
      flat.push_back(uniform(random, 10, 40));
      skewed.push_back(20 * std::exp(std::normal_distribution<double>(0, 0.5)(random)));
      wide.push_back(std::exp(uniform(random, std::log(0.002), std::log(1e6))));
    }
    expectQuantiles(flat);
    expectQuantiles(skewed);
    expectQuantiles(wide);
  }
}

TEST(Distribution, OfEqualValuesIsThatValueAndNeverAboveTheMaximum) {
  Distribution d;
  for (int k = 0; k < 100; ++k) {
    d.add(17.3);
  }
  EXPECT_NEAR(d.quantile(0.5), 17.3, 0.005 * 17.3);
  EXPECT_LE(d.quantile(1), d.max());
}

TEST(Distribution, OfNothingIsZero) {
  const Distribution d;
  EXPECT_EQ(d.quantile(0.5), 0);
  EXPECT_EQ(d.mean(), 0);
  EXPECT_EQ(d.max(), 0);
}

TEST(Distribution, TakesZeroAndValuesBelowItsResolution) {
  Distribution d;
  for (const double v : {0.0, 1e-9, 5e-4, 5e-4}) {
    d.add(v);
  }
  EXPECT_LE(d.quantile(0.5), 1.01e-3);
  EXPECT_LE(d.quantile(1), 1.01e-3);
}

Json statsOf(const RunStats& stats, const RunCounts& counts, const Map& map) {
  return Json::parse(stats.json(counts, map, LoopCloser({}, {}, LoopTiming::kFixed)));
}

TEST(RunStats, JsonHasTheDocumentedKeys) {
  std::mt19937 random(2);
  MapNode car = nodeAt(10, Vec3(0, 0, 0));
  car.geometry = shareLeaves(Leaves(5, randomLeaf(random)));
  const Map map = mapOf({car, nodeAt(10, Vec3(5, 0, 0))});
  RunStats stats;
  stats.add({30, {{"decode", 5}, {"creation", 20}, {"update", 4}}}, 0.5);
  stats.add({10, {{"decode", 1}, {"creation", 8}, {"update", 1}}}, 0.6);
  RunCounts counts;
  counts.frames = 2, counts.drops = {1, 2, 3, {}}, counts.unknown_labels = 44, counts.nonfinite_points = 55;
  const Json j = statsOf(stats, counts, map);
  EXPECT_EQ(j["frames"], 2);
  EXPECT_EQ(j["dropped"], 6);
  EXPECT_EQ(j["dropped_by_reason"], Json::parse(R"({"busy": 1, "odometry": 2, "invalid": 3})"));
  EXPECT_EQ(j["unknown_labels"], 44);
  EXPECT_EQ(j["nonfinite_points"], 55);
  EXPECT_EQ(j["objects"], 2);
  EXPECT_EQ(j["leaves"], 5);
  EXPECT_EQ(j["keyframes"], 1);
  EXPECT_EQ(j["loops_accepted"], 0);
  EXPECT_EQ(j["loops_rejected"], 0);
  EXPECT_EQ(j["loops"], Json::array());
  EXPECT_GT(j["peak_rss_mb"].get<double>(), 1);
  EXPECT_NEAR(j["map_mb"].get<double>(), map.megabytes(), 1e-3);
  for (const Json& summary :
       {j["frame_ms"], j["stage_ms"]["decode"], j["stage_ms"]["creation"], j["stage_ms"]["update"]}) {
    for (const char* key : {"p50", "p90", "p99", "max", "mean"}) {
      EXPECT_TRUE(summary[key].is_number()) << key;
    }
  }
  EXPECT_EQ(j["stage_ms"].size(), 3U);
  EXPECT_EQ(j["frame_ms"]["max"], 30.0);
  EXPECT_EQ(j["frame_ms"]["mean"], 20.0);
  EXPECT_NEAR(j["frame_ms"]["p50"].get<double>(), 10, 0.05);
}

TEST(RunStats, OfNoFramesIsValidJson) {
  const Json j = statsOf({}, {}, {});
  EXPECT_EQ(j["frames"], 0);
  EXPECT_EQ(j["frame_ms"]["p99"], 0.0);
  EXPECT_EQ(j["stage_ms"], Json::object());
  EXPECT_EQ(j["memory"], Json::array());
}

TEST(RunStats, MemoryCurveIsBoundedEvenAndReachesTheEnd) {
  for (const int frames : {1, 199, 200, 201, 1000, 54321}) {
    RunStats stats;
    for (int k = 0; k < frames; ++k) {
      stats.add({1, {}}, 0.001 * k);
    }
    const Json curve = statsOf(stats, {}, {})["memory"];
    ASSERT_GE(curve.size(), std::min<std::size_t>(99, static_cast<std::size_t>(frames)));
    ASSERT_LE(curve.size(), 200U);
    const std::int64_t step = curve.size() > 1 ? curve[1]["frame"].get<std::int64_t>() - 1 : 1;
    for (std::size_t k = 0; k < curve.size(); ++k) {
      EXPECT_EQ(curve[k]["frame"], 1 + static_cast<std::int64_t>(k) * step) << frames << " frames";
      EXPECT_NEAR(curve[k]["map_mb"].get<double>(),
                  0.001 * static_cast<double>(curve[k]["frame"].get<std::int64_t>() - 1), 1e-9);
      EXPECT_GT(curve[k]["rss_mb"].get<double>(), 0);
    }
    EXPECT_GT(curve.back()["frame"].get<std::int64_t>() + step, frames);
  }
}

TEST(ResidentMegabytes, SeesAnAllocation) {
  const double before = residentMegabytes();
  ASSERT_GT(before, 1);
  std::vector<char> block(64 << 20, 1);
  EXPECT_GT(residentMegabytes(), before + 32);
  EXPECT_EQ(block.back(), 1);
}

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
  const Json json = statsOf(stats, {}, {});
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
}  // namespace hgg::stats_test
