#include "bus/codec.h"

#include <zstd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <bot_core/image_t.hpp>
#include <bot_core/pointcloud2_t.hpp>
#include <bot_core/pose_t.hpp>
#include <bot_core/rigid_transform_t.hpp>
#include <cmath>
#include <cstring>
#include <hgg/graph_update_t.hpp>
#include <hgg/label_image_t.hpp>
#include <hgg/status_t.hpp>
#include <limits>
#include <string_view>

namespace hgg {
namespace {

static_assert(std::endian::native == std::endian::little, "cloud records are read as they lie in the message");

constexpr double kMinQuaternionNorm = 1e-3;
constexpr int kNone = -1;             // on the wire, of ids and amounts that may be 0: none, or not known
constexpr double kMaxPosition = 1e7;  // m an axis: farther out, floats and tile indices give way

/// Walks a message. The first failure sticks: what is read after it is zero, and `error` says what was wrong.
/// LCM's generated decode is not used on bytes from outside: it trusts lengths, throws on negative ones and allocates
/// absurd ones.
class Reader {
 public:
  explicit Reader(Bytes message) : rest_(message) {}

  template <typename T>
  T integer() {
    std::uint64_t value = 0;
    for (const std::uint8_t byte : block(sizeof(T))) value = value << 8 | byte;
    return static_cast<T>(value);
  }
  double real() { return std::bit_cast<double>(integer<std::uint64_t>()); }
  bool boolean() { return integer<std::uint8_t>() != 0; }

  std::string_view string(const char* what_is_wrong) {
    const auto size = integer<std::int32_t>();
    check(size >= 1 && size <= kMaxStringBytes, what_is_wrong);
    const auto bytes = failed() ? Bytes{} : block(static_cast<std::size_t>(size));
    check(!bytes.empty() && bytes.back() == 0, what_is_wrong);
    return failed() ? std::string_view{}
                    : std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size() - 1);
  }

  Bytes block(std::size_t size) {
    check(size <= rest_.size(), "truncated");
    if (failed()) return {};
    const auto bytes = rest_.first(size);
    rest_ = rest_.subspan(size);
    return bytes;
  }

  void fingerprint(std::int64_t expected) { check(integer<std::int64_t>() == expected, "foreign fingerprint"); }
  Micros utime() {
    const auto utime_us = integer<Micros>();
    check(utime_us >= 0 && utime_us <= kMaxUtime_us, "time out of bounds");
    return utime_us;
  }
  void end() { check(rest_.empty(), "surplus bytes"); }

  void check(bool fine, const char* what_is_wrong) {
    if (!fine && !error_) error_ = what_is_wrong;
  }
  bool failed() const { return error_ != nullptr; }
  const char* error() const { return error_; }

 private:
  Bytes rest_;
  const char* error_ = nullptr;
};

Vec3 readVec3(Reader& in) {
  const double x = in.real(), y = in.real(), z = in.real();
  return {x, y, z};
}

Eigen::Quaterniond readOrientation(Reader& in) {
  const double w = in.real(), x = in.real(), y = in.real(), z = in.real();
  const Eigen::Quaterniond q(w, x, y, z);
  const double norm = q.norm();
  in.check(std::isfinite(norm) && norm > kMinQuaternionNorm, "orientation is not finite or has no length");
  return in.failed() ? Eigen::Quaterniond::Identity() : q.normalized();
}

// ---------------------------------------------------------------------------------------------------- clouds

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

Field readField(Reader& in) {
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

std::vector<Field> readFields(Reader& in) {
  const auto count = in.integer<std::int32_t>();
  in.check(count >= 0 && count <= kMaxFields, "nfields out of bounds");
  std::vector<Field> fields;
  for (std::int32_t i = 0; i < count && !in.failed(); ++i) fields.push_back(readField(in));
  return fields;
}

CloudHeader readCloud(Reader& in) {
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
std::int64_t rowStride(Reader& in, const CloudHeader& cloud) {
  const std::int64_t row_bytes = std::int64_t{cloud.width} * cloud.point_step;
  const std::int64_t rows = cloud.height, data_bytes = std::ssize(cloud.data);
  if (data_bytes == rows * row_bytes) return row_bytes;
  in.check(cloud.row_step > row_bytes && data_bytes == rows * cloud.row_step,
           "data_nbytes is neither width * height * point_step nor height * row_step");
  return cloud.row_step;
}

/// Where in a record the values lie; offsets of absent fields are -1.
struct RecordLayout {
  std::int32_t x = -1, y = -1, z = -1, label = -1, instance = -1, confidence = -1;
  std::uint8_t label_type = 0, instance_type = 0;
};

std::int32_t offsetOf(Reader& in, const Field* field, bool required, std::initializer_list<Datatype> types,
                      const char* missing, const char* wrong_type) {
  in.check(field || !required, missing);
  if (!field) return -1;
  in.check(std::find(types.begin(), types.end(), field->datatype) != types.end(), wrong_type);
  return field->offset;
}

RecordLayout layoutOf(Reader& in, const CloudHeader& cloud, bool labelled) {
  const auto fits = [&](const Field& f) { return f.end() <= cloud.point_step; };
  in.check(std::all_of(cloud.fields.begin(), cloud.fields.end(), fits), "a field does not fit point_step");
  const Field *label = cloud.find("label"), *instance = cloud.find("instance");
  RecordLayout layout;
  layout.x = offsetOf(in, cloud.find("x"), true, {kFloat32}, "field x is missing", "field x is not float32");
  layout.y = offsetOf(in, cloud.find("y"), true, {kFloat32}, "field y is missing", "field y is not float32");
  layout.z = offsetOf(in, cloud.find("z"), true, {kFloat32}, "field z is missing", "field z is not float32");
  if (!labelled) return layout;
  layout.label = offsetOf(in, label, true, {kUint8, kUint16, kUint32, kInt32}, "field label is missing",
                          "field label is not uint8, uint16, uint32 or int32");
  layout.instance = offsetOf(in, instance, false, {kUint16, kUint32}, "", "field instance is not uint16 or uint32");
  layout.confidence = offsetOf(in, cloud.find("confidence"), false, {kFloat32}, "", "field confidence is not float32");
  if (label) layout.label_type = label->datatype;
  if (instance) layout.instance_type = instance->datatype;
  return layout;
}

template <typename T>
T load(const std::uint8_t* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

std::uint32_t loadUnsigned(const std::uint8_t* bytes, std::uint8_t datatype) {
  if (datatype == kUint8) return *bytes;
  return datatype == kUint16 ? load<std::uint16_t>(bytes) : load<std::uint32_t>(bytes);
}

Point loadPoint(const std::uint8_t* record, const RecordLayout& layout) {
  const auto label = layout.label < 0 ? 0 : loadUnsigned(record + layout.label, layout.label_type);
  return {load<float>(record + layout.x), load<float>(record + layout.y), load<float>(record + layout.z),
          layout.instance < 0 ? 0 : loadUnsigned(record + layout.instance, layout.instance_type),
          static_cast<ClassId>(std::min<std::uint32_t>(label, std::numeric_limits<ClassId>::max()))};
}

std::vector<Point> loadPoints(const CloudHeader& cloud, std::int64_t row_stride, const RecordLayout& layout,
                              float min_confidence) {
  std::vector<Point> points;
  points.reserve(static_cast<std::size_t>(cloud.height) * static_cast<std::size_t>(cloud.width));
  for (std::int32_t row = 0; row < cloud.height; ++row) {
    const auto* record = cloud.data.data() + row * row_stride;
    for (std::int32_t column = 0; column < cloud.width; ++column, record += cloud.point_step) {
      if (layout.confidence >= 0 && !(load<float>(record + layout.confidence) >= min_confidence)) continue;
      points.push_back(loadPoint(record, layout));
    }
  }
  return points;
}

Result<SemanticCloud> readPoints(Bytes message, bool labelled, float min_confidence) {
  Reader in(message);
  const auto cloud = readCloud(in);
  if (in.failed()) return Result<SemanticCloud>::fail(in.error());
  const auto layout = layoutOf(in, cloud, labelled);
  const auto row_stride = rowStride(in, cloud);
  if (in.failed()) return Result<SemanticCloud>::fail(in.error());
  return Result<SemanticCloud>::ok({cloud.utime_us, loadPoints(cloud, row_stride, layout, min_confidence)});
}

// ---------------------------------------------------------------------------------------------------- images

constexpr std::int32_t kLittleEndianGray16 = 909199180;  // PIXEL_FORMAT_LE_GRAY16 of bot_core: "LG16"
constexpr int kZstdLevel = 1;
constexpr std::int32_t kMaxMetadata = 64;

Bytes readBlob(Reader& in) {
  const auto size = in.integer<std::int32_t>();
  in.check(size >= 0, "a length is negative");
  return in.failed() ? Bytes{} : in.block(static_cast<std::size_t>(size));
}

void checkImageSize(Reader& in, std::int32_t width, std::int32_t height) {
  in.check(width >= 0 && width <= kMaxPixels && height >= 0 && height <= kMaxPixels &&
               std::int64_t{width} * height <= kMaxPixels,
           "width * height out of bounds");
}

template <typename T>
std::vector<T> valuesOf(Bytes bytes) {
  std::vector<T> values(bytes.size() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  return values;
}

template <typename T>
std::vector<T> unpack(Reader& in, Bytes packed, std::size_t count) {
  std::vector<T> values;
  const std::size_t bytes = count * sizeof(T);
  const auto declared = ZSTD_getFrameContentSize(packed.data(), packed.size());
  in.check(declared == bytes, "a plane does not have a value for every pixel");
  if (in.failed()) return values;
  values.resize(count);
  const auto written = ZSTD_decompress(values.data(), bytes, packed.data(), packed.size());
  in.check(!ZSTD_isError(written) && written == bytes, "a plane is not a zstd frame");
  return values;
}

/// A value for each of `count` pixels; none where the plane is empty.
template <typename T>
std::vector<T> readPlane(Reader& in, std::int8_t compression, std::size_t count) {
  const Bytes bytes = readBlob(in);
  if (in.failed() || bytes.empty()) return {};
  if (compression == hgg::label_image_t::ZSTD) return unpack<T>(in, bytes, count);
  in.check(bytes.size() == count * sizeof(T), "a plane does not have a value for every pixel");
  return in.failed() ? std::vector<T>{} : valuesOf<T>(bytes);
}

std::vector<InstanceEmbedding> readEmbeddings(Reader& in) {
  const auto count = in.integer<std::int32_t>(), size = in.integer<std::int32_t>();
  in.check(count >= 0 && count <= kMaxEmbeddings && size >= 0 && size <= kMaxEmbeddingSize, "embeddings out of bounds");
  std::vector<InstanceEmbedding> embeddings;
  for (std::int32_t i = 0; i < count && !in.failed(); ++i) {
    const auto instance = in.integer<std::int64_t>();
    in.check(instance >= 0 && instance <= std::numeric_limits<std::uint32_t>::max(), "instance out of bounds");
    embeddings.push_back({static_cast<std::uint32_t>(instance), {}});
  }
  const Bytes values = readBlob(in);
  const auto each = static_cast<std::size_t>(size) * sizeof(float);
  in.check(values.size() == embeddings.size() * each, "embeddings_nbytes is not num_embeddings * embedding_size * 4");
  if (in.failed()) return {};
  for (std::size_t i = 0; i < embeddings.size(); ++i) {
    embeddings[i].values = valuesOf<float>(values.subspan(i * each, each));
  }
  return embeddings;
}

LabelImage readLabelImage(Reader& in) {
  LabelImage image;
  in.fingerprint(hgg::label_image_t::getHash());
  image.utime_us = in.utime();
  image.width = in.integer<std::int32_t>();
  image.height = in.integer<std::int32_t>();
  checkImageSize(in, image.width, image.height);
  const auto compression = in.integer<std::int8_t>();
  in.check(compression == hgg::label_image_t::RAW || compression == hgg::label_image_t::ZSTD, "unknown compression");
  const std::size_t pixels =
      in.failed() ? 0 : static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  image.labels = readPlane<ClassId>(in, compression, pixels);
  in.check(image.labels.size() == pixels, "labels are missing");
  image.instances = readPlane<std::uint32_t>(in, compression, pixels);
  image.confidence = readPlane<std::uint8_t>(in, compression, pixels);
  image.embeddings = readEmbeddings(in);
  in.end();
  return image;
}

void skipMetadata(Reader& in) {
  const auto count = in.integer<std::int32_t>();
  in.check(count >= 0 && count <= kMaxMetadata, "nmetadata out of bounds");
  for (std::int32_t i = 0; i < count && !in.failed(); ++i) {
    in.string("bad metadata key");
    readBlob(in);
  }
}

DepthImage readDepthImage(Reader& in) {
  DepthImage image;
  in.fingerprint(bot_core::image_t::getHash());
  image.utime_us = in.utime();
  image.width = in.integer<std::int32_t>();
  image.height = in.integer<std::int32_t>();
  checkImageSize(in, image.width, image.height);
  const auto row_stride = in.integer<std::int32_t>();
  in.check(in.integer<std::int32_t>() == kLittleEndianGray16, "pixelformat is not little-endian 16-bit grey");
  const Bytes data = readBlob(in);
  skipMetadata(in);
  in.end();
  const std::int64_t row_bytes = std::int64_t{image.width} * 2;
  in.check(row_stride >= row_bytes && std::int64_t{row_stride} * image.height == std::ssize(data),
           "size is not height * row_stride, or rows are too short");
  if (in.failed()) return image;
  for (std::int32_t y = 0; y < image.height && row_bytes > 0; ++y) {
    const auto row = data.subspan(static_cast<std::size_t>(std::int64_t{y} * row_stride));
    const auto values = valuesOf<std::uint16_t>(row.first(static_cast<std::size_t>(row_bytes)));
    image.depth_mm.insert(image.depth_mm.end(), values.begin(), values.end());
  }
  return image;
}

template <typename T>
std::vector<std::uint8_t> packPlane(const std::vector<T>& values, Packing packing) {
  const std::size_t size = values.size() * sizeof(T);
  std::vector<std::uint8_t> bytes(packing == Packing::kZstd ? ZSTD_compressBound(size) : size);
  if (size == 0) return {};
  if (packing == Packing::kRaw) {
    std::memcpy(bytes.data(), values.data(), size);
  } else {
    bytes.resize(ZSTD_compress(bytes.data(), bytes.size(), values.data(), size, kZstdLevel));
  }
  return bytes;
}

template <typename Message>
std::vector<std::uint8_t> encode(const Message& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

void store(const Vec3& v, double* out) { std::copy_n(v.data(), 3, out); }

void storeOrientation(const Pose& pose, double* wxyz) {
  const Eigen::Quaterniond q(pose.linear());
  const double sign = q.w() < 0 ? -1 : 1;  // of the two quaternions of a rotation always the same one
  wxyz[0] = sign * q.w(), wxyz[1] = sign * q.x(), wxyz[2] = sign * q.y(), wxyz[3] = sign * q.z();
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
  for (const char* axis : {"x", "y", "z"}) addField(message, axis, kFloat32);
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
    if (with.label) std::memcpy(record + label_at, &p.label, 2);
    if (with.instance) std::memcpy(record + instance_at, &p.instance, 4);
    if (!times.empty()) std::memcpy(record + time_at, &times[i], 4);
  }
  return encode(message);
}

void storeClasses(const ClassWeights& classes, hgg::object_t& out) {
  out.num_classes = static_cast<std::int32_t>(classes.size());
  out.class_ids.reserve(classes.size());
  out.class_probabilities.reserve(classes.size());
  for (const auto& [label, probability] : classes) {
    out.class_ids.push_back(label);
    out.class_probabilities.push_back(probability);
  }
}

hgg::object_t makeObject(const ObjectSummary& object) {
  hgg::object_t out{};  // dynamic, velocity, fragment: zero means not known
  out.id = object.id;
  out.label = object.label;
  out.name = object.name;
  store(object.belief.mean, out.mean);
  std::copy_n(object.belief.cov.data(), 9, out.cov);  // symmetric: row-major is column-major
  out.kappa = object.belief.kappa;
  Eigen::Map<Eigen::Matrix3f>(out.position_cov) = object.position_cov.cast<float>();
  Eigen::Map<Eigen::Matrix3f>(out.relative_cov) = object.relative_cov.cast<float>();
  out.anchor = object.anchor;
  out.region = kNone;
  out.stuff = object.stuff;
  out.existence = object.existence;
  out.class_probability = object.class_probability;
  storeClasses(object.classes, out);
  out.views = object.views;
  out.leaves = object.leaves;
  out.first_us = object.first_us;
  out.last_us = object.last_us;
  return out;
}

hgg::edge_t makeEdge(const Edge& edge) {
  hgg::edge_t out;
  out.a = edge.a;
  out.b = edge.b;
  out.weight = edge.weight;
  return out;
}

}  // namespace

Result<OdometrySample> decodePose(Bytes message) {
  Reader in(message);
  in.fingerprint(bot_core::pose_t::getHash());
  OdometrySample sample;
  sample.utime_us = in.utime();
  sample.T_odom_body.translation() = readVec3(in);
  const Vec3& position = sample.T_odom_body.translation();
  in.check(position.allFinite(), "position is not finite");
  in.check(!(position.cwiseAbs().maxCoeff() > kMaxPosition), "position is out of bounds (more than 10,000 km away)");
  readVec3(in);  // vel
  sample.T_odom_body.linear() = readOrientation(in).toRotationMatrix();
  readVec3(in);  // rotation_rate
  readVec3(in);  // accel
  in.end();
  return in.failed() ? Result<OdometrySample>::fail(in.error()) : Result<OdometrySample>::ok(sample);
}

Result<SemanticCloud> decodeSemanticCloud(Bytes message, float min_confidence) {
  return readPoints(message, true, min_confidence);
}

Result<SemanticCloud> decodeCloud(Bytes message) { return readPoints(message, false, 0); }

Result<LabelImage> decodeLabelImage(Bytes message) {
  Reader in(message);
  LabelImage image = readLabelImage(in);
  return in.failed() ? Result<LabelImage>::fail(in.error()) : Result<LabelImage>::ok(std::move(image));
}

Result<DepthImage> decodeDepthImage(Bytes message) {
  Reader in(message);
  DepthImage image = readDepthImage(in);
  return in.failed() ? Result<DepthImage>::fail(in.error()) : Result<DepthImage>::ok(std::move(image));
}

std::vector<std::uint8_t> encodePose(Micros utime_us, const Pose& T_odom_body) {
  bot_core::pose_t message{};
  message.utime = utime_us;
  store(T_odom_body.translation(), message.pos);
  storeOrientation(T_odom_body, message.orientation);
  return encode(message);
}

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

std::vector<std::uint8_t> encodeLabelImage(const LabelImage& image, Packing packing) {
  hgg::label_image_t message{};
  message.utime = image.utime_us;
  message.width = image.width;
  message.height = image.height;
  message.compression = packing == Packing::kZstd ? hgg::label_image_t::ZSTD : hgg::label_image_t::RAW;
  message.labels = packPlane(image.labels, packing);
  message.labels_nbytes = static_cast<std::int32_t>(message.labels.size());
  message.instances = packPlane(image.instances, packing);
  message.instances_nbytes = static_cast<std::int32_t>(message.instances.size());
  message.confidence = packPlane(image.confidence, packing);
  message.confidence_nbytes = static_cast<std::int32_t>(message.confidence.size());
  message.num_embeddings = static_cast<std::int32_t>(image.embeddings.size());
  message.embedding_size =
      image.embeddings.empty() ? 0 : static_cast<std::int32_t>(image.embeddings.front().values.size());
  for (const InstanceEmbedding& embedding : image.embeddings) {
    message.embedding_instances.push_back(embedding.instance);
    const auto bytes = packPlane(embedding.values, Packing::kRaw);
    message.embeddings.insert(message.embeddings.end(), bytes.begin(), bytes.end());
  }
  message.embeddings_nbytes = static_cast<std::int32_t>(message.embeddings.size());
  return encode(message);
}

std::vector<std::uint8_t> encodeDepthImage(const DepthImage& image) {
  bot_core::image_t message{};
  message.utime = image.utime_us;
  message.width = image.width;
  message.height = image.height;
  message.row_stride = 2 * image.width;
  message.pixelformat = kLittleEndianGray16;
  message.data = packPlane(image.depth_mm, Packing::kRaw);
  message.size = static_cast<std::int32_t>(message.data.size());
  return encode(message);
}

std::vector<std::uint8_t> encodeRigidTransform(Micros utime_us, const Pose& T_map_odom) {
  bot_core::rigid_transform_t message{};
  message.utime = utime_us;
  store(T_map_odom.translation(), message.trans);
  storeOrientation(T_map_odom, message.quat);
  return encode(message);
}

std::vector<std::uint8_t> encodeGraphUpdate(const GraphUpdate& update) {
  hgg::graph_update_t message{};
  message.utime = update.utime_us;
  message.revision = update.revision;
  message.complete = update.complete;
  message.num_parts = 1;
  message.objects.reserve(update.objects.size());
  std::transform(update.objects.begin(), update.objects.end(), std::back_inserter(message.objects), makeObject);
  message.num_objects = static_cast<std::int32_t>(message.objects.size());
  message.removed = update.removed;
  message.num_removed = static_cast<std::int32_t>(message.removed.size());
  std::transform(update.edges.begin(), update.edges.end(), std::back_inserter(message.edges), makeEdge);
  message.num_edges = static_cast<std::int32_t>(message.edges.size());
  return encode(message);
}

std::vector<std::uint8_t> encodeStatus(const Status& status) {
  hgg::status_t message{};  // what is not set here is not known, and zero or empty says so
  message.queued = kNone;
  message.disk_free_mb = message.saved_age_s = kNone;
  message.utime = status.utime_us;
  message.frames = status.frames;
  message.dropped_busy = status.dropped_busy;
  message.dropped_odometry = status.dropped_odometry;
  message.dropped_invalid = status.dropped_invalid;
  message.frame_rate = status.frame_rate;
  message.frame_ms = status.frame_ms;
  message.num_stages = static_cast<std::int32_t>(status.stage_ms.size());
  for (const auto& [name, ms] : status.stage_ms) {
    message.stage_names.push_back(name);
    message.stage_ms.push_back(ms);
  }
  message.objects = status.objects;
  message.leaves = status.leaves;
  message.keyframes = status.keyframes;
  message.loops = status.loops;
  message.map_mb = status.map_mb;
  message.rss_mb = status.rss_mb;
  message.unknown_labels = status.unknown_labels;
  message.revision = status.revision;
  message.alignment = status.alignment;
  message.degenerate = status.degenerate;
  return encode(message);
}

}  // namespace hgg
