#pragma once

#include <chrono>
#include <future>
#include <string>

#include "map/map.h"

namespace hgg {

/// Writes the map to a file now and then while mapping goes on, so that a run that is killed loses its last seconds
/// only. Copying the map takes the mapper's thread as long as its nodes are many (leaves are shared); the file is
/// written by another thread of lower priority.
class SnapshotWriter {
 public:
  using Clock = std::chrono::steady_clock;

  /// `every_s`: seconds from one to the next; 0: none are written. They are farther apart where writing one takes more
  /// than a tenth of that.
  SnapshotWriter(std::string path, double every_s) : path_(std::move(path)), every_s_(every_s) {}

  /// Begins to write a copy of the map if one is due. `now` goes up from call to call.
  void offer(const Map& map, Clock::time_point now);
  /// Waits for the one that is being written. Why the last one could not be written; empty when it could.
  std::string finish();

 private:
  struct Written {
    std::string error;
    Clock::duration took{};
  };
  void collect();

  std::string path_;
  double every_s_;
  std::future<Written> writing_;
  Written last_;
  std::string warned_;  // of this error; told once
  Clock::time_point due_{};
  bool is_first_ = true;
};

}  // namespace hgg
