#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "frame/frame.h"
#include "frame/stamp_judge.h"

namespace hgg {

/// A pose of odometry, and which stretch of it: stretches are counted up where odometry began anew.
struct OdometryPose {
  Pose T_odom_body = Pose::Identity();
  std::int64_t stretch = 0;
};

/// Why there is no pose for a time.
enum class OdometryMiss : std::uint8_t {
  kAhead,   // samples still to come may give one
  kBefore,  // the odometry begins later
  kGap,     // the samples around it are too far apart
};

/// What became of the samples.
struct OdometryCounts {
  std::int64_t late = 0;      // not newer than the newest
  std::int64_t outliers = 0;  // stamps that those after them spoke against
  std::int64_t anew = 0;      // times it began anew
  std::int64_t rejected() const { return late + outliers; }
};

/// The odometry of the recent past, in ascending time; when full, the oldest sample goes. Stamps are judged by
/// StampJudge. The odometry begins anew where its clock goes back (then everything from before is forgotten) and where
/// it paused for more than kPause_us.
class OdometryBuffer {
 public:
  /// Between samples further apart than `max_gap_us` nothing is interpolated.
  explicit OdometryBuffer(Micros max_gap_us, std::size_t capacity = 8192)
      : max_gap_us_(max_gap_us), capacity_(capacity) {}

  void add(const OdometrySample& sample);
  /// No more will come: what is kept apart is decided.
  void finish();

  /// The pose at `utime_us`: the sample itself where one has that time, else interpolated between its two neighbours
  /// (linear, slerp). nullopt outside the samples and in gaps.
  std::optional<OdometryPose> at(Micros utime_us) const;
  /// The same, and beyond the first and the last sample by up to `reach_us` the pose that the motion between the two
  /// samples there leads to.
  std::optional<OdometryPose> around(Micros utime_us, Micros reach_us) const;
  /// Why at() has none for this time.
  OdometryMiss missAt(Micros utime_us) const;
  /// Time between the samples around `utime_us`, 0 where it has not two.
  Micros gapAround_us(Micros utime_us) const;

  /// Whether it fell silent between two times: for more than a second and five of its usual intervals. Nobody knows
  /// what became of the robot meanwhile.
  bool fellSilent(Micros from_us, Micros to_us) const;

  std::size_t size() const { return samples_.size(); }
  /// Time of the newest sample; nullopt when there is none.
  std::optional<Micros> newest_us() const;
  /// Of those believed, since the beginning.
  std::int64_t believed() const { return believed_; }
  Micros usualInterval_us() const { return judge_.usualInterval_us(); }
  const OdometryCounts& counts() const { return counts_; }

 private:
  struct Entry {
    OdometrySample sample;
    std::int64_t stretch = 0;
  };
  using Iterator = std::deque<Entry>::const_iterator;

  void takeApart();
  void take(const OdometrySample& sample);
  Iterator firstNotBefore(Micros utime_us) const;

  Micros max_gap_us_;
  std::size_t capacity_;
  StampJudge judge_;
  std::optional<OdometrySample> apart_;
  std::deque<Entry> samples_;
  std::int64_t believed_ = 0;
  OdometryCounts counts_;
};

/// The pose a share `s` (0..1) of the way from a to b: translation linear, rotation on the shorter great arc.
Pose interpolate(const Pose& a, const Pose& b, double s);

}  // namespace hgg
