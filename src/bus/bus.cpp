#include "bus/bus.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <utility>

#include "core/signals.h"

namespace hgg {
namespace {

constexpr std::size_t kMaxOdometry = 8192;       // messages nobody took; seconds even at 1 kHz
constexpr std::size_t kMaxOdometryBytes = 1024;  // a longer one is no pose; its head is enough for decode to say so
constexpr std::size_t kMaxRequests = 64;         // commands, and queries, that nobody took
constexpr std::size_t kMaxCommandBytes = 1024;   // a longer one is no command
constexpr std::size_t kMaxQueryBytes = 67'000;   // the longest text that is read (bus/codec.h), and what is around it
constexpr int kOdometryQueue = 256;              // within LCM, while the receive thread copies a cloud
constexpr int kCloudQueue = 1;                   // within LCM, which keeps one more
constexpr int kSideQueue = 4;                    // within LCM, of an image channel
constexpr std::ptrdiff_t kMostSides = 8;         // messages of a side channel that nobody took: the oldest goes
constexpr int kPoll_ms = 100;                    // how soon the receive thread sees that it shall end
constexpr std::int64_t kCloudBytes = 2 << 20;    // a cloud of 120k points, with room
constexpr std::int64_t kBufferBytes = 2 * kCloudBytes;

/// A channel as the regular expression that matches it alone: LCM takes subscriptions as expressions.
std::string literal(const std::string& channel) {
  std::string out;
  for (const char c : channel) {
    if (std::string_view("\\^$.|?*+()[]{}").find(c) != std::string_view::npos) {
      out += '\\';
    }
    out += c;
  }
  return out;
}

std::int64_t readNumber(const char* path) {
  std::int64_t value = 0;
  std::ifstream(path) >> value;
  return value;
}

}  // namespace

void Bus::LcmCloser::operator()(lcm_t* lcm) const { lcm_destroy(lcm); }

Result<std::unique_ptr<Bus>> Bus::open(const LcmConfig& lcm, const std::vector<std::string>& side_channels) {
  using Opened = Result<std::unique_ptr<Bus>>;
  std::unique_ptr<Bus> bus(new Bus);
  bus->lcm_.reset(lcm_create(lcm.url.c_str()));
  if (!bus->lcm_) {
    return Opened::fail(
        "cannot open LCM url '" + lcm.url +
        "': it should read like udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304, and a machine without "
        "network needs: ip link set lo up; ip route add 224.0.0.0/4 dev lo");
  }
  if (!bus->subscribe(lcm, side_channels)) {
    return Opened::fail("cannot receive at LCM url '" + lcm.url +
                        "': multicast does not come back to this machine; check the route and the firewall");
  }
  bus->thread_ = std::jthread([b = bus.get()](const std::stop_token& stop) { b->receive(stop); });
  return Opened::ok(std::move(bus));
}

Bus::~Bus() = default;

bool Bus::subscribe(const LcmConfig& lcm, const std::vector<std::string>& side_channels) {
  auto* odometry = lcm_subscribe(lcm_.get(), literal(lcm.odometry).c_str(), &Bus::onOdometry, this);
  auto* cloud = lcm_subscribe(lcm_.get(), literal(lcm.lidar_semantic).c_str(), &Bus::onCloud, this);
  auto* command = lcm_subscribe(lcm_.get(), literal(lcm.command).c_str(), &Bus::onCommand, this);
  auto* query = lcm_subscribe(lcm_.get(), literal(lcm.goal_query).c_str(), &Bus::onQuery, this);
  if (!odometry || !cloud || !command || !query) {
    return false;
  }
  lcm_subscription_set_queue_capacity(odometry, kOdometryQueue);
  lcm_subscription_set_queue_capacity(cloud, kCloudQueue);
  return std::ranges::all_of(side_channels, [&](const std::string& channel) {
    auto* side = lcm_subscribe(lcm_.get(), literal(channel).c_str(), &Bus::onSide, this);
    if (side != nullptr) {
      lcm_subscription_set_queue_capacity(side, kSideQueue);
    }
    return side != nullptr;
  });
}

void Bus::receive(const std::stop_token& stop) {
  leaveSignalsToMainThread();
  while (!stop.stop_requested()) {
    // Fails when the provider is at its end (file://): nothing more to do then but not to spin.
    if (lcm_handle_timeout(lcm_.get(), kPoll_ms) < 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds(kPoll_ms));
    }
  }
}

void Bus::onOdometry(const lcm_recv_buf_t* message, const char* /*channel*/, void* self) {
  auto* bus = static_cast<Bus*>(self);
  const auto* bytes = static_cast<const std::uint8_t*>(message->data);
  {
    const std::lock_guard lock(bus->mutex_);
    bus->odometry_.push_back({now_us(), {bytes, bytes + std::min<std::size_t>(message->data_size, kMaxOdometryBytes)}});
    if (bus->odometry_.size() > kMaxOdometry) {
      bus->odometry_.pop_front();
      ++bus->inbox_.odometry_lost;
    }
  }
  bus->news_.notify_one();
}

void Bus::keep(const lcm_recv_buf_t& message, std::vector<RawMessage> Inbox::*requests, std::size_t most_bytes) {
  const auto* bytes = static_cast<const std::uint8_t*>(message.data);
  {
    const std::lock_guard lock(mutex_);
    std::vector<RawMessage>& kept = inbox_.*requests;
    if (kept.size() < kMaxRequests) {
      kept.push_back({now_us(), {bytes, bytes + std::min<std::size_t>(message.data_size, most_bytes)}});
    }
  }
  news_.notify_one();
}

void Bus::onCommand(const lcm_recv_buf_t* message, const char* /*channel*/, void* self) {
  static_cast<Bus*>(self)->keep(*message, &Inbox::commands, kMaxCommandBytes);
}

void Bus::onQuery(const lcm_recv_buf_t* message, const char* /*channel*/, void* self) {
  static_cast<Bus*>(self)->keep(*message, &Inbox::queries, kMaxQueryBytes);
}

void Bus::onCloud(const lcm_recv_buf_t* message, const char* /*channel*/, void* self) {
  auto* bus = static_cast<Bus*>(self);
  const auto* bytes = static_cast<const std::uint8_t*>(message->data);
  bus->spare_.assign(bytes, bytes + message->data_size);  // the long copy, outside the lock
  {
    const std::lock_guard lock(bus->mutex_);
    if (bus->inbox_.cloud) {
      ++bus->inbox_.clouds_replaced;
    } else {
      bus->inbox_.cloud.emplace();
    }
    bus->inbox_.cloud->arrival_us = now_us();
    bus->inbox_.cloud->bytes.swap(bus->spare_);
  }
  bus->news_.notify_one();
}

void Bus::onSide(const lcm_recv_buf_t* message, const char* channel, void* self) {
  auto* bus = static_cast<Bus*>(self);
  const auto* bytes = static_cast<const std::uint8_t*>(message->data);
  SideMessage side{channel, now_us(), {bytes, bytes + message->data_size}};
  const auto is_same = [&](const SideMessage& other) { return other.channel == side.channel; };
  {
    const std::lock_guard lock(bus->mutex_);
    std::vector<SideMessage>& sides = bus->inbox_.sides;
    if (std::ranges::count_if(sides, is_same) >= kMostSides) {
      sides.erase(std::ranges::find_if(sides, is_same));
    }
    sides.push_back(std::move(side));
  }
  bus->news_.notify_one();
}

Inbox Bus::take(std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  news_.wait_for(lock, timeout, [this] { return hasNews(); });
  Inbox taken = std::exchange(inbox_, {});
  taken.odometry.assign(std::move_iterator(odometry_.begin()), std::move_iterator(odometry_.end()));
  odometry_.clear();
  return taken;
}

bool Bus::publish(const std::string& channel, std::span<const std::uint8_t> message) {
  return lcm_publish(lcm_.get(), channel.c_str(), message.data(), static_cast<unsigned>(message.size())) == 0;
}

Micros Bus::now_us() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::microseconds>(now).count();
}

SocketLimits readSocketLimits() {
  return {readNumber("/proc/sys/net/core/rmem_max"), readNumber("/proc/sys/net/core/rmem_default")};
}

std::string receiveBufferWarning(const std::string& url, const SocketLimits& limits) {
  if (!url.starts_with("udpm://") || limits.rmem_max == 0) {
    return {};
  }
  const std::string key = "recv_buf_size=";
  const auto at = url.find(key);
  const std::int64_t asked =
      at == std::string::npos ? limits.rmem_default : std::strtoll(url.c_str() + at + key.size(), nullptr, 0);
  if (std::min(asked, limits.rmem_max) >= kBufferBytes) {
    return {};
  }
  const std::string need = std::to_string(kBufferBytes);
  std::string cure;
  if (limits.rmem_max < kBufferBytes) {
    cure = "sysctl -w net.core.rmem_max=" + need;
  }
  if (asked < kBufferBytes) {
    cure += (cure.empty() ? "" : ", and ") + key + need + " in the LCM url";
  }
  return "the UDP receive buffer holds " + std::to_string(std::min(asked, limits.rmem_max)) +
         " bytes, less than two clouds of 2 MB: clouds will be lost. Cure: " + cure;
}

}  // namespace hgg
