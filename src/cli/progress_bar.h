#pragma once

#include <chrono>
#include <string>

namespace hgg {

/// A bar with share, note and time left on stderr when that is a terminal; silence otherwise. For main functions.
class ProgressBar {
 public:
  explicit ProgressBar(std::string what);
  /// share 0..1; redraws at most ten times a second.
  void show(double share, const std::string& note);
  /// Ends the line.
  void finish();

 private:
  using Clock = std::chrono::steady_clock;
  std::string what_;
  bool terminal_;
  bool drawn_ = false;
  Clock::time_point start_ = Clock::now(), last_{};
};

}  // namespace hgg
