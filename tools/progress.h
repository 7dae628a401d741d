#pragma once

#include <functional>
#include <string>

#include "cli/progress_bar.h"

namespace hgg {

/// Called after each frame with the frames done and their total.
using Progress = std::function<void(std::size_t done, std::size_t total)>;

/// Shows progress on a bar, which must outlive it.
inline Progress onBar(ProgressBar& bar) {
  return [&bar](std::size_t done, std::size_t total) {
    bar.show(static_cast<double>(done) / static_cast<double>(total), std::to_string(done) + " frames");
    if (done == total) {
      bar.finish();
    }
  };
}

}  // namespace hgg
