#include "sim/kidnap.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "sim/sensor.h"

namespace hgg {
namespace {

/// Frames this long before the robot is put down are as if it had driven up: a LiDAR's sweep begins before its frame.
constexpr double kRunUp = 0.5;                                    // s
constexpr double kFarEnough = 5.0, kTooFar = 60.0, kAbout = 0.5;  // m

template <typename Number>
std::optional<Number> wholeNumber(const std::string& text) {
  Number value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc() && end == text.data() + text.size() && value >= 0;
  return whole ? std::optional(value) : std::nullopt;
}

/// The tour's time of a place the robot has been at, `lo` to `hi` m from where it is at `time`.
Result<double> placeSeen(const Scene& scene, double time, double lo, double hi, std::uint64_t seed) {
  constexpr double kStep = 0.1;  // s
  const Vec3 here = scene.T_world_body(time).translation();
  double farthest = 0;
  std::vector<double> places;
  for (double u = 0; u <= time; u += kStep) {
    const double apart = (scene.T_world_body(u).translation() - here).norm();
    farthest = std::max(farthest, apart);
    if (apart >= lo && apart <= hi) {
      places.push_back(u);
    }
  }
  if (places.empty()) {
    return Result<double>::fail("--kidnap: until then the robot is nowhere " + std::to_string(std::lround(lo)) +
                                " to " + std::to_string(std::lround(hi)) + " m away from there; the farthest is " +
                                std::to_string(std::lround(farthest)) + " m");
  }
  const double pick = uniform(keyFor(seed, Purpose::kKidnap, 0, 0), 0) * static_cast<double>(places.size());
  return Result<double>::ok(places[static_cast<std::size_t>(pick)]);
}

/// A trajectory over the tour's time as one over the log's.
Trajectory overLogTime(Trajectory tour, const Carried& carried, double place) {
  if (!tour) {
    return tour;
  }
  return [tour = std::move(tour), carried, place](double time) {
    return tour(time <= carried.from ? time : place + std::max(time - carried.until, -kRunUp));
  };
}

/// The first frame after the robot was carried; the number of frames where there is none.
std::size_t firstAfter(const std::vector<double>& times, const Carried& carried) {
  return static_cast<std::size_t>(std::ranges::lower_bound(times, carried.until) - times.begin());
}

}  // namespace

Result<Kidnap> parseKidnap(const std::string& text) {
  const std::size_t mark = text.find_first_of(":@");
  const auto time = wholeNumber<double>(text.substr(0, mark));
  if (mark == std::string::npos && time) {
    return Result<Kidnap>::ok({*time, std::nullopt, std::nullopt});
  }
  if (mark != std::string::npos && time) {
    const std::string where = text.substr(mark + 1);
    const Kidnap kidnap = text[mark] == ':' ? Kidnap{*time, wholeNumber<double>(where), std::nullopt}
                                            : Kidnap{*time, std::nullopt, wholeNumber<int>(where)};
    if (kidnap.metres || kidnap.frame) {
      return Result<Kidnap>::ok(kidnap);
    }
  }
  return Result<Kidnap>::fail(text + ": write SECONDS, SECONDS:METRES or SECONDS@FRAME");
}

Result<Scene> kidnapped(Scene scene, const Kidnap& kidnap, double rate_hz, std::uint64_t seed) {
  if (kidnap.time >= scene.duration) {
    return Result<Scene>::fail("--kidnap: the tour takes only " + std::to_string(std::lround(scene.duration)) + " s");
  }
  const double lo = kidnap.metres ? *kidnap.metres - kAbout : kFarEnough;
  const double hi = kidnap.metres ? *kidnap.metres + kAbout : kTooFar;
  auto place = kidnap.frame ? Result<double>::ok(*kidnap.frame / rate_hz) : placeSeen(scene, kidnap.time, lo, hi, seed);
  if (!place) {
    return Result<Scene>::fail(place.error);
  }
  if (*place >= scene.duration) {
    return Result<Scene>::fail("--kidnap: the tour has no frame " + std::to_string(kidnap.frame.value_or(0)));
  }
  scene.carried = Carried{kidnap.time, kidnap.time + kCarrySeconds};
  scene.T_world_body = overLogTime(std::move(scene.T_world_body), *scene.carried, *place);
  scene.T_odom_body = overLogTime(std::move(scene.T_odom_body), *scene.carried, *place);
  scene.duration = scene.carried->until + scene.duration - *place;
  return Result<Scene>::ok(std::move(scene));
}

std::vector<Pose> withoutCarry(const std::vector<Pose>& poses, const std::vector<double>& times,
                               const std::optional<Carried>& carried) {
  if (!carried) {
    return poses;
  }
  std::vector<Pose> felt{poses.front()};
  const std::size_t after = firstAfter(times, *carried);
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const bool is_carried = times[i] > carried->from && i <= after;
    felt.push_back(is_carried ? felt.back() : felt.back() * (poses[i - 1].inverse() * poses[i]));
  }
  return felt;
}

std::vector<Pose> withCarry(const std::vector<Pose>& felt, const std::vector<Pose>& poses,
                            const std::vector<double>& times, const std::optional<Carried>& carried) {
  const std::size_t after = carried ? firstAfter(times, *carried) : felt.size();
  std::vector<Pose> moved = felt;
  const auto last = std::ranges::upper_bound(times, carried ? carried->from : 0.0) - times.begin() - 1;
  const auto before = static_cast<std::size_t>(std::max<std::ptrdiff_t>(last, 0));
  for (std::size_t i = after; i < felt.size(); ++i) {
    moved[i] = felt[after] * (poses[before].inverse() * poses[after]) * (felt[after].inverse() * felt[i]);
  }
  return moved;
}

}  // namespace hgg
