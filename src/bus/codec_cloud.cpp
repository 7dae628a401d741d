#include <algorithm>
#include <array>
#include <bot_core/pointcloud2_t.hpp>
#include <cstring>
#include <limits>
#include <string_view>

#include "bus/codec.h"
#include "bus/wire.h"

namespace hgg {
namespace {

enum Datatype : std::uint8_t { kInt8 = 1, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };
constexpr std::array<std::int32_t, 9> kDatatypeBytes = {0, 1, 1, 2, 2, 4, 4, 4, 8};

struct Field {
  std::string_view name;
  std::int32_t offset = 0;
  std::uint8_t datatype = 0;
  std::int32_t count = 0;

  std::int64_t end() const { return offset + std::int64_t{std::max(count, 1)} * kDatatypeBytes[datatype]; }
};

/// A cloud's description; `data` still lies in the message.
struct CloudHeader {
  Micros utime_us = 0;
  std::int32_t height = 0, width = 0;
  std::vector<Field> fields;
  std::int32_t point_step = 0, row_step = 0;
  Bytes data;

  const Field* find(std::string_view name) const {
    const auto it = std::find_if(fields.begin(), fields.end(), [&](const Field& f) { return f.name == name; });
    return it == fields.end() ? nullptr : &*it;
  }
};

Field readField(WireReader& in) {
  Field field;
  field.name = in.string("bad field name");
  field.offset = in.integer<std::int32_t>();
  field.datatype = in.integer<std::uint8_t>();
  field.count = in.integer<std::int32_t>();
  in.check(field.offset >= 0, "field offset is negative");
  in.check(field.datatype >= kInt8 && field.datatype <= kFloat64, "unknown field datatype");
  in.check(field.count >= 0, "field count is negative");
  return field;
}

std::vector<Field> readFields(WireReader& in) {
  const auto count = in.integer<std::int32_t>();
  in.check(count >= 0 && count <= kMaxFields, "nfields out of bounds");
  std::vector<Field> fields;
  for (std::int32_t i = 0; i < count && !in.failed(); ++i) {
    fields.push_back(readField(in));
  }
  return fields;
}

CloudHeader readCloud(WireReader& in) {
  CloudHeader cloud;
  in.fingerprint(bot_core::pointcloud2_t::getHash());
  cloud.utime_us = in.utime();
  in.integer<std::int32_t>();  // seq
  in.string("bad frame_id");
  cloud.height = in.integer<std::int32_t>();
  cloud.width = in.integer<std::int32_t>();
  in.check(cloud.height >= 0 && cloud.height <= kMaxPoints && cloud.width >= 0 && cloud.width <= kMaxPoints &&
               std::int64_t{cloud.height} * cloud.width <= kMaxPoints,
           "width * height out of bounds");
  cloud.fields = readFields(in);
  in.check(!in.boolean(), "big-endian clouds are not supported");
  cloud.point_step = in.integer<std::int32_t>();
  cloud.row_step = in.integer<std::int32_t>();
  const auto data_nbytes = in.integer<std::int32_t>();
  in.check(data_nbytes >= 0, "data_nbytes is negative");
  cloud.data = in.failed() ? Bytes{} : in.block(static_cast<std::size_t>(data_nbytes));
  in.boolean();  // is_dense
  in.end();
  return cloud;
}

/// Bytes from row to row; rows are padded when row_step says so.
std::int64_t rowStride(WireReader& in, const CloudHeader& cloud) {
  const std::int64_t row_bytes = std::int64_t{cloud.width} * cloud.point_step;
  const std::int64_t rows = cloud.height, data_bytes = std::ssize(cloud.data);
  if (data_bytes == rows * row_bytes) {
    return row_bytes;
  }
  in.check(cloud.row_step > row_bytes && data_bytes == rows * cloud.row_step,
           "data_nbytes is neither width * height * point_step nor height * row_step");
  return cloud.row_step;
}

/// Where in a record the values lie; offsets of absent fields are -1.
struct RecordLayout {
  std::int32_t x = -1, y = -1, z = -1, label = -1, instance = -1, confidence = -1, time = -1;
  std::uint8_t label_type = 0, instance_type = 0;
};

std::int32_t offsetOf(WireReader& in, const Field* field, bool required, std::initializer_list<Datatype> types,
                      const char* missing, const char* wrong_type) {
  in.check(field || !required, missing);
  if (!field) {
    return -1;
  }
  in.check(std::find(types.begin(), types.end(), field->datatype) != types.end(), wrong_type);
  return field->offset;
}

RecordLayout layoutOf(WireReader& in, const CloudHeader& cloud, bool labelled) {
  const auto fits = [&](const Field& f) { return f.end() <= cloud.point_step; };
  in.check(std::all_of(cloud.fields.begin(), cloud.fields.end(), fits), "a field does not fit point_step");
  const Field *label = cloud.find("label"), *instance = cloud.find("instance");
  RecordLayout layout;
  layout.x = offsetOf(in, cloud.find("x"), true, {kFloat32}, "field x is missing", "field x is not float32");
  layout.y = offsetOf(in, cloud.find("y"), true, {kFloat32}, "field y is missing", "field y is not float32");
  layout.z = offsetOf(in, cloud.find("z"), true, {kFloat32}, "field z is missing", "field z is not float32");
  const Field* time = cloud.find("time");
  layout.time = time && time->datatype == kFloat32 ? time->offset : -1;  // of other types: nobody knows what it counts
  if (!labelled) {
    return layout;
  }
  layout.label = offsetOf(in, label, true, {kUint8, kUint16, kUint32, kInt32}, "field label is missing",
                          "field label is not uint8, uint16, uint32 or int32");
  layout.instance = offsetOf(in, instance, false, {kUint16, kUint32}, "", "field instance is not uint16 or uint32");
  layout.confidence = offsetOf(in, cloud.find("confidence"), false, {kFloat32}, "", "field confidence is not float32");
  if (label) {
    layout.label_type = label->datatype;
  }
  if (instance) {
    layout.instance_type = instance->datatype;
  }
  return layout;
}

template <typename T>
T load(const std::uint8_t* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

std::uint32_t loadUnsigned(const std::uint8_t* bytes, std::uint8_t datatype) {
  if (datatype == kUint8) {
    return *bytes;
  }
  return datatype == kUint16 ? load<std::uint16_t>(bytes) : load<std::uint32_t>(bytes);
}

Point loadPoint(const std::uint8_t* record, const RecordLayout& layout) {
  const auto label = layout.label < 0 ? 0 : loadUnsigned(record + layout.label, layout.label_type);
  return {load<float>(record + layout.x), load<float>(record + layout.y), load<float>(record + layout.z),
          layout.instance < 0 ? 0 : loadUnsigned(record + layout.instance, layout.instance_type),
          static_cast<ClassId>(std::min<std::uint32_t>(label, std::numeric_limits<ClassId>::max()))};
}

/// Points into `points`, and their times, where they have some, into `times`.
void loadPoints(const CloudHeader& cloud, std::int64_t row_stride, const RecordLayout& layout, float min_confidence,
                std::vector<Point>& points, std::vector<float>& times) {
  points.reserve(static_cast<std::size_t>(cloud.height) * static_cast<std::size_t>(cloud.width));
  for (std::int32_t row = 0; row < cloud.height; ++row) {
    const auto* record = cloud.data.data() + row * row_stride;
    for (std::int32_t column = 0; column < cloud.width; ++column, record += cloud.point_step) {
      if (layout.confidence >= 0 && !(load<float>(record + layout.confidence) >= min_confidence)) {
        continue;
      }
      points.push_back(loadPoint(record, layout));
      if (layout.time >= 0) {
        times.push_back(load<float>(record + layout.time));
      }
    }
  }
}

Result<SemanticCloud> readPoints(Bytes message, bool labelled, float min_confidence) {
  WireReader in(message);
  const auto cloud = readCloud(in);
  if (in.failed()) {
    return Result<SemanticCloud>::fail(in.error());
  }
  const auto layout = layoutOf(in, cloud, labelled);
  const auto row_stride = rowStride(in, cloud);
  if (in.failed()) {
    return Result<SemanticCloud>::fail(in.error());
  }
  SemanticCloud out;
  out.utime_us = cloud.utime_us;
  loadPoints(cloud, row_stride, layout, min_confidence, out.points, out.times);
  return Result<SemanticCloud>::ok(std::move(out));
}

bot_core::pointfield_t makeField(const char* name, std::int32_t offset, Datatype datatype) {
  bot_core::pointfield_t field;
  field.name = name;
  field.offset = offset;
  field.datatype = static_cast<std::int8_t>(datatype);
  field.count = 1;
  return field;
}

/// Fields of a cloud besides x, y, z.
struct CloudFields {
  bool label = false, instance = false;
};

/// Adds a field behind those there are and returns its offset.
std::int32_t addField(bot_core::pointcloud2_t& cloud, const char* name, Datatype datatype) {
  const std::int32_t offset = cloud.point_step;
  cloud.fields.push_back(makeField(name, offset, datatype));
  cloud.point_step += kDatatypeBytes[datatype];
  return offset;
}

std::vector<std::uint8_t> encodePoints(Micros utime_us, std::span<const Point> points, std::span<const float> times,
                                       const CloudFields& with) {
  bot_core::pointcloud2_t message{};
  message.utime = utime_us;
  message.frame_id = "body";
  message.height = 1;
  message.width = static_cast<std::int32_t>(points.size());
  for (const char* axis : {"x", "y", "z"}) {
    addField(message, axis, kFloat32);
  }
  const auto label_at = with.label ? addField(message, "label", kUint16) : 0;
  const auto instance_at = with.instance ? addField(message, "instance", kUint32) : 0;
  const auto time_at = times.empty() ? 0 : addField(message, "time", kFloat32);
  message.nfields = static_cast<std::int32_t>(message.fields.size());
  message.row_step = message.data_nbytes = message.point_step * message.width;
  message.data.resize(static_cast<std::size_t>(message.data_nbytes));
  auto* record = message.data.data();
  for (std::size_t i = 0; i < points.size(); ++i, record += message.point_step) {
    const Point& p = points[i];
    std::memcpy(record, &p.x, 4), std::memcpy(record + 4, &p.y, 4), std::memcpy(record + 8, &p.z, 4);
    if (with.label) {
      std::memcpy(record + label_at, &p.label, 2);
    }
    if (with.instance) {
      std::memcpy(record + instance_at, &p.instance, 4);
    }
    if (!times.empty()) {
      std::memcpy(record + time_at, &times[i], 4);
    }
  }
  return encode(message);
}

}  // namespace

Result<SemanticCloud> decodeSemanticCloud(Bytes message, float min_confidence) {
  return readPoints(message, true, min_confidence);
}

Result<SemanticCloud> decodeCloud(Bytes message) { return readPoints(message, false, 0); }

std::vector<std::uint8_t> encodeSemanticCloud(Micros utime_us, std::span<const Point> points) {
  return encodeSemanticCloud(utime_us, points, {});
}

std::vector<std::uint8_t> encodeSemanticCloud(Micros utime_us, std::span<const Point> points,
                                              std::span<const float> times) {
  const bool has_instances = std::any_of(points.begin(), points.end(), [](const Point& p) { return p.instance != 0; });
  return encodePoints(utime_us, points, times, {.label = true, .instance = has_instances});
}

std::vector<std::uint8_t> encodeCloud(Micros utime_us, std::span<const Point> points, std::span<const float> times) {
  return encodePoints(utime_us, points, times, {});
}

}  // namespace hgg
