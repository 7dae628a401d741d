#pragma once

#include <random>
#include <vector>

#include "core/units.h"
#include "test_scene.h"

namespace hgg::align_test {

/// Surfaces seen from the body, resampled for every frame, with 1 cm of noise.
class Place {
 public:
  explicit Place(unsigned seed) : random_(seed) {}

  /// A rectangle corner + [0, 1] u + [0, 1] v of the map frame, `density` points a square metre.
  void addPatch(ClassId label, const Vec3& corner, const Vec3& u, const Vec3& v, double density = 150) {
    patches_.push_back({label, corner, u, v, static_cast<int>(density * u.cross(v).norm())});
  }
  void addBlock(ClassId label, const Vec3& corner, const Vec3& size) {
    const Vec3 x(size.x(), 0, 0), y(0, size.y(), 0), z(0, 0, size.z());
    addPatch(label, corner, x, z);
    addPatch(label, corner, y, z);
    addPatch(label, corner + y, x, z);
    addPatch(label, corner + x, y, z);
    addPatch(label, corner + z, x, y);
  }

  /// What is between 1 and `range` m from the body, in every direction.
  Frame seenFrom(const Pose& T_map_body, Micros utime_us, double range = 12) {
    Frame frame{utime_us, T_map_body, {}};
    for (const Patch& patch : patches_) {
      for (int i = 0; i < patch.points; ++i) {
        const Vec3 p_map = patch.corner + uniform(random_, 0, 1) * patch.u + uniform(random_, 0, 1) * patch.v;
        const Vec3 p = T_map_body.inverse() * (p_map + randomVector(random_, 0.01));
        if (p.norm() > 1 && p.norm() < range) {
          frame.points.push_back(pointAt(p, patch.label));
        }
      }
    }
    return frame;
  }

 private:
  struct Patch {
    ClassId label;
    Vec3 corner, u, v;
    int points;
  };
  std::vector<Patch> patches_;
  std::mt19937 random_;
};

inline Place carPark() {
  Place place(3);
  place.addPatch(kRoad, Vec3(-15, -15, -1), Vec3(30, 0, 0), Vec3(0, 30, 0), 60);
  place.addBlock(kCar, Vec3(4, 3, -1), Vec3(4, 1.8, 1.5));
  place.addBlock(kCar, Vec3(-7, 4, -1), Vec3(1.8, 4, 1.4));
  place.addBlock(kPole, Vec3(3, -5, -1), Vec3(0.2, 0.2, 3));
  place.addBlock(kCar, Vec3(-5, -6, -1), Vec3(4, 1.8, 1.5));
  return place;
}

inline Pose at(double x, double y, double yaw_deg = 0) {
  Pose T = Pose::Identity();
  T.translation() = Vec3(x, y, 0);
  T.rotate(Eigen::AngleAxisd(yaw_deg * kDegree, Vec3::UnitZ()));
  return T;
}

}  // namespace hgg::align_test
