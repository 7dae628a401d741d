#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "sim/scene.h"

namespace hgg {

/// The robot is carried to another place of its tour, and drives on from there.
struct Kidnap {
  double time = 0;               // s from the start
  std::optional<double> metres;  // to a place it has been at, this far away; default: 5 to 60 m; or
  std::optional<int> frame;      // to where it is at this frame of the tour
};

/// How odometry takes it.
enum class CarriedOdometry {
  kGoesOn,    // as if the robot had stood still
  kRestarts,  // at zero
  kFollows,   // the true motion, as an undisturbed drive would have reported it
};

/// s it takes to be carried.
constexpr double kCarrySeconds = 3.0;

/// SECONDS, SECONDS:METRES or SECONDS@FRAME.
Result<Kidnap> parseKidnap(const std::string& text);

/// The scene with another tour: up to `kidnap.time` as before, then carried, then on from the other place to the old
/// end. The world's own time goes on. `metres` takes one of the places the robot has been at, by the seed; an error
/// where there is none so far away.
Result<Scene> kidnapped(Scene scene, const Kidnap& kidnap, double rate_hz, std::uint64_t seed);

/// What odometry feels of poses: being carried is not motion. `times` are the poses'.
std::vector<Pose> withoutCarry(const std::vector<Pose>& poses, const std::vector<double>& times,
                               const std::optional<Carried>& carried);
/// The opposite: `felt` moved by as much as `poses` are while carried.
std::vector<Pose> withCarry(const std::vector<Pose>& felt, const std::vector<Pose>& poses,
                            const std::vector<double>& times, const std::optional<Carried>& carried);

}  // namespace hgg
