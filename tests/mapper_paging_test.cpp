// Holds that a map maps the same with its far parts out of memory: what is about to be read is brought back first.
#include <gtest/gtest.h>

#include "map/file.h"
#include "map/shelf.h"
#include "mapper.h"
#include "small_world.h"
#include "test_scene.h"

namespace hgg::mapper_paging_test {
namespace {

constexpr double kStreet = 160, kStep = 1.5, kSight = 12;  // m

Pose at(double x) {
  Pose T = Pose::Identity();
  T.translation() = Vec3(x, 0, 0);
  return T;
}

/// A street with a car or a pole every few metres on both sides.
struct Street {
  struct Thing {
    ClassId label = 0;
    Vec3 centre, half;
  };
  std::vector<Thing> things;
  std::mt19937 random{5};

  Street() {
    std::mt19937 places(3);
    for (double x = -10; x < kStreet + 10; x += uniform(places, 3, 5)) {
      const bool is_car = things.size() % 2 == 0;
      const Vec3 centre(x, (things.size() % 4 < 2 ? 1 : -1) * uniform(places, 4, 7), 0);
      things.push_back({is_car ? kCar : kPole, centre, is_car ? Vec3(0.9, 0.5, 0.5) : Vec3(0.1, 0.1, 1.2)});
    }
  }

  Frame frameAt(int k, double x, const Pose& T_odom_body) {
    Frame frame;
    const auto add = [&](int n, ClassId label, const Vec3& centre, const Vec3& half) {
      for (int i = 0; i < n; ++i) {
        frame.points.push_back(pointAt(centre + half.cwiseProduct(randomVector(random, 1)) - Vec3(x, 0, 0), label));
      }
    };
    for (const Thing& t : things) {
      if (std::abs(t.centre.x() - x) < kSight) {
        add(t.label == kCar ? 120 : 60, t.label, t.centre, t.half);
      }
    }
    add(300, kRoad, Vec3(x, 0, -1), Vec3(6, 3, 0.02));
    frame.utime_us = 100'000 * (k + 1);
    frame.T_odom_body = T_odom_body;
    return frame;
  }
};

Config config() {
  Config config;
  config.frame.range_max = 15;
  config.map.active_radius = 15;
  config.creation.tile_size = 5;
  return config;
}

/// Out along the street and backwards again, with an odometry that overrates every step by `scale`.
void drive(Mapper& mapper, double scale) {
  Street street;
  const int turn = static_cast<int>(kStreet / kStep);
  double odometry = 0, last = 0;
  for (int k = 0; k <= 2 * turn; ++k) {
    const double x = kStep * (k <= turn ? k : 2 * turn - k);
    odometry += (1 + scale) * (x - last);
    last = x;
    mapper.step(street.frameAt(k, x, at(odometry)));
  }
  mapper.finish();
}

TEST(MapperPaging, AMapWithItsFarPartsOutOfMemoryIsTheSameByteForByte) {
  Config still = config();
  still.correction.loop_closure = false;  // a loop moves what is away in one step, which rounds otherwise
  Mapper whole(still, testClasses());
  Shelf shelf;
  Mapper paged(still, testClasses(), {}, LoopTiming::kFixed, shelf.store(60));
  drive(whole, 0.001);
  drive(paged, 0.001);
  EXPECT_GT(shelf.put, 20);
  EXPECT_GT(shelf.taken, 20);
  EXPECT_TRUE(shelf.pages.empty()) << "a map is stored whole";
  EXPECT_TRUE(encodeMap(paged.map()) == encodeMap(whole.map()));
}

TEST(MapperPaging, LoopsAreClosedWithWhatWasPagedOut) {
  Mapper whole(config(), testClasses());
  Shelf shelf;
  Mapper paged(config(), testClasses(), {}, LoopTiming::kFixed, shelf.store(60));
  drive(whole, 0.01);
  drive(paged, 0.01);
  ASSERT_GT(whole.loops().accepted(), 0);
  ASSERT_EQ(paged.loops().records().size(), whole.loops().records().size());
  for (std::size_t k = 0; k < whole.loops().records().size(); ++k) {
    const LoopRecord &a = paged.loops().records()[k], &b = whole.loops().records()[k];
    EXPECT_EQ(a.before_us, b.before_us) << k;
    EXPECT_EQ(a.accepted, b.accepted) << k << ": " << a.reason << " / " << b.reason;
  }
  EXPECT_GT(shelf.taken, 20);
  ASSERT_EQ(paged.map().nodes().size(), whole.map().nodes().size());
  for (const auto& [id, node] : whole.map().nodes()) {
    const MapNode* const other = paged.map().find(id);
    ASSERT_NE(other, nullptr) << id;
    EXPECT_LT((other->belief.mean - node.belief.mean).norm(), 1e-6) << id;
    EXPECT_EQ(other->belief.kappa, node.belief.kappa) << id;
  }
}

}  // namespace
}  // namespace hgg::mapper_paging_test
