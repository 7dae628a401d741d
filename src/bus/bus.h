#pragma once

#include <lcm/lcm.h>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "config.h"
#include "core/result.h"
#include "core/types.h"

namespace hgg {

struct RawMessage {
  Micros arrival_us = 0;  // of Bus::now_us()
  std::vector<std::uint8_t> bytes;
};

/// A message of one of the channels that were asked for beside those of the config.
struct SideMessage {
  std::string channel;
  Micros arrival_us = 0;
  std::vector<std::uint8_t> bytes;
};

/// What came in since the last look.
struct Inbox {
  std::vector<RawMessage> odometry;  // in order of arrival
  std::optional<RawMessage> cloud;   // the newest
  std::vector<SideMessage> sides;    // in order of arrival; of each channel the newest few
  std::vector<RawMessage> commands;  // in order of arrival; those beyond a bound are lost, and their senders ask again
  std::vector<RawMessage> queries;   // likewise
  std::int64_t clouds_replaced = 0;  // older ones that nobody took
  std::int64_t odometry_lost = 0;    // oldest ones, when nobody took them for long
};

/// A live LCM connection. A thread of its own receives, so that a busy mapper never makes LCM's queues grow: of the
/// clouds it keeps the newest, of odometry everything (bounded). Nothing is decoded here.
class Bus {
 public:
  /// `side_channels`: of other sensors.
  static Result<std::unique_ptr<Bus>> open(const LcmConfig& lcm, const std::vector<std::string>& side_channels = {});
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;
  ~Bus();

  /// Waits until something came in, at most `timeout`, and takes it.
  Inbox take(std::chrono::milliseconds timeout);
  /// False when the message could not be sent (too large, no route).
  bool publish(const std::string& channel, std::span<const std::uint8_t> message);

  /// The clock of arrival times: monotonic, so that setting the wall clock disturbs nothing.
  static Micros now_us();

 private:
  struct LcmCloser {
    void operator()(lcm_t* lcm) const;
  };

  Bus() = default;
  static void onOdometry(const lcm_recv_buf_t* message, const char* channel, void* self);
  static void onCommand(const lcm_recv_buf_t* message, const char* channel, void* self);
  static void onQuery(const lcm_recv_buf_t* message, const char* channel, void* self);
  static void onCloud(const lcm_recv_buf_t* message, const char* channel, void* self);
  static void onSide(const lcm_recv_buf_t* message, const char* channel, void* self);
  bool subscribe(const LcmConfig& lcm, const std::vector<std::string>& side_channels);
  void receive(const std::stop_token& stop);
  void keep(const lcm_recv_buf_t& message, std::vector<RawMessage> Inbox::*requests, std::size_t most_bytes);
  bool hasNews() const {
    return inbox_.cloud || !inbox_.sides.empty() || !inbox_.commands.empty() || !inbox_.queries.empty() ||
           !odometry_.empty();
  }

  std::unique_ptr<lcm_t, LcmCloser> lcm_;
  std::mutex mutex_;  // guards what follows
  std::condition_variable news_;
  Inbox inbox_;  // without odometry
  std::deque<RawMessage> odometry_;
  std::vector<std::uint8_t> spare_;  // the receive thread's own: a cloud is copied here, then swapped in
  std::jthread thread_;              // last: joined before anything above goes
};

/// What the kernel allows of UDP receive buffers, bytes; 0 where it does not say.
struct SocketLimits {
  std::int64_t rmem_max = 0, rmem_default = 0;
};
SocketLimits readSocketLimits();

/// A warning with its cure when the receive buffer that `url` will get holds less than two clouds of 2 MB; empty when
/// it is large enough.
std::string receiveBufferWarning(const std::string& url, const SocketLimits& limits);

}  // namespace hgg
