#pragma once

#include <fstream>
#include <nlohmann/json.hpp>

#include "core/types.h"

namespace hgg {

/// The independent values of tests/data/vectors.json, by the name of the formula.
inline const nlohmann::json& section(const char* name) {
  static const auto kVectors = nlohmann::json::parse(std::ifstream(HGG_TEST_DATA "/vectors.json"));
  return kVectors.at(name);
}

inline Vec3 vec3(const nlohmann::json& j) { return {j[0].get<double>(), j[1].get<double>(), j[2].get<double>()}; }

inline Mat3 mat3(const nlohmann::json& j) {
  Mat3 m;
  m << j[0][0], j[0][1], j[0][2], j[1][0], j[1][1], j[1][2], j[2][0], j[2][1], j[2][2];
  return m;
}

}  // namespace hgg
