#include "stats.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

namespace hgg {
namespace {

constexpr double kBinGrowth = 1.005;
constexpr double kSmallest = 1e-3;  // values below share the first bin

double peakResidentMegabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

double rounded(double ms) { return std::round(ms * 1000) / 1000; }

nlohmann::ordered_json summary(const Distribution& d) {
  return {{"p50", rounded(d.quantile(0.5))},
          {"p90", rounded(d.quantile(0.9))},
          {"p99", rounded(d.quantile(0.99))},
          {"max", rounded(d.max())},
          {"mean", rounded(d.mean())}};
}

nlohmann::ordered_json toJson(const LoopRecord& loop) {
  std::vector<double> rows;
  for (Eigen::Index k = 0; k < 12; ++k) {
    rows.push_back(loop.T_before_now.matrix()(k / 4, k % 4));
  }
  return {{"before_us", loop.before_us},
          {"now_us", loop.now_us},
          {"accepted", loop.accepted},
          {"score", rounded(loop.score)},
          {"deviations", rounded(loop.deviations)},
          {"T_before_now", rows},
          {"reason", loop.reason}};
}

nlohmann::ordered_json toJson(const RigCounts& rig) {
  const LabelCounts& l = rig.labels;
  return {{"points", l.points},   {"labelled", l.labelled},  {"seen", l.seen},     {"hidden", l.hidden},
          {"border", l.border},   {"regained", l.regained},  {"unsure", l.unsure}, {"no_class", l.no_class},
          {"foreign", l.foreign}, {"troubles", rig.troubles}};
}

}  // namespace

void Distribution::add(double value) {
  const double steps = std::log(std::max(value, kSmallest) / kSmallest) / std::log(kBinGrowth);
  const auto bin = static_cast<std::size_t>(steps);
  bins_.resize(std::max(bins_.size(), bin + 1));
  ++bins_[bin];
  ++count_;
  sum_ += value;
  max_ = std::max(max_, value);
}

double Distribution::quantile(double q) const {
  const double wanted = q * static_cast<double>(count_);
  double below = 0;
  for (std::size_t bin = 0; bin < bins_.size(); ++bin) {
    below += bins_[bin];
    if (bins_[bin] > 0 && below >= wanted) {
      return std::min(max_, kSmallest * std::pow(kBinGrowth, static_cast<double>(bin) + 0.5));
    }
  }
  return max_;
}

void FrameCurve::add(double value) {
  const auto is_full = [&] { return bins_.empty() || bins_.back().count == bin_width_; };
  if (bins_.size() == max_bins_ && is_full()) {
    halve();
  }
  if (is_full()) {
    bins_.emplace_back();
  }
  Bin& bin = bins_.back();
  bin.max = bin.count == 0 ? value : std::max(bin.max, value);
  bin.sum += value;
  ++bin.count;
  bin.last_frame = ++frames_;
}

void FrameCurve::halve() {
  for (std::size_t k = 0; 2 * k < bins_.size(); ++k) {
    const Bin& a = bins_[2 * k];
    const Bin b = 2 * k + 1 < bins_.size() ? bins_[2 * k + 1] : Bin{a.last_frame, 0, 0, a.max};
    bins_[k] = {b.last_frame, a.count + b.count, a.sum + b.sum, std::max(a.max, b.max)};
  }
  bins_.resize((bins_.size() + 1) / 2);
  bin_width_ *= 2;
}

void TrackingCounts::add(const StepReport& report) {
  recovered += report.tracking == Tracking::kRecovered ? 1 : 0;
  doubtful += report.tracking == Tracking::kDoubtful || report.tracking == Tracking::kLost ? 1 : 0;
  apart += report.fragment != 0 ? 1 : 0;
  fragment = report.fragment;
  if (report.odometry_fault != OdometryFault::kNone) {
    ++odometry_faults[codeOf(report.odometry_fault)];
  }
}

void RunStats::add(const FrameTiming& timing, double map_mb) {
  frame_ms_.add(timing.frame_ms);
  time_.add(timing.frame_ms);
  for (const auto& [name, ms] : timing.stage_ms) {
    stage_ms_[name].add(ms);
  }
  if (frames_++ % sample_every_ != 0) {
    return;
  }
  memory_.push_back({frames_, map_mb, residentMegabytes()});
  if (memory_.size() >= kCurvePoints) {  // thin out to every second sample
    for (std::size_t k = 0; 2 * k < memory_.size(); ++k) {
      memory_[k] = memory_[2 * k];
    }
    memory_.resize((memory_.size() + 1) / 2);
    sample_every_ *= 2;
  }
}

std::string RunStats::json(const RunCounts& c, const Map& map, const LoopCloser& loops) const {
  nlohmann::ordered_json j;
  j["frames"] = c.frames;
  j["dropped"] = c.drops.total();
  j["dropped_by_reason"] = {{"busy", c.drops.busy}, {"odometry", c.drops.odometry}, {"invalid", c.drops.invalid}};
  j["drop_causes"] = c.drops.causes;
  j["odometry"] = {{"samples", c.odometry_samples},
                   {"rejected", c.odometry_rejected},
                   {"out_of_line", c.odometry_outliers},
                   {"begun_anew", c.odometry_anew},
                   {"interval_s", static_cast<double>(c.odometry_interval_us) * 1e-6},
                   {"longest_gap_s", static_cast<double>(c.odometry_gap_us) * 1e-6}};
  j["tracking"] = {{"recovered", tracking_.recovered},
                   {"doubtful", tracking_.doubtful},
                   {"apart", tracking_.apart},
                   {"fragment", tracking_.fragment}};
  j["odometry_faults"] = tracking_.odometry_faults;
  j["odometry_delay_s"] = rounded(c.odometry_delay_s);
  j["restarts"] = c.restarts;
  j["oddities"] = c.oddities;
  j["unknown_labels"] = c.unknown_labels;
  j["nonfinite_points"] = c.nonfinite_points;
  if (c.skewed > 0) {
    j["skewed"] = c.skewed;
  }
  if (c.rig) {
    j["rig"] = toJson(*c.rig);
  }
  j["frame_ms"] = summary(frame_ms_);
  j["stage_ms"] = nlohmann::ordered_json::object();
  for (const auto& [name, distribution] : stage_ms_) {
    j["stage_ms"][name] = summary(distribution);
  }
  j["peak_rss_mb"] = std::round(peakResidentMegabytes() * 10) / 10;
  j["map_mb"] = std::round(map.megabytes() * 1000) / 1000;
  j["objects"] = map.confirmedCount();
  j["candidates"] = map.nodes().size() - map.confirmedCount();
  j["leaves"] = map.leafCount();
  j["keyframes"] = map.keyframes().poses().size();
  j["loops_accepted"] = loops.accepted();
  j["loops_rejected"] = loops.rejected();
  j["loops"] = nlohmann::ordered_json::array();
  for (const LoopRecord& loop : loops.records()) {
    j["loops"].push_back(toJson(loop));
  }
  j["memory"] = nlohmann::ordered_json::array();
  for (const MemorySample& m : memory_) {
    j["memory"].push_back({{"frame", m.frame},
                           {"map_mb", std::round(m.map_mb * 1000) / 1000},
                           {"rss_mb", std::round(m.rss_mb * 10) / 10}});
  }
  j["time"] = nlohmann::ordered_json::array();
  for (const FrameCurve::Bin& bin : time_.bins()) {
    j["time"].push_back({{"frame", bin.last_frame}, {"mean_ms", rounded(bin.mean())}, {"max_ms", rounded(bin.max)}});
  }
  return j.dump(1) + "\n";
}

double residentMegabytes() {
  std::ifstream statm("/proc/self/statm");
  double total_pages = 0, resident_pages = 0;
  statm >> total_pages >> resident_pages;
  return resident_pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1024.0 * 1024.0);
}

}  // namespace hgg
