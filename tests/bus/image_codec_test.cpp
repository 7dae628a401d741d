#include <gtest/gtest.h>

#include <bot_core/image_t.hpp>
#include <bot_core/pointcloud2_t.hpp>
#include <cstring>
#include <functional>
#include <hgg/label_image_t.hpp>
#include <limits>
#include <random>

#include "bus/codec.h"
#include "bus/generated_codec.h"

namespace hgg::image_codec_test {
namespace {

LabelImage someLabels(bool full) {
  std::mt19937 random(1);
  LabelImage image;
  image.utime_us = 77, image.width = 40, image.height = 30;
  for (int i = 0; i < 1200; ++i) {
    image.labels.push_back(static_cast<ClassId>(random()));
    if (!full) {
      continue;
    }
    image.instances.push_back(static_cast<std::uint32_t>(random()));
    image.confidence.push_back(static_cast<std::uint8_t>(random()));
  }
  if (full) {
    image.embeddings = {{4'000'000'000U, {1.5F, -2.0F, 3.25F}}, {7, {0.0F, 1e-30F, 4.0F}}};
  }
  return image;
}

DepthImage someDepth() {
  DepthImage image;
  image.utime_us = 9, image.width = 3, image.height = 2;
  image.depth_mm = {0, 1, 300, 8000, 65535, 12};
  return image;
}

TEST(ImageCodec, LabelImageSurvivesTheRoundTrip) {
  for (const Packing packing : {Packing::kRaw, Packing::kZstd}) {
    for (const bool full : {false, true}) {
      const auto image = decodeLabelImage(encodeLabelImage(someLabels(full), packing));
      ASSERT_TRUE(image) << image.error;
      EXPECT_TRUE(*image == someLabels(full));
    }
  }
}

TEST(ImageCodec, LabelImageIsWhatTheGeneratedTypeReads) {
  const LabelImage image = someLabels(true);
  const auto raw = decodeGenerated<hgg::label_image_t>(encodeLabelImage(image, Packing::kRaw));
  EXPECT_EQ(raw.utime, 77);
  EXPECT_EQ(raw.compression, hgg::label_image_t::RAW);
  ASSERT_EQ(raw.labels_nbytes, 2400);
  EXPECT_EQ(raw.labels[2] | raw.labels[3] << 8, image.labels[1]);
  EXPECT_EQ(raw.instances_nbytes, 4800);
  EXPECT_EQ(raw.confidence[5], image.confidence[5]);
  EXPECT_EQ(raw.embedding_instances, (std::vector<std::int64_t>{4'000'000'000, 7}));
  EXPECT_EQ(raw.embedding_size, 3);
}

TEST(ImageCodec, EmptyImagesAreImages) {
  EXPECT_TRUE(decodeLabelImage(encodeLabelImage({})));
  EXPECT_TRUE(decodeDepthImage(encodeDepthImage({})));
}

std::string labelError(const std::function<void(hgg::label_image_t&)>& change, Packing packing = Packing::kZstd) {
  auto raw = decodeGenerated<hgg::label_image_t>(encodeLabelImage(someLabels(true), packing));
  change(raw);
  raw.labels.resize(static_cast<std::size_t>(raw.labels_nbytes));
  raw.embeddings.resize(static_cast<std::size_t>(raw.embeddings_nbytes));
  return decodeLabelImage(encodeGenerated(raw)).error;
}

TEST(ImageCodec, LabelImagesThatAreNoneAreErrors) {
  const std::string plane = "a plane does not have a value for every pixel";
  EXPECT_EQ(labelError([](auto& m) { m.width = 41; }), plane);
  EXPECT_EQ(labelError([](auto& m) { m.width = 41; }, Packing::kRaw), plane);
  EXPECT_EQ(labelError([](auto& m) { m.compression = 2; }), "unknown compression");
  EXPECT_EQ(labelError([](auto& m) { m.compression = 0; }), plane);
  EXPECT_EQ(labelError([](auto& m) { m.compression = 1; }, Packing::kRaw), plane);
  EXPECT_EQ(labelError([](auto& m) { m.labels_nbytes = 0; }), "labels are missing");
  EXPECT_EQ(labelError([](auto& m) { m.labels_nbytes -= 5; }), "a plane is not a zstd frame");
  EXPECT_EQ(labelError([](auto& m) { m.width = -1; }), "width * height out of bounds");
  EXPECT_EQ(labelError([](auto& m) { m.width = m.height = 1 << 15; }), "width * height out of bounds");
  EXPECT_EQ(labelError([](auto& m) { m.embedding_size = 4; }),
            "embeddings_nbytes is not num_embeddings * embedding_size * 4");
  EXPECT_EQ(labelError([](auto& m) { m.embedding_size = -1; }), "embeddings out of bounds");
  EXPECT_EQ(labelError([](auto& m) { m.embedding_instances[0] = -1; }), "instance out of bounds");
  EXPECT_EQ(labelError([](auto& m) { m.utime = -1; }), "time out of bounds");
}

TEST(ImageCodec, DepthImageSurvivesTheRoundTripAndPaddedRowsAreRead) {
  const auto image = decodeDepthImage(encodeDepthImage(someDepth()));
  ASSERT_TRUE(image) << image.error;
  EXPECT_TRUE(*image == someDepth());
  auto raw = decodeGenerated<bot_core::image_t>(encodeDepthImage(someDepth()));
  EXPECT_EQ(raw.pixelformat, 'L' | 'G' << 8 | '1' << 16 | '6' << 24);
  raw.row_stride = 8;
  raw.data = {0, 0, 1, 0, 44, 1, 9, 9, 64, 31, 255, 255, 12, 0, 9, 9};
  raw.size = 16;
  const auto padded = decodeDepthImage(encodeGenerated(raw));
  ASSERT_TRUE(padded) << padded.error;
  EXPECT_TRUE(*padded == someDepth());
}

TEST(ImageCodec, DepthsInMetresAreReadInMillimetres) {
  auto raw = decodeGenerated<bot_core::image_t>(encodeDepthImage(someDepth()));
  const std::vector<float> metres = {1.2345F, 0, std::numeric_limits<float>::quiet_NaN(), -2, 65.535F, 70};
  raw.width = 3, raw.height = 2;
  raw.pixelformat = 'F' | 'G' << 8 | '3' << 16 | '2' << 24;
  raw.row_stride = 12;
  raw.data.resize(24);
  std::memcpy(raw.data.data(), metres.data(), 24);
  raw.size = 24;
  const auto image = decodeDepthImage(encodeGenerated(raw));
  ASSERT_TRUE(image) << image.error;
  EXPECT_EQ(image->depth_mm, (std::vector<std::uint16_t>{1235, 0, 0, 0, 65535, 0}));
}

TEST(ImageCodec, DepthImagesThatAreNoneAreErrors) {
  const auto error = [](auto change) {
    auto raw = decodeGenerated<bot_core::image_t>(encodeDepthImage(someDepth()));
    change(raw);
    return decodeDepthImage(encodeGenerated(raw)).error;
  };
  const std::string size = "size is not height * row_stride, or rows are too short";
  EXPECT_EQ(error([](auto& m) { m.row_stride = 5; }), size);
  EXPECT_EQ(error([](auto& m) { m.row_stride = 8; }), size);
  EXPECT_EQ(error([](auto& m) { m.height = 3; }), size);
  EXPECT_EQ(error([](auto& m) { m.width = std::numeric_limits<std::int32_t>::max(); }), "width * height out of bounds");
  EXPECT_EQ(error([](auto& m) { m.pixelformat = 357; }),
            "pixelformat is neither little-endian 16-bit grey nor 32-bit float");
}

template <typename Decode>
void expectBroken(const Message& good, Decode decode) {
  for (std::size_t size = 0; size < good.size(); ++size) {
    EXPECT_FALSE(decode(Bytes(good).first(size))) << size;
  }
  Message surplus = good;
  surplus.push_back(0);
  EXPECT_EQ(decode(surplus).error, "surplus bytes");
  EXPECT_EQ(decode(encodePose(1, Pose::Identity())).error, "foreign fingerprint");
  std::mt19937 random(3);
  for (int round = 0; round < 20000; ++round) {  // must not crash, throw or allocate absurdly
    Message bad = good;
    for (unsigned flips = 1 + random() % 4; flips > 0; --flips) {
      bad[random() % bad.size()] = static_cast<std::uint8_t>(random());
    }
    decode(bad);
  }
}

TEST(ImageCodec, BrokenMessagesAreErrors) {
  LabelImage labels = someLabels(true);
  labels.width = 5, labels.height = 4;
  labels.labels.resize(20), labels.instances.resize(20), labels.confidence.resize(20);
  for (const Packing packing : {Packing::kRaw, Packing::kZstd}) {
    expectBroken(encodeLabelImage(labels, packing), [](Bytes message) { return decodeLabelImage(message); });
  }
  expectBroken(encodeDepthImage(someDepth()), [](Bytes message) { return decodeDepthImage(message); });
}

TEST(ImageCodec, UnlabelledCloudSurvivesTheRoundTrip) {
  const std::vector<Point> points = {{1, 2, 3, 4, 5}, {-1, -2, -3, 0, 0}};
  const auto cloud = decodeCloud(encodeCloud(8, points));
  ASSERT_TRUE(cloud) << cloud.error;
  ASSERT_EQ(cloud->points.size(), 2u);
  EXPECT_EQ(cloud->points[0].z, 3);
  EXPECT_EQ(cloud->points[0].label, 0);
  EXPECT_EQ(cloud->points[0].instance, 0u);
  EXPECT_EQ(decodeSemanticCloud(encodeCloud(8, points), 0).error, "field label is missing");
  EXPECT_TRUE(decodeCloud(encodeSemanticCloud(8, points)));
}

TEST(ImageCodec, TimesOfPointsAreAFieldOfTheirOwn) {
  const std::vector<Point> points = {{1, 2, 3, 4, 5}, {-1, -2, -3, 0, 6}};
  const std::vector<float> times = {-0.1F, 0.0F};
  const auto bytes = encodeSemanticCloud(8, points, times);
  const auto raw = decodeGenerated<bot_core::pointcloud2_t>(bytes);
  ASSERT_EQ(raw.nfields, 6);
  EXPECT_EQ(raw.fields[5].name, "time");
  EXPECT_EQ(raw.point_step, 22);
  float first;
  std::memcpy(&first, raw.data.data() + raw.fields[5].offset, sizeof(float));
  EXPECT_EQ(first, -0.1F);
  const auto cloud = decodeSemanticCloud(bytes, 0);
  ASSERT_TRUE(cloud) << cloud.error;
  EXPECT_EQ(cloud->points[1].label, 6);
  EXPECT_EQ(cloud->points[0].instance, 4u);
}

}  // namespace
}  // namespace hgg::image_codec_test
