#pragma once

#include <gtest/gtest.h>

#include "core/classes.h"
#include "frame/frame.h"
#include "random_geometry.h"

namespace hgg {

constexpr ClassId kUnlabeled = 0, kCar = 10, kPole = 80, kRoad = 40, kMovingCar = 252;

/// A small class table: cars and poles are things, roads are stuff.
inline ClassTable testClasses() {
  const auto table = ClassTable::parse(R"(
[[class]]
id = 0
name = "unlabeled"
kind = "ignore"
[[class]]
id = 10
name = "car"
kind = "thing"
also = [252]
radius = 0.5
min_points = 5
[[class]]
id = 80
name = "pole"
kind = "thing"
radius = 0.2
min_points = 5
[[class]]
id = 40
name = "road"
kind = "stuff"
min_points = 3
)",
                                       "test classes");
  EXPECT_TRUE(table) << table.error;
  return *table;
}

inline Point pointAt(const Vec3& p, ClassId label, std::uint32_t instance = 0) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()), instance, label};
}

/// n points spread evenly through the box centre +- half.
inline void addBox(Frame& frame, std::mt19937& random, int n, ClassId label, const Vec3& centre, const Vec3& half,
                   std::uint32_t instance = 0) {
  for (int i = 0; i < n; ++i) {
    frame.points.push_back(pointAt(centre + half.cwiseProduct(randomVector(random, 1)), label, instance));
  }
}

}  // namespace hgg
