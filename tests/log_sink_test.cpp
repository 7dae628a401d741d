#include "log_sink.h"

#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <sstream>

namespace hgg::log_sink_test {
namespace {

/// What is logged while this lives, as "level text" a line.
class LogCapture {
 public:
  LogCapture() : before_(spdlog::default_logger()) {
    spdlog::set_default_logger(
        std::make_shared<spdlog::logger>("capture", std::make_shared<spdlog::sinks::ostream_sink_mt>(text_)));
    spdlog::set_pattern("%l %v");
  }
  ~LogCapture() { spdlog::set_default_logger(before_); }
  std::string text() const { return text_.str(); }

 private:
  std::ostringstream text_;
  std::shared_ptr<spdlog::logger> before_;
};

Status someStatus() {
  Status status;
  status.frame_rate = 9.96, status.frame_ms = 12.34;
  status.objects = 5, status.leaves = 60, status.map_mb = 1.25, status.rss_mb = 99.6;
  status.dropped_busy = 1, status.dropped_odometry = 2, status.dropped_invalid = 3;
  status.alignment = "aligned";
  return status;
}

TEST(LogSink, ALineAStatus) {
  Status status = someStatus();
  const std::string line =
      "10.0 Hz,  12.3 ms | 5 objects, 60 leaves, map 1.2 MB | dropped: 1 busy, 2 no odometry, 3 invalid | 100 MB | "
      "aligned";
  EXPECT_EQ(statusLine(status), line);
  status.degenerate = 2;
  EXPECT_EQ(statusLine(status), line + " (2 of 6)");
}

TEST(LogSink, LogsWarningsAndStatusesWhileFramesCome) {
  const LogCapture log;
  const Sink sink = logSink();
  Status status = someStatus();
  sink.status(status);
  status.frame_rate = 0;  // why, the publisher warns of
  sink.status(status);
  sink.warning("100 % of {} lost");
  EXPECT_EQ(log.text(), "info " + statusLine(someStatus()) + "\nwarning 100 % of {} lost\n");
}

}  // namespace
}  // namespace hgg::log_sink_test
