#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "core/types.h"

namespace hgg {

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using FileHandle = std::unique_ptr<std::FILE, FileCloser>;

/// One message of an LCM event log.
struct LogEvent {
  std::int64_t number = 0;
  Micros timestamp_us = 0;  // when it was logged; logs of our tools carry the time of measurement here
  std::string channel;
  std::vector<std::uint8_t> data;
};

/// What a damaged log cost.
struct LogLoss {
  std::int64_t gaps = 0;        // damaged stretches between whole events
  std::int64_t gap_bytes = 0;   // bytes in them
  std::int64_t tail_bytes = 0;  // bytes after the last whole event: the log was cut
};

/// Reads LCM event logs (per event, big-endian: sync u32, number i64, timestamp i64, channel length i32, data length
/// i32, channel, data) of any size with a small window in memory. A damaged stretch is skipped up to the next whole
/// event and counted; only bytes that lie in it are lost.
class LogReader {
 public:
  static Result<LogReader> open(const std::string& path);

  /// nullopt at the end of the log.
  std::optional<LogEvent> next();
  const LogLoss& loss() const { return loss_; }
  /// Share of the file that has been read, 0..1.
  double progress() const;

 private:
  struct Header {
    std::int64_t at = 0, data_at = 0, end = 0;
    std::int64_t number = 0;
    Micros timestamp_us = 0;
    std::string channel;
  };

  LogReader() = default;
  std::span<const std::uint8_t> view(std::int64_t offset, std::int64_t size);
  void fill(std::int64_t offset, std::int64_t size);
  bool hasSyncAt(std::int64_t offset);
  std::int64_t findSync(std::int64_t from, std::int64_t to);
  std::optional<Header> headerAt(std::int64_t offset);
  bool isFollowedWell(const Header& header);
  bool hasWholeEvent(std::int64_t from, std::int64_t to);
  std::optional<Header> findEvent();

  FileHandle file_;
  std::int64_t file_size_ = 0;
  std::int64_t offset_ = 0;  // end of the last event handed out
  std::vector<std::uint8_t> window_;
  std::int64_t window_at_ = 0;
  std::int64_t searched_to_ = 0;  // hasWholeEvent() has looked at everything before this
  std::int64_t whole_at_ = -1;    // the last whole event it found
  LogLoss loss_;
};

/// Writes an LCM event log. The same events give the same bytes.
class LogWriter {
 public:
  static Result<LogWriter> create(const std::string& path);

  /// Each returns an error line, empty when done.
  std::string write(const std::string& channel, Micros timestamp_us, std::span<const std::uint8_t> data);
  std::string close();

 private:
  LogWriter() = default;

  FileHandle file_;
  std::string path_;
  std::int64_t count_ = 0;
};

}  // namespace hgg
