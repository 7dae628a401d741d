#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/types.h"

namespace hgg {

/// A feature vector of an instance of a label image, in whatever space the segmenter's encoder has.
struct InstanceEmbedding {
  std::uint32_t instance = 0;
  std::vector<float> values;

  bool operator==(const InstanceEmbedding&) const = default;
};

/// What a segmenter says of every pixel, row by row. `instances` and `confidence` are empty or as long as `labels`;
/// embeddings all have the same size.
struct LabelImage {
  Micros utime_us = 0;
  std::int32_t width = 0, height = 0;
  std::vector<ClassId> labels;
  std::vector<std::uint32_t> instances;  // 0 = none
  std::vector<std::uint8_t> confidence;  // share of 255
  std::vector<InstanceEmbedding> embeddings;

  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
  bool operator==(const LabelImage&) const = default;
};

/// Distance of every pixel along the optical axis, row by row, in mm; 0 = not measured.
struct DepthImage {
  Micros utime_us = 0;
  std::int32_t width = 0, height = 0;
  std::vector<std::uint16_t> depth_mm;

  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
  bool operator==(const DepthImage&) const = default;
};

}  // namespace hgg
