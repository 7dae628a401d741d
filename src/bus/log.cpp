#include "bus/log.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>
#include <string_view>

namespace hgg {
namespace {

constexpr std::uint32_t kSyncWord = 0xEDA1DA01;
constexpr std::uint8_t kSyncBytes[] = {0xED, 0xA1, 0xDA, 0x01};
constexpr std::int64_t kSyncSize = 4;
constexpr std::int64_t kHeaderBytes = 28;
constexpr std::int64_t kMaxChannelBytes = 255;
constexpr std::int64_t kMaxDataBytes = 256 << 20;
constexpr std::int64_t kWindowBytes = 8 << 20;
constexpr std::int64_t kSearchBytes = 1 << 20;

std::uint64_t readBigEndian(const std::uint8_t* bytes, int size) {
  std::uint64_t value = 0;
  for (int i = 0; i < size; ++i) {
    value = value << 8 | bytes[i];
  }
  return value;
}

std::uint8_t* writeBigEndian(std::uint8_t* bytes, std::uint64_t value, int size) {
  for (int i = size; i-- > 0; value >>= 8) {
    bytes[i] = static_cast<std::uint8_t>(value);
  }
  return bytes + size;
}

/// LCM takes any name; one with control characters is damage. Bytes above 0x7f are letters, of UTF-8 or another code.
bool isName(std::span<const std::uint8_t> text) {
  return std::all_of(text.begin(), text.end(), [](std::uint8_t c) { return c >= 0x20 && c != 0x7f; });
}

std::string fileError(const std::string& what, const std::string& path) {
  return what + " log '" + path + "': " + std::strerror(errno);
}

}  // namespace

Result<LogReader> LogReader::open(const std::string& path) {
  LogReader reader;
  reader.file_.reset(std::fopen(path.c_str(), "rb"));
  if (!reader.file_) {
    return Result<LogReader>::fail(fileError("cannot open", path));
  }
  struct stat status {};
  if (fstat(fileno(reader.file_.get()), &status) != 0) {
    return Result<LogReader>::fail(fileError("cannot read", path));
  }
  if (!S_ISREG(status.st_mode)) {
    return Result<LogReader>::fail("cannot read log '" + path + "': not a regular file");
  }
  reader.file_size_ = status.st_size;
  return Result<LogReader>::ok(std::move(reader));
}

std::optional<LogEvent> LogReader::next() {
  const auto header = findEvent();
  if (!header) {
    loss_.tail_bytes += file_size_ - offset_;
    offset_ = file_size_;
    return std::nullopt;
  }
  if (header->at > offset_) {
    loss_.gaps += 1;
    loss_.gap_bytes += header->at - offset_;
  }
  const auto data = view(header->data_at, header->end - header->data_at);
  offset_ = header->end;
  return LogEvent{header->number, header->timestamp_us, header->channel, {data.begin(), data.end()}};
}

double LogReader::progress() const {
  return file_size_ == 0 ? 1.0 : static_cast<double>(offset_) / static_cast<double>(file_size_);
}

/// The next credible event at or after `offset_`. One that is not followed by another is credible only when none stands
/// inside it: then its length is right and the damage begins behind it.
std::optional<LogReader::Header> LogReader::findEvent() {
  for (std::int64_t at = offset_; at < file_size_; at = findSync(at + 1, file_size_)) {
    auto header = headerAt(at);
    if (header && (isFollowedWell(*header) || !hasWholeEvent(at + 1, header->end))) {
      return header;
    }
  }
  return std::nullopt;
}

/// Whether an event that is followed well starts in [from, to). `from` never goes back, so that no stretch is searched
/// twice.
bool LogReader::hasWholeEvent(std::int64_t from, std::int64_t to) {
  if (whole_at_ >= from) {
    return whole_at_ < to;
  }
  for (std::int64_t at = findSync(std::max(from, searched_to_), to); at < to; at = findSync(at + 1, to)) {
    const auto header = headerAt(at);
    if (!header || !isFollowedWell(*header)) {
      continue;
    }
    whole_at_ = at;
    searched_to_ = at + 1;
    return true;
  }
  searched_to_ = std::max(searched_to_, to);
  return false;
}

/// The header at `offset` if its lengths and its channel are plausible and the event fits the file.
std::optional<LogReader::Header> LogReader::headerAt(std::int64_t offset) {
  const auto bytes = view(offset, kHeaderBytes);
  if (std::ssize(bytes) < kHeaderBytes || readBigEndian(bytes.data(), 4) != kSyncWord) {
    return std::nullopt;
  }
  Header header;
  header.at = offset;
  header.number = static_cast<std::int64_t>(readBigEndian(bytes.data() + 4, 8));
  header.timestamp_us = static_cast<Micros>(readBigEndian(bytes.data() + 12, 8));
  // Negative lengths read as huge ones and fail the same bound.
  const auto channel_bytes = static_cast<std::int64_t>(readBigEndian(bytes.data() + 20, 4));
  const auto data_bytes = static_cast<std::int64_t>(readBigEndian(bytes.data() + 24, 4));
  if (channel_bytes < 1 || channel_bytes > kMaxChannelBytes || data_bytes > kMaxDataBytes) {
    return std::nullopt;
  }
  header.data_at = offset + kHeaderBytes + channel_bytes;
  header.end = header.data_at + data_bytes;
  if (header.end > file_size_) {
    return std::nullopt;
  }
  const auto channel = view(offset + kHeaderBytes, channel_bytes);
  if (!isName(channel)) {
    return std::nullopt;
  }
  header.channel.assign(channel.begin(), channel.end());
  return header;
}

bool LogReader::isFollowedWell(const Header& header) {
  return file_size_ - header.end < kSyncSize || hasSyncAt(header.end);
}

bool LogReader::hasSyncAt(std::int64_t offset) {
  if (offset >= window_at_ && offset + kSyncSize <= window_at_ + std::ssize(window_)) {
    return std::memcmp(window_.data() + (offset - window_at_), kSyncBytes, kSyncSize) == 0;
  }
  // Far ahead: not worth moving the window for.
  std::uint8_t word[kSyncSize] = {};
  const ssize_t n = pread(fileno(file_.get()), word, kSyncSize, offset);
  return n == kSyncSize && std::memcmp(word, kSyncBytes, kSyncSize) == 0;
}

/// Offset of the first sync word that starts in [from, to); `to` if there is none.
std::int64_t LogReader::findSync(std::int64_t from, std::int64_t to) {
  const std::string_view sync(reinterpret_cast<const char*>(kSyncBytes), kSyncSize);
  for (std::int64_t at = from; at < to;) {
    const auto bytes = view(at, std::min(kSearchBytes, to - at) + kSyncSize - 1);
    const auto hit = std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()).find(sync);
    if (hit != std::string_view::npos) {
      return at + static_cast<std::int64_t>(hit);
    }
    at += kSearchBytes;
  }
  return to;
}

/// The file's bytes [offset, offset + size), fewer at its end; valid until the next call.
std::span<const std::uint8_t> LogReader::view(std::int64_t offset, std::int64_t size) {
  size = std::min(size, file_size_ - offset);
  if (size <= 0) {
    return {};
  }
  if (offset < window_at_ || offset + size > window_at_ + std::ssize(window_)) {
    fill(offset, size);
  }
  return std::span(window_).subspan(static_cast<std::size_t>(offset - window_at_), static_cast<std::size_t>(size));
}

/// Moves the window to `offset`. What cannot be read becomes zeros: damage like any other.
void LogReader::fill(std::int64_t offset, std::int64_t size) {
  const auto bytes = static_cast<std::size_t>(std::min(std::max(size, kWindowBytes), file_size_ - offset));
  window_.resize(bytes);
  window_at_ = offset;
  std::size_t done = 0;
  while (done < bytes) {
    const ssize_t n =
        pread(fileno(file_.get()), window_.data() + done, bytes - done, offset + static_cast<off_t>(done));
    if (n < 0 && errno == EINTR) {
      continue;
    }
    if (n <= 0) {
      break;
    }
    done += static_cast<std::size_t>(n);
  }
  std::fill(window_.begin() + static_cast<std::ptrdiff_t>(done), window_.end(), std::uint8_t{0});
}

Result<LogWriter> LogWriter::create(const std::string& path) {
  LogWriter writer;
  writer.path_ = path;
  writer.file_.reset(std::fopen(path.c_str(), "wb"));
  if (!writer.file_) {
    return Result<LogWriter>::fail(fileError("cannot create", path));
  }
  return Result<LogWriter>::ok(std::move(writer));
}

std::string LogWriter::write(const std::string& channel, Micros timestamp_us, std::span<const std::uint8_t> data) {
  std::uint8_t header[kHeaderBytes];
  auto* end = writeBigEndian(header, kSyncWord, 4);
  end = writeBigEndian(end, static_cast<std::uint64_t>(count_++), 8);
  end = writeBigEndian(end, static_cast<std::uint64_t>(timestamp_us), 8);
  end = writeBigEndian(end, channel.size(), 4);
  writeBigEndian(end, data.size(), 4);
  const bool done = std::fwrite(header, kHeaderBytes, 1, file_.get()) == 1 &&
                    std::fwrite(channel.data(), 1, channel.size(), file_.get()) == channel.size() &&
                    (data.empty() || std::fwrite(data.data(), data.size(), 1, file_.get()) == 1);
  return done ? "" : fileError("cannot write", path_);
}

std::string LogWriter::close() { return std::fclose(file_.release()) == 0 ? "" : fileError("cannot write", path_); }

}  // namespace hgg
