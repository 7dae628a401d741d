#include "bus/log.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <lcm/lcm-cpp.hpp>
#include <random>

#include "tools/scratch.h"

namespace hgg::log_test {
namespace {

using Data = std::vector<std::uint8_t>;

struct Written {
  std::string channel;
  Micros timestamp_us = 0;
  Data data;
  std::int64_t at = 0, end = 0;  // in the file
};

/// Events of random size, some with sync words in their data.
std::vector<Written> randomEvents(int count, std::size_t max_bytes, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Written> events;
  std::int64_t at = 0;
  for (int i = 0; i < count; ++i) {
    Written event{i % 3 == 0 ? "CLOUD" : "POSE", 1000 + i, Data(random() % max_bytes), at, 0};
    for (auto& byte : event.data) {
      byte = static_cast<std::uint8_t>(random());
    }
    if (event.data.size() > 40 && i % 4 == 0) {
      std::memcpy(event.data.data() + 9, "\xED\xA1\xDA\x01", 4);
    }
    event.end = at += 28 + std::ssize(event.channel) + std::ssize(event.data);
    events.push_back(std::move(event));
  }
  return events;
}

void writeLog(const std::string& path, const std::vector<Written>& events) {
  auto log = LogWriter::create(path);
  ASSERT_TRUE(log) << log.error;
  for (const auto& event : events) {
    ASSERT_EQ(log->write(event.channel, event.timestamp_us, event.data), "");
  }
  ASSERT_EQ(log->close(), "");
}

struct Read {
  std::vector<LogEvent> events;
  LogLoss loss;
  double progress = 0;
};

Read readLog(const std::string& path) {
  auto log = LogReader::open(path);
  EXPECT_TRUE(log) << log.error;
  Read out;
  while (auto event = log->next()) {
    out.events.push_back(std::move(*event));
  }
  out.loss = log->loss();
  out.progress = log->progress();
  return out;
}

bool areEqual(const Written& a, const LogEvent& b) {
  return a.channel == b.channel && a.timestamp_us == b.timestamp_us && a.data == b.data;
}

/// Whether `read` is exactly the events of `written` with these indices.
::testing::AssertionResult isExactly(const Read& read, const std::vector<Written>& written,
                                     const std::vector<std::size_t>& indices) {
  if (read.events.size() != indices.size()) {
    return ::testing::AssertionFailure() << read.events.size() << " events, expected " << indices.size();
  }
  for (std::size_t i = 0; i < indices.size(); ++i) {
    if (!areEqual(written[indices[i]], read.events[i])) {
      return ::testing::AssertionFailure() << "event " << i << " is not " << indices[i];
    }
  }
  return ::testing::AssertionSuccess();
}

std::vector<std::size_t> allBut(std::size_t count, std::initializer_list<std::size_t> lost) {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < count; ++i) {
    if (std::find(lost.begin(), lost.end(), i) == lost.end()) {
      out.push_back(i);
    }
  }
  return out;
}

/// A log of ten events on disk, its bytes at hand to be damaged.
class DamagedLog : public ::testing::Test {
 protected:
  void SetUp() override {
    writeLog(path_, events_);
    bytes_ = readText(path_);
  }
  std::int64_t at(std::size_t event) const { return events_[event].at; }
  std::int64_t size() const { return std::ssize(bytes_); }
  void damage(std::int64_t from, std::int64_t to) {
    for (auto i = from; i < to; ++i) {
      bytes_[static_cast<std::size_t>(i)] ^= '\x5a';
    }
  }
  void patchLength(std::int64_t at, std::uint32_t value) {
    for (std::int64_t i = 0; i < 4; ++i) {
      bytes_[static_cast<std::size_t>(at + i)] = static_cast<char>(value >> (24 - 8 * i));
    }
  }
  Read read() {
    writeText(path_, bytes_);
    return readLog(path_);
  }

  Scratch scratch_;
  std::string path_ = scratch_ / "log.lcm";
  std::vector<Written> events_ = randomEvents(10, 500, 1);
  std::string bytes_;
};

TEST_F(DamagedLog, AWholeLogIsReadWithoutLoss) {
  const auto out = read();
  EXPECT_TRUE(isExactly(out, events_, allBut(10, {})));
  EXPECT_EQ(out.loss.gaps, 0);
  EXPECT_EQ(out.loss.gap_bytes + out.loss.tail_bytes, 0);
  EXPECT_EQ(out.progress, 1.0);
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(out.events[i].number, static_cast<std::int64_t>(i));
  }
}

TEST_F(DamagedLog, LcmReadsWhatWeWrite) {
  lcm::LogFile file(path_, "r");
  ASSERT_TRUE(file.good());
  for (const auto& event : events_) {
    const auto* read = file.readNextEvent();
    ASSERT_NE(read, nullptr);
    EXPECT_EQ(read->channel, event.channel);
    EXPECT_EQ(read->timestamp, event.timestamp_us);
    const auto* data = static_cast<const std::uint8_t*>(read->data);
    EXPECT_EQ(Data(data, data + read->datalen), event.data);
  }
  EXPECT_EQ(file.readNextEvent(), nullptr);
}

TEST_F(DamagedLog, WeReadWhatLcmWrites) {
  const std::string path = scratch_ / "lcm.lcm";
  {
    lcm::LogFile file(path, "w");
    for (auto& event : events_) {
      lcm::LogEvent out{0, event.timestamp_us, event.channel, static_cast<std::int32_t>(event.data.size()),
                        event.data.data()};
      ASSERT_EQ(file.writeEvent(&out), 0);
    }
  }
  EXPECT_EQ(readText(path), bytes_);
}

TEST_F(DamagedLog, ADamagedStretchCostsTheEventsInIt) {
  damage(at(3) + 2, at(5) + 10);
  const auto out = read();
  EXPECT_TRUE(isExactly(out, events_, allBut(10, {3, 4, 5})));
  EXPECT_EQ(out.loss.gaps, 1);
  EXPECT_EQ(out.loss.gap_bytes, at(6) - at(3));
  EXPECT_EQ(out.loss.tail_bytes, 0);
}

TEST_F(DamagedLog, ADamagedSyncWordCostsOneEvent) {
  damage(at(4), at(4) + 1);
  EXPECT_TRUE(isExactly(read(), events_, allBut(10, {4})));
}

TEST_F(DamagedLog, AnEventBetweenTwoDamagedOnesSurvives) {
  damage(at(4), at(4) + 1);
  damage(at(6), at(6) + 1);
  const auto out = read();
  EXPECT_TRUE(isExactly(out, events_, allBut(10, {4, 6})));
  EXPECT_EQ(out.loss.gaps, 2);
}

TEST_F(DamagedLog, ALengthThatGrewDoesNotSwallowTheNextEvents) {
  for (const std::uint32_t length : {700u, 2000u, 0x0fffffffu, 0x7fffffffu, 0x80000000u, 0xffffffffu}) {
    bytes_ = readText(path_);
    patchLength(at(2) + 24, length);
    EXPECT_TRUE(isExactly(read(), events_, allBut(10, {2}))) << length;
    writeLog(path_, events_);
  }
}

TEST_F(DamagedLog, AChannelLengthThatIsAbsurdCostsOneEvent) {
  for (const std::uint32_t length : {0u, 256u, 0x7fffffffu, 0xffffffffu}) {
    bytes_ = readText(path_);
    patchLength(at(2) + 20, length);
    EXPECT_TRUE(isExactly(read(), events_, allBut(10, {2}))) << length;
    writeLog(path_, events_);
  }
}

TEST_F(DamagedLog, TheBeginningMayBeMissing) {
  bytes_ = bytes_.substr(static_cast<std::size_t>(at(1) + 3));
  const auto out = read();
  EXPECT_TRUE(isExactly(out, events_, allBut(10, {0, 1})));
  EXPECT_EQ(out.loss.gaps, 1);
}

TEST_F(DamagedLog, TruncatedTailIsReported) {
  for (std::int64_t cut = at(8); cut < size(); ++cut) {
    const std::string whole = bytes_;
    bytes_.resize(static_cast<std::size_t>(cut));
    const auto out = read();
    const bool nine = cut >= at(9);
    EXPECT_TRUE(isExactly(out, events_, nine ? allBut(10, {9}) : allBut(10, {8, 9}))) << cut;
    EXPECT_EQ(out.loss.gaps, 0);
    EXPECT_EQ(out.loss.tail_bytes, cut - at(nine ? 9 : 8)) << cut;
    bytes_ = whole;
  }
}

TEST_F(DamagedLog, ZerosAtTheEndAreTail) {
  bytes_.append(5000, '\0');
  const auto out = read();
  EXPECT_TRUE(isExactly(out, events_, allBut(10, {})));
  EXPECT_EQ(out.loss.tail_bytes, 5000);
}

TEST_F(DamagedLog, ALogWithinALogIsData) {
  const Data inner(bytes_.begin(), bytes_.end());
  const std::vector<Written> outer = {{"LOG", 1, inner}, {"LOG", 2, inner}};
  const std::string path = scratch_ / "outer.lcm";
  writeLog(path, outer);
  EXPECT_TRUE(isExactly(readLog(path), outer, {0, 1}));
}

TEST_F(DamagedLog, WhateverIsDamagedTheOtherEventsSurvive) {
  std::mt19937 random(2);
  const std::string whole = bytes_;
  for (int round = 0; round < 3000; ++round) {
    bytes_ = whole;
    const std::int64_t from = static_cast<std::int64_t>(random()) % size();
    const std::int64_t to = std::min(size(), from + 1 + static_cast<std::int64_t>(random() % (round % 2 ? 20 : 800)));
    for (auto i = from; i < to; ++i) {
      bytes_[static_cast<std::size_t>(i)] = static_cast<char>(random());
    }
    const auto out = read();
    std::int64_t event_bytes = 0;
    for (const auto& event : out.events) {
      event_bytes += 28 + std::ssize(event.channel) + std::ssize(event.data);
    }
    ASSERT_EQ(event_bytes + out.loss.gap_bytes + out.loss.tail_bytes, size());
    auto next = out.events.begin();
    for (const auto& event : events_) {
      if (event.at < to && event.end > from) {
        continue;
      }
      next = std::find_if(next, out.events.end(), [&](const LogEvent& e) { return areEqual(event, e); });
      ASSERT_NE(next, out.events.end()) << "round " << round << ": event at " << event.at << " lost by damage to "
                                        << from << ".." << to;
      ++next;
    }
  }
}

TEST(Log, EventsLargerThanTheWindowAndAcrossItsBordersAreRead) {
  const Scratch scratch;
  auto events = randomEvents(12, 2 << 20, 3);
  events[4].data.resize(9 << 20, 7);
  const std::string path = scratch / "large.lcm";
  writeLog(path, events);
  EXPECT_TRUE(isExactly(readLog(path), events, allBut(12, {})));
}

TEST(Log, TheSameEventsGiveTheSameBytes) {
  const Scratch scratch;
  const auto events = randomEvents(5, 100, 4);
  writeLog(scratch / "a.lcm", events);
  writeLog(scratch / "b.lcm", events);
  EXPECT_EQ(readText(scratch / "a.lcm"), readText(scratch / "b.lcm"));
}

TEST(Log, AFileThatIsNoLogHasNoEvents) {
  const Scratch scratch;
  writeText(scratch / "notes.txt", "not a log, but long enough to hold the header of one");
  const auto out = readLog(scratch / "notes.txt");
  EXPECT_TRUE(out.events.empty());
  EXPECT_EQ(out.loss.tail_bytes, 52);
  writeText(scratch / "empty.lcm", "");
  EXPECT_TRUE(readLog(scratch / "empty.lcm").events.empty());
}

TEST(Log, WhatCannotBeOpenedIsNamed) {
  const Scratch scratch;
  EXPECT_NE(LogReader::open(scratch / "none.lcm").error.find("none.lcm': No such file"), std::string::npos);
  EXPECT_NE(LogReader::open(scratch / "").error.find("not a regular file"), std::string::npos);
  EXPECT_NE(LogWriter::create(scratch / "none" / "x.lcm").error.find("cannot create log"), std::string::npos);
}

TEST(Log, AFullDiskIsAnError) {
  auto log = LogWriter::create("/dev/full");
  if (!log) {
    GTEST_SKIP() << "no /dev/full here";
  }
  const Data data(1 << 20);
  const std::string written = log->write("X", 1, data);
  const std::string closed = log->close();
  EXPECT_NE((written + closed).find("No space left"), std::string::npos);
}

TEST(LogReader, EmptyEventsAndNamesBeyondAsciiAreNoDamage) {
  const Scratch scratch;
  std::vector<Written> events = randomEvents(40, 200, 5);
  for (std::size_t i = 0; i < events.size(); i += 3) {
    events[i].data.clear();
    events[i].channel = i % 2 == 0 ? "caf\xc3\xa9" : "caf\xe9 2";
  }
  const std::string path = (scratch / "log.lcm").string();
  writeLog(path, events);
  const Read read = readLog(path);
  EXPECT_TRUE(isExactly(read, events, allBut(events.size(), {})));
  EXPECT_EQ(read.loss.gaps, 0);
  EXPECT_EQ(read.loss.tail_bytes, 0);
}

}  // namespace
}  // namespace hgg::log_test
