#include "cli/progress_bar.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

namespace hgg {

ProgressBar::ProgressBar(std::string what) : what_(std::move(what)), terminal_(isatty(STDERR_FILENO) != 0) {}

void ProgressBar::show(double share, const std::string& note) {
  const Clock::time_point now = Clock::now();
  if (!terminal_ || now - last_ < std::chrono::milliseconds(100)) {
    return;
  }
  last_ = now;
  drawn_ = true;
  std::string bar(30, ' ');
  std::fill_n(bar.begin(), static_cast<int>(std::clamp(share, 0.0, 1.0) * 30), '#');
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  const std::string left = share > 0.01 ? fmt::format(", {:.0f} s left", elapsed / share - elapsed) : "";
  fmt::print(stderr, "\r{} [{}] {:3.0f} %  {}{}   ", what_, bar, share * 100, note, left);
}

void ProgressBar::finish() {
  if (drawn_) {
    fmt::print(stderr, "\n");
    drawn_ = false;
  }
}

}  // namespace hgg
