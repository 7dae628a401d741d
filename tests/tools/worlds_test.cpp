#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include "core/classes.h"
#include "sim/motion.h"
#include "sim/raycaster.h"
#include "sim/worlds/stage.h"
#include "truth/poses.h"

namespace hgg::worlds_test {
namespace {

struct Case {
  std::string name;
  Scene scene;
};

std::vector<Case> allScenes(double dynamics) {
  std::vector<Case> cases;
  for (const std::string& name : sceneNames()) {
    for (const std::uint64_t seed : {1, 2, 3}) {
      cases.push_back({name + " " + std::to_string(seed), *makeScene(name, seed, dynamics)});
    }
  }
  return cases;
}

/// Worlds in which nothing moves.
bool standsStill(const std::string& name) {
  return std::set<std::string>{"bridge", "corridor", "hole", "ramp", "stairs", "walk", "yard"}.contains(name);
}

/// m to the nearest thing around, at the height of the body.
double clearance(const RayCaster& caster, const Pose& T_world_body) {
  constexpr int kDirections = 48;
  double nearest = 1e9;
  for (int i = 0; i < kDirections; ++i) {
    const double angle = 2.0 * M_PI * i / kDirections;
    const auto hit = caster.cast({T_world_body.translation(), Vec3(std::cos(angle), std::sin(angle), 0.0)});
    nearest = hit ? std::min(nearest, hit->range) : nearest;
  }
  return nearest;
}

TEST(Worlds, TheBodyNeverRunsIntoAnything) {
  for (const double dynamics : {0.0, 1.0}) {
    for (const Case& c : allScenes(dynamics)) {
      RayCaster caster(c.scene);
      for (double time = 0.0; time < c.scene.duration; time += 0.5) {
        caster.setTime(time);
        ASSERT_GT(clearance(caster, c.scene.T_world_body(time)), 0.25) << c.name << " at " << time << " s";
      }
    }
  }
}

TEST(Worlds, TheBodyMovesSmoothlyAtSaneSpeeds) {
  constexpr double kStep = 0.1;
  for (const Case& c : allScenes(0.0)) {
    const bool is_driving = c.name.starts_with("street") || c.name.starts_with("yard") || c.name.starts_with("passes");
    for (double time = 0.0; time < c.scene.duration; time += kStep) {
      const Pose step = c.scene.T_world_body(time).inverse() * c.scene.T_world_body(time + kStep);
      const double speed = step.translation().norm() / kStep;
      ASSERT_LT(speed, is_driving ? 8.5 : 1.8) << c.name << " at " << time << " s";
      ASSERT_GT(speed, 0.15) << c.name << " at " << time << " s";
      const double fastest_turn = c.name.starts_with("corridor") ? 5.0 : 2.2;  // it turns about in its last room
      ASSERT_LT(Eigen::AngleAxisd(step.linear()).angle() / kStep, fastest_turn) << c.name << " at " << time << " s";
      ASSERT_GT(step.translation().x(), 0.7 * step.translation().norm()) << c.name << " at " << time << " s";
    }
  }
}

TEST(Worlds, SixHundredFramesCloseALoopAndTheTourIsTwoLaps) {
  for (const Case& c : allScenes(0.0)) {
    if (c.name.starts_with("passes")) {
      continue;  // a lap and a half, see below
    }
    const Vec3 start = c.scene.T_world_body(0.0).translation();
    double left = -1.0, back = -1.0;
    for (double time = 0.0; time < c.scene.duration && back < 0.0; time += 0.1) {
      const double apart = (c.scene.T_world_body(time).translation() - start).norm();
      left = left < 0.0 && apart > 8.0 ? time : left;
      back = left >= 0.0 && apart < 0.8 ? time : back;
    }
    EXPECT_GT(left, 0.0) << c.name;
    EXPECT_GT(back, left) << c.name;
    EXPECT_LT(back, 60.0) << c.name;
    if (!c.name.starts_with("corridor")) {  // through all of its rooms and back, once
      EXPECT_GE(c.scene.duration, 2.0 * back) << c.name;
    }
  }
}

TEST(Worlds, PassesGoOutBackAndOutAgainOverOneRoad) {
  const Scene scene = *makeScene("passes", 1);
  EXPECT_LE(scene.duration, 139.9);
  constexpr double kMiddle = 130.0;  // x
  std::vector<double> ways;          // +1 out, -1 back
  std::vector<Vec3> places;
  for (double time = 0.1; time < scene.duration; time += 0.1) {
    const Vec3 before = scene.T_world_body(time - 0.1).translation(), now = scene.T_world_body(time).translation();
    if ((before.x() < kMiddle) != (now.x() < kMiddle)) {
      ways.push_back(now.x() > before.x() ? 1.0 : -1.0);
      places.push_back(now);
    }
  }
  EXPECT_EQ(ways, (std::vector<double>{1.0, -1.0, 1.0}));
  ASSERT_EQ(places.size(), 3u);
  EXPECT_NEAR((places[0] - places[1]).head<2>().norm(), 3.5, 0.6) << "the other lane";
  EXPECT_LT((places[0] - places[2]).head<2>().norm(), 1.0) << "the same lane";
}

TEST(Worlds, PlatesComeOnTopOfTheWorldAsItIs) {
  for (const char* name : {"street", "campus"}) {
    const Scene plain = *makeScene(name, 2, 1.0), with = *makeScene(name, 2, 1.0, true);
    ASSERT_GE(with.world.objects.size(), plain.world.objects.size() + 8) << name;
    for (std::size_t i = 0; i < plain.world.solids.size(); ++i) {
      ASSERT_EQ(plain.world.solids[i].bound_center, with.world.solids[i].bound_center) << name;
    }
    for (std::size_t i = plain.world.objects.size(); i < with.world.objects.size(); ++i) {
      const std::string& what = with.world.objects[i].name;
      EXPECT_TRUE(what == "pole" || what == "traffic-sign") << name << ": " << what;
    }
  }
}

TEST(Worlds, PassesHaveSmallPlatesOnPoles) {
  const Scene scene = *makeScene("passes", 1);
  int plates = 0;
  for (const Solid& solid : scene.world.solids) {
    if (scene.world.objects[solid.object].name == "traffic-sign") {
      const Bounds b = boundsOf(solid.shape);
      EXPECT_LT((b.hi - b.lo).maxCoeff(), 0.45);
      EXPECT_GT(b.lo.z() - scene.T_world_body(0.0).translation().z(), -2.5);
      ++plates;
    }
  }
  EXPECT_GE(plates, 20);
}

TEST(Worlds, LabelsAreThoseOfTheShippedClasses) {
  for (const Case& c : allScenes(1.0)) {
    const auto table = ClassTable::load(HGG_SOURCE_DIR "/firmware_cfg/" + c.scene.label_space + "/classes.toml");
    ASSERT_TRUE(table) << table.error;
    for (const WorldObject& object : c.scene.world.objects) {
      const ClassInfo* info = table->find(object.label);
      ASSERT_NE(info, nullptr) << c.name << ": " << object.label;
      EXPECT_EQ(info->name, object.name) << c.name;
      EXPECT_EQ(info->kind == ClassKind::kThing, object.thing) << c.name << ": " << object.name;
      EXPECT_TRUE(object.confused_with == 0 || table->find(object.confused_with) != nullptr) << object.name;
      EXPECT_NE(object.confused_with, object.label) << object.name;
    }
  }
}

/// Surfaces of all that stands at time 0, thinned: object -> bounds.
std::map<std::size_t, Bounds> boundsOfThings(const Scene& scene) {
  std::map<std::size_t, Bounds> bounds;
  for (const Solid& solid : scene.world.solids) {
    if (scene.world.objects[solid.object].thing && !scene.world.objects[solid.object].dynamic) {
      bounds[solid.object] = join(bounds[solid.object], boundsOf(solid.shape));
    }
  }
  return bounds;
}

bool overlap(const Bounds& a, const Bounds& b) {
  return (a.lo.array() < b.hi.array()).all() && (b.lo.array() < a.hi.array()).all();
}

TEST(Worlds, NoTwoThingsOfOneClassTouch) {
  for (const Case& c : allScenes(0.0)) {
    const auto bounds = boundsOfThings(c.scene);
    for (auto a = bounds.begin(); a != bounds.end(); ++a) {
      for (auto b = std::next(a); b != bounds.end(); ++b) {
        // Turned things have bounds wider than themselves: shrink them to their core.
        const auto core = [](const Bounds& x) {
          const Vec3 middle = 0.5 * (x.lo + x.hi), half = 0.35 * (x.hi - x.lo);
          return Bounds{middle - half, middle + half};
        };
        const bool same = c.scene.world.objects[a->first].label == c.scene.world.objects[b->first].label;
        EXPECT_FALSE(same && overlap(core(a->second), core(b->second)))
            << c.name << ": " << c.scene.world.objects[a->first].name << " " << a->first << " and " << b->first;
      }
    }
  }
}

TEST(Worlds, SeedsVaryThePlacementAndNothingElseDoes) {
  for (const std::string& name : sceneNames()) {
    const Scene a = *makeScene(name, 1, 0.5), again = *makeScene(name, 1, 0.5), other = *makeScene(name, 2, 0.5);
    ASSERT_EQ(a.world.solids.size(), again.world.solids.size()) << name;
    for (std::size_t i = 0; i < a.world.solids.size(); ++i) {
      EXPECT_EQ(a.world.solids[i].bound_center, again.world.solids[i].bound_center) << name;
    }
    bool differs = a.world.solids.size() != other.world.solids.size();
    for (std::size_t i = 0; i < a.world.solids.size() && !differs; ++i) {
      differs = a.world.solids[i].bound_center != other.world.solids[i].bound_center;
    }
    EXPECT_TRUE(differs) << name;
  }
}

TEST(Worlds, StillWorldsStandStillAndDynamicOnesChange) {
  for (const std::string& name : sceneNames()) {
    EXPECT_TRUE(makeScene(name, 1, 0.0)->motions.empty()) << name;
    if (standsStill(name)) {
      continue;
    }
    int moving = 0, gone = 0, new_ones = 0;
    for (const std::uint64_t seed : {1, 2, 3}) {
      const Scene scene = *makeScene(name, seed, 1.0);
      for (const Motion& motion : scene.motions) {
        const bool first = motion.T_world_object(0.0).has_value(),
                   last = motion.T_world_object(scene.duration).has_value();
        moving += scene.world.objects[motion.object].dynamic ? 1 : 0;
        gone += first && !last ? 1 : 0;
        new_ones += !first && last ? 1 : 0;
      }
    }
    EXPECT_GE(moving, 3) << name;
    EXPECT_GE(gone, 1) << name;
    EXPECT_GE(new_ones, 1) << name;
  }
}

TEST(Worlds, MoversStartWhereTheyWereAdded) {
  const Scene scene = *makeScene("street", 1, 1.0);
  for (const Motion& motion : scene.motions) {
    const auto pose = motion.T_world_object(0.0);
    EXPECT_TRUE(!pose || pose->isApprox(Pose::Identity(), 1e-9));
  }
}

TEST(Worlds, TruthIsMarkedWithWhatMovedAndWhatIsGone) {
  Scene scene;
  for (int i = 0; i < 3; ++i) {
    addObject(scene.world, 10, true, {uprightBox(Vec3(5.0 * i, 0, 0), Vec3(1, 1, 1), 0.0)});
  }
  scene.world.objects[1].dynamic = true;
  scene.motions.push_back({2, [](double time) { return time < 7.0 ? std::optional(Pose::Identity()) : std::nullopt; }});
  std::vector<TruthObject> objects{{.id = 1}, {.id = 2}, {.id = 3}};
  markMotion(objects, scene, 6.0);
  EXPECT_FALSE(objects[0].dynamic || objects[0].gone || objects[2].dynamic || objects[2].gone);
  EXPECT_TRUE(objects[1].dynamic);
  markMotion(objects, scene, 8.0);
  EXPECT_TRUE(objects[2].gone);
}

TEST(Way, IsClosedEvenAndKeepsItsStraights) {
  const Way way({{0, 0}, {20, 0}, {20, 10}, {0, 10}}, 4.0);
  EXPECT_LT(way.length(), 60.0);
  EXPECT_GT(way.length(), 54.0);
  EXPECT_TRUE(way.at(0.3).position.isApprox(way.at(0.3 + way.length()).position, 1e-9));
  for (double s = 0.0; s < way.length(); s += 0.37) {
    const WayPoint a = way.at(s), b = way.at(s + 0.01);
    EXPECT_NEAR((b.position - a.position).norm(), 0.01, 1e-3);
    EXPECT_GT(a.along.dot(b.along), 0.999);
  }
  EXPECT_NEAR(way.at(10.0).along.x(), 1.0, 1e-6);
  EXPECT_NEAR(way.at(10.0).position.y(), 0.0, 1e-6);
}

TEST(Journey, TimeAndProgressAreInverse) {
  const Journey travel({{{0, 0}, {20, 0}, {20, 10}, {0, 10}}, 4.0}, 1.5, 0.6);
  for (double s = 0.1; s < travel.way().length(); s += 1.7) {
    EXPECT_NEAR(travel.progress(travel.timeAt(s)), s, 1e-6);
  }
  EXPECT_NEAR(travel.progress(2.5 * travel.lapTime()) - travel.progress(0.5 * travel.lapTime()),
              2.0 * travel.way().length(), 1e-6);
}

TEST(Layout, GapsBetweenRectanglesAreNeverOverstated) {
  for (std::uint64_t i = 0; i < 300; ++i) {
    const RandomKey key{12, i};
    const Footprint a{{4.0 * gaussian(key, 0), 4.0 * gaussian(key, 1)}, {1.0, 0.3}, 3.0 * uniform(key, 5)};
    const Footprint b{{0, 0}, {0.5, 2.0}, 3.0 * uniform(key, 6)};
    double nearest = 1e9;  // over the outline of a, to b
    for (double t = -1.0; t <= 1.0; t += 0.02) {
      for (const Vec2& on : {Vec2(t, 1), Vec2(t, -1), Vec2(1, t), Vec2(-1, t)}) {
        const Vec2 local = on.cwiseProduct(a.half);
        const Vec2 p = a.center + Vec2(std::cos(a.yaw) * local.x() - std::sin(a.yaw) * local.y(),
                                       std::sin(a.yaw) * local.x() + std::cos(a.yaw) * local.y());
        nearest = std::min(nearest, distanceTo(b, p));
      }
    }
    EXPECT_LE(gapBetween(a, b), nearest + 1e-9);
    EXPECT_NEAR(gapBetween(a, b), gapBetween(b, a), 1e-12);
  }
}

}  // namespace
}  // namespace hgg::worlds_test
