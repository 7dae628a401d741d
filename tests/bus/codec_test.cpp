#include "bus/codec.h"

#include <gtest/gtest.h>

#include <bot_core/pointcloud2_t.hpp>
#include <bot_core/pose_t.hpp>
#include <bot_core/rigid_transform_t.hpp>
#include <cmath>
#include <cstring>
#include <hgg/graph_update_t.hpp>
#include <hgg/status_t.hpp>
#include <limits>
#include <random>

#include "bus/generated_codec.h"

namespace hgg::codec_test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// A cloud record by record, as another program might build it.
class CloudBuilder {
 public:
  CloudBuilder(std::int32_t height, std::int32_t width, std::int32_t point_step) {
    cloud_.utime = 7;
    cloud_.frame_id = "body";
    cloud_.height = height, cloud_.width = width, cloud_.point_step = point_step;
    cloud_.row_step = width * point_step;
    cloud_.data.assign(static_cast<std::size_t>(height) * static_cast<std::size_t>(cloud_.row_step), 0);
  }
  CloudBuilder& field(const std::string& name, std::int32_t offset, int datatype, std::int32_t count = 1) {
    bot_core::pointfield_t field;
    field.name = name, field.offset = offset, field.datatype = static_cast<std::int8_t>(datatype), field.count = count;
    cloud_.fields.push_back(field);
    return *this;
  }
  CloudBuilder& xyz() { return field("x", 0, 7).field("y", 4, 7).field("z", 8, 7); }
  template <typename T>
  CloudBuilder& set(int byte, T value) {
    std::memcpy(cloud_.data.data() + byte, &value, sizeof(T));
    return *this;
  }
  bot_core::pointcloud2_t& raw() { return cloud_; }
  Message bytes() {
    cloud_.nfields = static_cast<std::int32_t>(cloud_.fields.size());
    cloud_.data_nbytes = static_cast<std::int32_t>(cloud_.data.size());
    return encodeGenerated(cloud_);
  }

 private:
  bot_core::pointcloud2_t cloud_{};
};

CloudBuilder smallCloud() {
  CloudBuilder builder(1, 3, 14);
  return builder.xyz().field("label", 12, 4);
}

std::string errorOf(CloudBuilder& builder) { return decodeSemanticCloud(builder.bytes(), 0).error; }

void patch32(Message& bytes, std::size_t at, std::uint32_t value) {
  for (std::size_t i = 0; i < 4; ++i) {
    bytes[at + i] = static_cast<std::uint8_t>(value >> (24 - 8 * i));
  }
}

// Where smallCloud()'s lengths lie in its message.
constexpr std::size_t kFrameIdLengthAt = 20, kHeightAt = 29, kWidthAt = 33, kNumFieldsAt = 37, kFirstNameLengthAt = 41;
std::size_t dataLengthAt(const Message& bytes) { return bytes.size() - 1 - 3 * 14 - 4; }

std::vector<Point> randomPoints(int n, bool instances, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> metres(-80, 80);
  std::vector<Point> points(static_cast<std::size_t>(n));
  for (Point& p : points) {
    p = {metres(random), metres(random), metres(random), instances ? static_cast<std::uint32_t>(random()) : 0u,
         static_cast<ClassId>(random())};
  }
  return points;
}

bool areEqual(const Point& a, const Point& b) {
  return a.x == b.x && a.y == b.y && a.z == b.z && a.instance == b.instance && a.label == b.label;
}

// ---------------------------------------------------------------------------------------------------- clouds

TEST(Codec, CloudSurvivesTheRoundTrip) {
  for (const bool instances : {false, true}) {
    const auto points = randomPoints(1000, instances, 1);
    const auto cloud = decodeSemanticCloud(encodeSemanticCloud(123456789, points), 0);
    ASSERT_TRUE(cloud) << cloud.error;
    EXPECT_EQ(cloud->utime_us, 123456789);
    ASSERT_EQ(cloud->points.size(), points.size());
    EXPECT_TRUE(std::equal(points.begin(), points.end(), cloud->points.begin(), areEqual));
  }
}

TEST(Codec, CloudIsWhatTheGeneratedTypeReads) {
  const auto points = randomPoints(50, true, 2);
  const auto raw = decodeGenerated<bot_core::pointcloud2_t>(encodeSemanticCloud(5, points));
  ASSERT_EQ(raw.nfields, 5);
  EXPECT_EQ(raw.width, 50);
  EXPECT_EQ(raw.data_nbytes, 50 * raw.point_step);
  for (std::size_t i = 0; i < points.size(); ++i) {
    float y;
    std::uint32_t instance;
    const auto* record = raw.data.data() + i * static_cast<std::size_t>(raw.point_step);
    std::memcpy(&y, record + raw.fields[1].offset, 4);
    std::memcpy(&instance, record + raw.fields[4].offset, 4);
    EXPECT_EQ(y, points[i].y);
    EXPECT_EQ(instance, points[i].instance);
  }
}

TEST(Codec, ZeroPointsAreACloud) {
  const auto cloud = decodeSemanticCloud(encodeSemanticCloud(1, {}), 0);
  ASSERT_TRUE(cloud) << cloud.error;
  EXPECT_TRUE(cloud->points.empty());
}

TEST(Codec, NonFinitePointsPass) {
  const float inf = std::numeric_limits<float>::infinity();
  const std::vector<Point> points = {{static_cast<float>(kNan), 0, 0, 0, 10}, {0, inf, -inf, 0, 10}};
  const auto cloud = decodeSemanticCloud(encodeSemanticCloud(1, points), 0);
  ASSERT_TRUE(cloud) << cloud.error;
  EXPECT_TRUE(std::isnan(cloud->points[0].x));
  EXPECT_EQ(cloud->points[1].y, inf);
}

TEST(Codec, LabelTypesAreReadAndLargeLabelsClamped) {
  struct Case {
    int datatype;
    std::uint32_t written, read;
  };
  for (const Case& c : {Case{2, 200, 200}, Case{4, 65535, 65535}, Case{6, 10, 10}, Case{6, 65536, 65535},
                        Case{5, 259, 259}, Case{5, 0xffffffff, 65535}}) {
    CloudBuilder builder(1, 1, 16);
    builder.xyz().field("label", 12, c.datatype).set(12, c.written);
    const auto cloud = decodeSemanticCloud(builder.bytes(), 0);
    ASSERT_TRUE(cloud) << cloud.error;
    EXPECT_EQ(cloud->points[0].label, c.read) << c.datatype;
  }
}

TEST(Codec, SixteenBitInstancesAreRead) {
  CloudBuilder builder(1, 1, 16);
  builder.xyz().field("label", 12, 4).field("instance", 14, 4).set<std::uint16_t>(14, 513);
  EXPECT_EQ(decodeSemanticCloud(builder.bytes(), 0)->points[0].instance, 513u);
}

TEST(Codec, PointsBelowTheConfidenceAreLeftOut) {
  CloudBuilder builder(1, 4, 18);
  builder.xyz().field("label", 12, 4).field("confidence", 14, 7);
  const float confidences[] = {0.2f, 0.5f, static_cast<float>(kNan), 0.9f};
  for (int i = 0; i < 4; ++i) {
    builder.set(18 * i, static_cast<float>(i)).set(18 * i + 14, confidences[i]);
  }
  const auto cloud = decodeSemanticCloud(builder.bytes(), 0.5f);
  ASSERT_TRUE(cloud) << cloud.error;
  ASSERT_EQ(cloud->points.size(), 2u);
  EXPECT_EQ(cloud->points[0].x, 1);
  EXPECT_EQ(cloud->points[1].x, 3);
}

TEST(Codec, PaddedRowsAreReadWhereRowStepExplainsThem) {
  constexpr int kStep = 16, kRow = 2 * kStep + 5;
  CloudBuilder builder(2, 2, kStep);
  builder.xyz().field("label", 12, 4);
  builder.raw().data.assign(2 * kRow, 0xee);
  builder.raw().row_step = kRow;
  for (int row = 0; row < 2; ++row) {
    for (int column = 0; column < 2; ++column) {
      builder.set(row * kRow + column * kStep, static_cast<float>(10 * row + column));
    }
  }
  const auto cloud = decodeSemanticCloud(builder.bytes(), 0);
  ASSERT_TRUE(cloud) << cloud.error;
  ASSERT_EQ(cloud->points.size(), 4u);
  EXPECT_EQ(cloud->points[1].x, 1);
  EXPECT_EQ(cloud->points[2].x, 10);
  EXPECT_EQ(cloud->points[3].x, 11);
}

TEST(Codec, UnexplainedDataLengthIsAnError) {
  for (const int surplus : {-1, 1, 14}) {
    auto builder = smallCloud();
    builder.raw().data.resize(builder.raw().data.size() + static_cast<std::size_t>(surplus));
    EXPECT_EQ(errorOf(builder), "data_nbytes is neither width * height * point_step nor height * row_step");
  }
}

TEST(Codec, MissingFieldIsNamed) {
  for (const std::string name : {"x", "y", "z", "label"}) {
    auto builder = smallCloud();
    for (auto& field : builder.raw().fields) {
      if (field.name == name) {
        field.name = "other";
      }
    }
    EXPECT_EQ(errorOf(builder), "field " + name + " is missing");
  }
}

TEST(Codec, FieldsOfTheWrongTypeAreErrors) {
  for (const std::size_t i : {0, 1, 2, 3}) {
    auto builder = smallCloud();
    builder.raw().fields[i].datatype = i == 3 ? 3 : 6;
    EXPECT_NE(errorOf(builder).find("field " + builder.raw().fields[i].name + " is not"), std::string::npos);
  }
}

TEST(Codec, FieldsMustFitTheRecord) {
  const auto with = [](std::int32_t offset, int datatype, std::int32_t count) {
    auto builder = smallCloud();
    builder.field("extra", offset, datatype, count);
    return errorOf(builder);
  };
  EXPECT_EQ(with(6, 8, 1), "");
  EXPECT_EQ(with(7, 8, 1), "a field does not fit point_step");
  EXPECT_EQ(with(0, 8, 2), "a field does not fit point_step");
  EXPECT_EQ(with(0, 8, std::numeric_limits<std::int32_t>::max()), "a field does not fit point_step");
  EXPECT_EQ(with(std::numeric_limits<std::int32_t>::max(), 8, 1), "a field does not fit point_step");
  EXPECT_EQ(with(-1, 1, 1), "field offset is negative");
  EXPECT_EQ(with(0, 1, -1), "field count is negative");
  EXPECT_EQ(with(0, 9, 1), "unknown field datatype");
  EXPECT_EQ(with(0, -128, 1), "unknown field datatype");
}

TEST(Codec, BigEndianCloudsAreAnError) {
  auto builder = smallCloud();
  builder.raw().is_bigendian = 1;
  EXPECT_EQ(errorOf(builder), "big-endian clouds are not supported");
}

TEST(Codec, AbsurdLengthsAreErrors) {
  const Message good = smallCloud().bytes();
  ASSERT_TRUE(decodeSemanticCloud(good, 0));
  const std::size_t lengths[] = {kFrameIdLengthAt, kHeightAt,          kWidthAt,
                                 kNumFieldsAt,     kFirstNameLengthAt, dataLengthAt(good)};
  for (const std::size_t at : lengths) {
    for (const std::uint32_t absurd : {0x7fffffffu, 0x80000000u, 0xffffffffu, 0x00ffffffu}) {
      Message bad = good;
      patch32(bad, at, absurd);
      EXPECT_FALSE(decodeSemanticCloud(bad, 0)) << at << " " << absurd;
    }
  }
}

TEST(Codec, ManyRowsOfNothingCostNothing) {
  Message bytes = smallCloud().bytes();
  patch32(bytes, kHeightAt, 0x7fffffff);
  patch32(bytes, kWidthAt, 0);
  EXPECT_EQ(decodeSemanticCloud(bytes, 0).error, "width * height out of bounds");
}

TEST(Codec, StringWithoutItsTerminatorIsAnError) {
  Message bytes = smallCloud().bytes();
  bytes[kFrameIdLengthAt + 8] = 'x';
  EXPECT_EQ(decodeSemanticCloud(bytes, 0).error, "bad frame_id");
}

TEST(Codec, EveryTruncationIsAnError) {
  const Message cloud = smallCloud().bytes(), pose = encodePose(1, Pose::Identity());
  for (std::size_t size = 0; size < cloud.size(); ++size) {
    EXPECT_FALSE(decodeSemanticCloud(Bytes(cloud).first(size), 0)) << size;
  }
  for (std::size_t size = 0; size < pose.size(); ++size) {
    EXPECT_FALSE(decodePose(Bytes(pose).first(size))) << size;
  }
}

TEST(Codec, SurplusBytesAreAnError) {
  Message cloud = smallCloud().bytes(), pose = encodePose(1, Pose::Identity());
  cloud.push_back(0);
  pose.push_back(0);
  EXPECT_EQ(decodeSemanticCloud(cloud, 0).error, "surplus bytes");
  EXPECT_EQ(decodePose(pose).error, "surplus bytes");
}

TEST(Codec, ForeignFingerprintIsAnError) {
  const Message cloud = smallCloud().bytes(), pose = encodePose(1, Pose::Identity());
  EXPECT_EQ(decodeSemanticCloud(pose, 0).error, "foreign fingerprint");
  EXPECT_EQ(decodePose(cloud).error, "foreign fingerprint");
}

TEST(Codec, FlippedBytesNeverCrashOrAllocateMoreThanTheMessage) {
  std::mt19937 random(3);
  auto builder = smallCloud();
  builder.field("instance", 10, 6).field("confidence", 4, 7);
  const Message good = builder.bytes();
  int decoded = 0;
  for (int round = 0; round < 50000; ++round) {
    Message bad = good;
    for (unsigned flips = 1 + random() % 4; flips > 0; --flips) {
      bad[random() % bad.size()] = static_cast<std::uint8_t>(random());
    }
    const auto cloud = decodeSemanticCloud(bad, 0.1f);
    if (!cloud) {
      continue;
    }
    ++decoded;
    ASSERT_LE(cloud->points.capacity(), bad.size());
  }
  EXPECT_GT(decoded, 1000);   // flips in the data itself cannot be seen
  EXPECT_LT(decoded, 49000);  // flips in the description must be
}

// ---------------------------------------------------------------------------------------------------- poses

bot_core::pose_t somePose() {
  bot_core::pose_t pose{};
  pose.utime = 42;
  pose.pos[0] = 1, pose.pos[1] = -2, pose.pos[2] = 3;
  pose.orientation[0] = 2, pose.orientation[3] = 2;  // 90 degrees about z, twice too long
  pose.vel[0] = kNan;                                // not trusted, so not looked at
  return pose;
}

TEST(Codec, PoseIsReadAndItsOrientationNormalised) {
  const auto sample = decodePose(encodeGenerated(somePose()));
  ASSERT_TRUE(sample) << sample.error;
  EXPECT_EQ(sample->utime_us, 42);
  EXPECT_EQ(sample->T_odom_body.translation(), Vec3(1, -2, 3));
  EXPECT_TRUE((sample->T_odom_body.linear() * Vec3::UnitX()).isApprox(Vec3::UnitY(), 1e-15));
}

TEST(Codec, PoseSurvivesTheRoundTrip) {
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 100; ++i) {
    Pose pose = Pose::Identity();
    pose.translation() = Vec3(normal(random), normal(random), normal(random)) * 100;
    pose.linear() = Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
                        .normalized()
                        .toRotationMatrix();
    const auto sample = decodePose(encodePose(i, pose));
    ASSERT_TRUE(sample) << sample.error;
    EXPECT_EQ(sample->T_odom_body.translation(), pose.translation());
    EXPECT_TRUE(sample->T_odom_body.linear().isApprox(pose.linear(), 1e-14));
  }
}

TEST(Codec, PosesThatAreNoneAreErrors) {
  const auto error = [](auto change) {
    auto pose = somePose();
    change(pose);
    return decodePose(encodeGenerated(pose)).error;
  };
  const std::string orientation = "orientation is not finite or has no length";
  EXPECT_EQ(error([](auto& p) { p.pos[1] = kNan; }), "position is not finite");
  EXPECT_EQ(error([](auto& p) { p.orientation[1] = kNan; }), orientation);
  EXPECT_EQ(error([](auto& p) { p.orientation[1] = std::numeric_limits<double>::infinity(); }), orientation);
  EXPECT_EQ(error([](auto& p) { p.orientation[0] = p.orientation[3] = 0; }), orientation);
  EXPECT_EQ(error([](auto& p) { p.orientation[1] = 1e200; }), orientation);
  EXPECT_EQ(error([](auto& p) { p.utime = -1; }), "time out of bounds");
  EXPECT_EQ(error([](auto& p) { p.utime = std::numeric_limits<std::int64_t>::max(); }), "time out of bounds");
}

// ---------------------------------------------------------------------------------------------------- out

TEST(Codec, RigidTransformIsWhatTheGeneratedTypeReads) {
  Pose pose = Pose::Identity();
  pose.translation() = Vec3(4, 5, 6);
  pose.linear() = Eigen::AngleAxisd(M_PI / 2, Vec3::UnitZ()).toRotationMatrix();
  const auto raw = decodeGenerated<bot_core::rigid_transform_t>(encodeRigidTransform(9, pose));
  EXPECT_EQ(raw.utime, 9);
  EXPECT_EQ(raw.trans[1], 5);
  EXPECT_NEAR(raw.quat[0], std::sqrt(0.5), 1e-15);
  EXPECT_NEAR(raw.quat[3], std::sqrt(0.5), 1e-15);
}

TEST(Codec, GraphUpdateIsWhatTheGeneratedTypeReads) {
  GraphUpdate update{
      .utime_us = 1, .revision = 2, .complete = true, .objects = {}, .removed = {3, 4}, .edges = {{5, 6, 0.25f}}};
  ObjectSummary object{
      .id = 5, .label = 10, .name = "car", .belief = {}, .stuff = true, .classes = {}, .views = 7, .leaves = 8};
  object.belief = {Vec3(1, 2, 3), Mat3::Identity(), 90};
  object.belief.cov(0, 1) = object.belief.cov(1, 0) = 0.5;
  object.first_us = 11, object.last_us = 12;
  update.objects = {object};
  const auto raw = decodeGenerated<hgg::graph_update_t>(encodeGraphUpdate(update));
  EXPECT_EQ(raw.revision, 2);
  EXPECT_TRUE(raw.complete);
  ASSERT_EQ(raw.num_objects, 1);
  EXPECT_EQ(raw.objects[0].name, "car");
  EXPECT_EQ(raw.objects[0].mean[2], 3);
  EXPECT_EQ(raw.objects[0].cov[1], 0.5);
  EXPECT_EQ(raw.objects[0].kappa, 90);
  EXPECT_EQ(raw.objects[0].leaves, 8);
  EXPECT_EQ(raw.objects[0].last_us, 12);
  EXPECT_EQ(raw.removed, (std::vector<std::int64_t>{3, 4}));
  ASSERT_EQ(raw.num_edges, 1);
  EXPECT_EQ(raw.edges[0].b, 6);
  EXPECT_EQ(raw.edges[0].weight, 0.25f);
}

/// A symmetric matrix of which no two entries are alike, all exact in float32.
Mat3 someCovariance(double first) {
  Mat3 cov;
  cov << first, 0.25, 0.5,  //
      0.25, first + 1, 0.75, 0.5, 0.75, first + 2;
  return cov;
}

hgg::object_t sent(const ObjectSummary& object) {
  GraphUpdate update;
  update.objects = {object};
  return decodeGenerated<hgg::graph_update_t>(encodeGraphUpdate(update)).objects.at(0);
}

void expectRowMajor(const float* wire, const Mat3& cov) {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      EXPECT_EQ(wire[3 * row + column], static_cast<float>(cov(row, column))) << row << " " << column;
    }
  }
}

TEST(Codec, AnObjectSaysWhatItIsAndHowWellItsPlaceIsKnown) {
  ObjectSummary object;
  object.position_cov = someCovariance(4);
  object.relative_cov = someCovariance(8);
  object.anchor = 17;
  object.existence = 0.75, object.class_probability = 0.625;
  object.classes = {{10, 0.625F}, {18, 0.25F}, {65535, 0.125F}};
  const auto raw = sent(object);
  expectRowMajor(raw.position_cov, object.position_cov);
  expectRowMajor(raw.relative_cov, object.relative_cov);
  EXPECT_EQ(raw.anchor, 17);
  EXPECT_EQ(raw.existence, 0.75);
  EXPECT_EQ(raw.class_probability, 0.625);
  ASSERT_EQ(raw.num_classes, 3);
  EXPECT_EQ(raw.class_ids, (std::vector<std::int32_t>{10, 18, 65535}));
  EXPECT_EQ(raw.class_probabilities, (std::vector<float>{0.625F, 0.25F, 0.125F}));
}

TEST(Codec, AnObjectThatMovesSaysHowFast) {
  ObjectSummary object;
  object.motion = ObjectMotion{Vec3(-8, 0.5, 0.25), someCovariance(2)};
  const auto raw = sent(object);
  EXPECT_TRUE(raw.dynamic);
  EXPECT_EQ(raw.velocity[0], -8);
  EXPECT_EQ(raw.velocity[1], 0.5F);
  EXPECT_EQ(raw.velocity[2], 0.25F);
  expectRowMajor(raw.velocity_cov, object.motion->velocity_cov);
}

TEST(Codec, WhatNobodyComputesOfAnObjectIsSentAsNotKnown) {
  const auto raw = sent({});
  EXPECT_EQ(raw.num_classes, 0);
  EXPECT_EQ(raw.anchor, -1);
  EXPECT_EQ(raw.region, -1);
  EXPECT_EQ(raw.fragment, 0);
  EXPECT_FALSE(raw.dynamic);
  EXPECT_TRUE(std::ranges::all_of(raw.velocity, [](float v) { return v == 0; }));
  EXPECT_TRUE(std::ranges::all_of(raw.velocity_cov, [](float v) { return v == 0; }));
  EXPECT_TRUE(std::ranges::all_of(raw.position_cov, [](float v) { return v == 0; }));
}

TEST(Codec, AGraphUpdateIsOnePart) {
  const auto raw = decodeGenerated<hgg::graph_update_t>(encodeGraphUpdate({}));
  EXPECT_EQ(raw.part, 0);
  EXPECT_EQ(raw.num_parts, 1);
  EXPECT_EQ(raw.num_removed_edges, 0);
}

TEST(Codec, WhatNobodyComputesOfTheStatusIsSentAsNotKnown) {
  const auto raw = decodeGenerated<hgg::status_t>(encodeStatus({}));
  EXPECT_EQ(raw.state, hgg::status_t::STATE_UNKNOWN);
  EXPECT_EQ(raw.started_us, 0);
  EXPECT_EQ(raw.fragment, 0);
  EXPECT_EQ(raw.position_sigma, 0);
  EXPECT_EQ(raw.heading_sigma, 0);
  EXPECT_EQ(raw.latency_ms, 0);
  EXPECT_EQ(raw.queued, -1);
  EXPECT_EQ(raw.map_budget_mb, 0);
  EXPECT_EQ(raw.disk_free_mb, -1);
  EXPECT_EQ(raw.saved_age_s, -1);
  EXPECT_EQ(raw.num_alarms + raw.num_drops + raw.num_sensors + raw.num_values, 0);
}

TEST(Codec, StatusIsWhatTheGeneratedTypeReads) {
  Status status;
  status.utime_us = 1, status.frames = 2, status.dropped_busy = 3, status.dropped_odometry = 4;
  status.dropped_invalid = 5, status.frame_rate = 9.5, status.frame_ms = 20;
  status.stage_ms = {{"decode", 1}, {"creation", 10}};
  status.objects = 6, status.leaves = 7, status.keyframes = 12, status.loops = 13, status.map_mb = 1.5,
  status.rss_mb = 80;
  status.unknown_labels = 8, status.revision = 9;
  status.alignment = "degenerate", status.degenerate = 2;
  const auto raw = decodeGenerated<hgg::status_t>(encodeStatus(status));
  EXPECT_EQ(raw.dropped_odometry, 4);
  EXPECT_EQ(raw.dropped_invalid, 5);
  EXPECT_EQ(raw.stage_names, (std::vector<std::string>{"decode", "creation"}));
  EXPECT_EQ(raw.stage_ms, (std::vector<double>{1, 10}));
  EXPECT_EQ(raw.objects, 6);
  EXPECT_EQ(raw.leaves, 7);
  EXPECT_EQ(raw.keyframes, 12);
  EXPECT_EQ(raw.loops, 13);
  EXPECT_EQ(raw.map_mb, 1.5);
  EXPECT_EQ(raw.rss_mb, 80);
  EXPECT_EQ(raw.revision, 9);
  EXPECT_EQ(raw.alignment, "degenerate");
  EXPECT_EQ(raw.degenerate, 2);
}

TEST(DecodePose, APositionNoRobotCanHaveIsAnError) {
  Pose T = Pose::Identity();
  T.translation() = Vec3(0, -1.1e7, 0);
  const auto sample = decodePose(encodePose(1, T));
  EXPECT_FALSE(sample);
  EXPECT_NE(sample.error.find("out of bounds"), std::string::npos) << sample.error;
  T.translation() = Vec3(0, -0.9e7, 0);
  EXPECT_TRUE(decodePose(encodePose(1, T)));
}

}  // namespace
}  // namespace hgg::codec_test
