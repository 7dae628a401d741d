#include <bzlib.h>
#include <lz4frame.h>

#include <cstring>
#include <fstream>
#include <map>
#include <optional>
#include <string_view>
#include <vector>

#include "bag/bag.h"

namespace hgg {
namespace {

// The format is that of http://wiki.ros.org/Bags/Format/2.0: records of a header (fields "name=value") and data, both
// with their length before them; messages lie in chunks. Debian's rosbag_storage reads a bag through the index at its
// end, which a bag lacks that was cut by a power failure: so records are read one after the other.
constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
constexpr std::uint8_t kMessage = 2, kChunk = 5, kConnection = 7;
constexpr std::uint32_t kMostHeaderBytes = 1 << 20;
constexpr std::uint32_t kMostDataBytes = 1U << 30;  // of a record, unpacked: rosbag's chunks are 768 kB and one message

using Bytes = std::span<const std::uint8_t>;

std::uint32_t u32At(Bytes bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

/// The fields of a header.
using Fields = std::map<std::string, std::string, std::less<>>;
std::optional<Fields> fieldsOf(Bytes header) {
  Fields fields;
  for (std::size_t at = 0; at < header.size();) {
    if (header.size() - at < 4) {
      return std::nullopt;
    }
    const std::size_t size = u32At(header, at);
    at += 4;
    if (size > header.size() - at) {
      return std::nullopt;
    }
    const std::string_view field(reinterpret_cast<const char*>(header.data()) + at, size);
    const std::size_t equals = field.find('=');
    if (equals == std::string_view::npos) {
      return std::nullopt;
    }
    fields[std::string(field.substr(0, equals))] = field.substr(equals + 1);
    at += size;
  }
  return fields;
}

std::uint32_t number(const Fields& fields, std::string_view name) {
  const auto field = fields.find(name);
  std::uint32_t value = 0;
  if (field != fields.end() && field->second.size() == sizeof value) {
    std::memcpy(&value, field->second.data(), sizeof value);
  }
  return value;
}

std::string text(const Fields& fields, std::string_view name) {
  const auto field = fields.find(name);
  return field != fields.end() ? field->second : "";
}

struct Record {
  Fields fields;
  Bytes data;
  std::size_t size = 0;  // of all of it

  std::uint8_t op() const {
    const auto field = fields.find("op");
    return field != fields.end() && field->second.size() == 1 ? static_cast<std::uint8_t>(field->second[0]) : 0;
  }
};

/// The record at the beginning of `bytes`; nothing when it is not whole or makes no sense.
std::optional<Record> recordAt(Bytes bytes) {
  if (bytes.size() < 4) {
    return std::nullopt;
  }
  const std::size_t header = u32At(bytes, 0);
  if (header > bytes.size() - 4 || bytes.size() - 4 - header < 4) {
    return std::nullopt;
  }
  auto fields = fieldsOf(bytes.subspan(4, header));
  const std::size_t data = u32At(bytes, 4 + header);
  if (!fields || data > bytes.size() - 8 - header) {
    return std::nullopt;
  }
  return Record{std::move(*fields), bytes.subspan(8 + header, data), 8 + header + data};
}

/// What a chunk holds, unpacked into `buffer` where it has to be; an error line otherwise.
Result<Bytes> unpacked(const Record& chunk, std::vector<std::uint8_t>& buffer) {
  const std::string compression = text(chunk.fields, "compression");
  if (compression.empty() || compression == "none") {
    return Result<Bytes>::ok(chunk.data);
  }
  const std::uint32_t size = number(chunk.fields, "size");
  if (size > kMostDataBytes) {
    return Result<Bytes>::fail("a chunk claims " + std::to_string(size) + " bytes");
  }
  buffer.resize(size);
  if (compression == "bz2") {
    unsigned int written = size;
    std::vector<char> packed(chunk.data.begin(), chunk.data.end());  // bzip2 wants to be able to write
    const int result = BZ2_bzBuffToBuffDecompress(reinterpret_cast<char*>(buffer.data()), &written, packed.data(),
                                                  static_cast<unsigned int>(packed.size()), 0, 0);
    return result == BZ_OK && written == size ? Result<Bytes>::ok(buffer)
                                              : Result<Bytes>::fail("a bz2 chunk cannot be unpacked");
  }
  if (compression != "lz4") {
    return Result<Bytes>::fail("chunks are compressed by '" + compression + "', which is not known");
  }
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION)) != 0) {
    return Result<Bytes>::fail("lz4 has no memory");
  }
  std::size_t written = 0, read = 0, left = 1;
  while (left != 0 && read < chunk.data.size()) {
    std::size_t out = size - written, in = chunk.data.size() - read;
    left = LZ4F_decompress(context, buffer.data() + written, &out, chunk.data.data() + read, &in, nullptr);
    if (LZ4F_isError(left) != 0 || (out == 0 && in == 0)) {
      break;
    }
    written += out, read += in;
  }
  LZ4F_freeDecompressionContext(context);
  return left == 0 && written == size ? Result<Bytes>::ok(buffer)
                                      : Result<Bytes>::fail("an lz4 chunk cannot be unpacked");
}

struct Connection {
  std::string topic, type;
};

class Reader {
 public:
  Reader(const BagVisitor& visit, BagEnd& end) : visit_(visit), end_(end) {}

  /// Records of messages and connections, one after the other. False when the visitor has had enough.
  bool readRecords(Bytes bytes) {
    while (!bytes.empty()) {
      const std::optional<Record> record = recordAt(bytes);
      if (!record) {
        end_.damage = "a chunk ends in the middle of a record";
        return true;
      }
      if (!take(*record)) {
        return false;
      }
      bytes = bytes.subspan(record->size);
    }
    return true;
  }

  bool take(const Record& record) {
    if (record.op() == kConnection) {
      if (const auto header = fieldsOf(record.data)) {
        connections_[number(record.fields, "conn")] = {text(record.fields, "topic"), text(*header, "type")};
      }
    } else if (record.op() == kMessage) {
      const auto connection = connections_.find(number(record.fields, "conn"));
      const std::string time = text(record.fields, "time");
      if (connection != connections_.end() && time.size() == 8) {
        const Bytes raw(reinterpret_cast<const std::uint8_t*>(time.data()), time.size());
        const std::int64_t stamp_ns = std::int64_t{u32At(raw, 0)} * 1'000'000'000 + u32At(raw, 4);
        ++end_.messages;
        return visit_({connection->second.topic, connection->second.type, stamp_ns, BagWire::kRos1, record.data});
      }
    }
    return true;
  }

 private:
  const BagVisitor& visit_;
  BagEnd& end_;
  std::map<std::uint32_t, Connection> connections_;
};

/// The next record of a file, in `buffer`, header and data, as far as the file goes. False at the end of the file.
bool readRecord(std::ifstream& in, std::vector<std::uint8_t>& buffer) {
  const auto append = [&](std::size_t bytes) {
    const std::size_t before = buffer.size();
    buffer.resize(before + bytes);
    in.read(reinterpret_cast<char*>(buffer.data() + before), static_cast<std::streamsize>(bytes));
    buffer.resize(before + static_cast<std::size_t>(in.gcount()));
    return static_cast<std::size_t>(in.gcount()) == bytes;
  };
  buffer.clear();
  if (!append(4)) {
    return !buffer.empty();
  }
  const std::uint32_t header = u32At(buffer, 0);
  if (header > kMostHeaderBytes || !append(header) || !append(4)) {
    return true;
  }
  const std::uint32_t data = u32At(buffer, 4 + header);
  if (data <= kMostDataBytes) {
    append(data);
  }
  return true;
}

/// Of a chunk that the file ends in: its header, and what there is of its data.
std::optional<Record> cutChunk(Bytes bytes) {
  if (bytes.size() < 8 || u32At(bytes, 0) > bytes.size() - 8) {
    return std::nullopt;
  }
  const std::size_t header = u32At(bytes, 0);
  auto fields = fieldsOf(bytes.subspan(4, header));
  if (!fields) {
    return std::nullopt;
  }
  Record record{std::move(*fields), bytes.subspan(8 + header), bytes.size()};
  return record.op() == kChunk && text(record.fields, "compression") == "none" ? std::optional(std::move(record))
                                                                               : std::nullopt;
}

}  // namespace

Result<BagEnd> readRos1Bag(const std::filesystem::path& path, const BagVisitor& visit, const BagProgress& progress) {
  std::ifstream in(path, std::ios::binary);
  std::string magic(kMagic.size(), ' ');
  in.read(magic.data(), static_cast<std::streamsize>(magic.size()));
  if (!in || magic != kMagic) {
    return Result<BagEnd>::fail(path.string() + (magic.starts_with("#ROSBAG")
                                                     ? " is a bag of an older format: `rosbag fix` converts it"
                                                     : " is no ROS bag (*.bag, *.db3 or a folder with them)"));
  }
  std::error_code error;
  const auto size = static_cast<double>(std::filesystem::file_size(path, error));
  BagEnd end;
  Reader reader(visit, end);
  std::vector<std::uint8_t> buffer, chunk;
  for (double at = static_cast<double>(kMagic.size()); readRecord(in, buffer);
       at += static_cast<double>(buffer.size())) {
    const std::optional<Record> record = recordAt(buffer);
    if (!record) {
      if (const std::optional<Record> cut = cutChunk(buffer)) {
        reader.readRecords(cut->data);
      }
      end.damage = "it is cut or damaged " + std::to_string(static_cast<std::int64_t>(at)) +
                   " bytes from its start (of " + std::to_string(static_cast<std::int64_t>(size)) + ")";
      break;
    }
    bool goes_on = true;
    if (record->op() == kChunk) {
      const Result<Bytes> records = unpacked(*record, chunk);
      if (records) {
        goes_on = reader.readRecords(*records);
      } else {
        end.damage = records.error;
      }
    } else {
      goes_on = reader.take(*record);
    }
    if (!goes_on) {
      break;
    }
    if (progress) {
      progress((at + static_cast<double>(buffer.size())) / size);
    }
  }
  return Result<BagEnd>::ok(std::move(end));
}

}  // namespace hgg
