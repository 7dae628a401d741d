#include "alignment/align.h"

#include <gtest/gtest.h>

#include <Eigen/QR>

#include "alignment/places.h"
#include "alignment/propagation.h"
#include "core/units.h"
#include "creation/object_graph.h"
#include "mapper.h"
#include "test_scene.h"

namespace hgg::align_test {
namespace {

Place corridor() {
  Place place(1);
  place.addPatch(kRoad, Vec3(-40, -1.5, -1), Vec3(80, 0, 0), Vec3(0, 3, 0));
  place.addPatch(kRoad, Vec3(-40, -1.5, -1), Vec3(80, 0, 0), Vec3(0, 0, 2));
  place.addPatch(kRoad, Vec3(-40, 1.5, -1), Vec3(80, 0, 0), Vec3(0, 0, 2));
  return place;
}

Place openField() {
  Place place(2);
  place.addPatch(kRoad, Vec3(-25, -25, -1), Vec3(50, 0, 0), Vec3(0, 50, 0), 30);
  return place;
}

/// A map made at true poses along x from -1 to 0, and the alignment of a frame at `T_true` with the odometry `T_wrong`.
struct Trial {
  Alignment alignment;
  PoseBelief prior;
};

PoseBelief propagated(const PoseBelief& last, const Pose& T_last_body, const AlignmentConfig& config) {
  return *propagatePose(last, T_last_body, odometryNoise(T_last_body, config));
}

Trial alignIn(Place place, const Pose& T_true, const Pose& T_wrong) {
  Config config;
  config.creation.beam_spacing_deg = 0.2;
  Mapper mapper(config, testClasses());
  for (int i = 0; i < 5; ++i) {
    mapper.step(place.seenFrom(at(-1 + 0.2 * i, 0), 100'000 * (i + 1)));
  }
  const Frame frame = place.seenFrom(T_true, 600'000);
  const PoseBelief last{at(-0.2, 0), 1e6 * Mat6::Identity()};
  Trial trial{{}, propagated(last, last.T_map_body.inverse() * T_wrong, config.alignment)};
  const LocalGraph local = createLocalGraph(frame, T_wrong, testClasses(), config);
  trial.alignment = align(local, mapper.map(), trial.prior, config);
  return trial;
}

/// In standard deviations of the prior.
double awayFromPrior(const Trial& trial) {
  const Vec6 xi = localCoordinates(trial.alignment.pose.T_map_body, trial.prior.T_map_body);
  return std::sqrt(xi.dot(trial.prior.information * xi) / 6);
}

/// Whether the direction lies in the span of those that were reported.
bool isDegenerateAlong(const Alignment& alignment, const Vec6& direction) {
  if (alignment.degenerate_directions.empty()) {
    return false;
  }
  Eigen::MatrixXd span(6, alignment.degenerate_directions.size());
  for (Eigen::Index k = 0; k < span.cols(); ++k) {
    span.col(k) = alignment.degenerate_directions[static_cast<std::size_t>(k)];
  }
  return (span * span.colPivHouseholderQr().solve(direction) - direction).norm() < 0.3;
}

/// Along the directions reported as degenerate the pose is the prior's, and along no other; the reason agrees.
void expectTheRestIsOdometrys(const Trial& trial) {
  const Vec6 xi = localCoordinates(trial.alignment.pose.T_map_body, trial.prior.T_map_body);
  for (const Vec6& direction : trial.alignment.degenerate_directions) {
    const double scale = std::sqrt(direction.dot(trial.prior.information * direction));
    EXPECT_NEAR(direction.dot(trial.prior.information * xi) / scale, 0, 1e-3) << direction.transpose();
  }
  const std::size_t degenerate = trial.alignment.degenerate_directions.size();
  EXPECT_EQ(trial.alignment.source, trial.alignment.leaf_pairs == 0 ? PoseSource::kOdometry
                                    : degenerate == 0               ? PoseSource::kAligned
                                                                    : PoseSource::kDegenerate);
  EXPECT_LT(awayFromPrior(trial), 3);
}

TEST(Align, TakesAwayTheErrorOfOdometryWhereThereIsStructure) {
  const Pose T_true = at(0.5, 0.1, 2), T_wrong = at(0.53, 0.13, 2.3);
  const Trial trial = alignIn(carPark(), T_true, T_wrong);
  const Vec6 error = localCoordinates(trial.alignment.pose.T_map_body, T_true);
  EXPECT_LT(error.head<3>().norm(), 0.012);
  EXPECT_LT(error.tail<3>().norm(), 0.1 * kDegree);
  EXPECT_TRUE(trial.alignment.degenerate_directions.empty());
  EXPECT_EQ(trial.alignment.source, PoseSource::kAligned);
}

/// Late or frozen odometry reports rest at the start of a drive, which is believed to a tenth of a millimetre.
TEST(Align, OdometryThatStandsStillDoesNotHoldAPoseThatMoves) {
  Config config;
  config.creation.beam_spacing_deg = 0.2;
  Mapper mapper(config, testClasses());
  Place place = carPark();
  mapper.step(place.seenFrom(Pose::Identity(), 100'000));
  Pose T_true = at(0.1, 0.02);
  T_true.rotate(Eigen::AngleAxisd(0.4 * kDegree, Vec3::UnitZ()));
  const Frame frame = place.seenFrom(T_true, 200'000);
  const PoseBelief prior = startPose(Pose::Identity(), true);
  const LocalGraph local = createLocalGraph(frame, prior.T_map_body, testClasses(), config);
  const Alignment alignment = align(local, mapper.map(), prior, config);
  EXPECT_LT((alignment.pose.T_map_body.translation() - T_true.translation()).norm(), 0.02);
  EXPECT_LT(turnOf(alignment.pose.T_map_body.inverse() * T_true), 0.1 * kDegree);

  const Frame still = place.seenFrom(Pose::Identity(), 200'000);
  const LocalGraph resting = createLocalGraph(still, prior.T_map_body, testClasses(), config);
  const Alignment held = align(resting, mapper.map(), prior, config);
  EXPECT_LT(held.pose.T_map_body.translation().norm(), 0.001) << "a robot at rest does not creep";
}

TEST(Align, InACorridorTheWayAlongItIsOdometrys) {
  const Pose T_true = at(0.5, 0, 0), T_wrong = at(0.53, 0.03, 0.2);
  const Trial trial = alignIn(corridor(), T_true, T_wrong);
  const Pose& T = trial.alignment.pose.T_map_body;
  EXPECT_NEAR(T.translation().x(), T_wrong.translation().x(), 0.01);
  EXPECT_NEAR(T.translation().y(), 0, 0.006);
  EXPECT_LT(localCoordinates(T, T_true).tail<3>().norm(), 0.1 * kDegree);
  EXPECT_TRUE(isDegenerateAlong(trial.alignment, Vec6::Unit(0)));
  EXPECT_FALSE(isDegenerateAlong(trial.alignment, Vec6::Unit(1)));
  EXPECT_EQ(trial.alignment.source, PoseSource::kDegenerate);
  expectTheRestIsOdometrys(trial);
}

TEST(Align, OnAnOpenFieldOnlyHeightAndTiltAreTheMaps) {
  Pose T_wrong = at(0.52, 0.02, 0.2);
  T_wrong.translation().z() = 0.02;
  const Trial trial = alignIn(openField(), at(0.5, 0, 0), T_wrong);
  const Pose& T = trial.alignment.pose.T_map_body;
  EXPECT_NEAR(T.translation().z(), 0, 0.005);
  EXPECT_NEAR(T.translation().x(), T_wrong.translation().x(), 0.01);
  EXPECT_NEAR(T.translation().y(), T_wrong.translation().y(), 0.01);
  EXPECT_TRUE(isDegenerateAlong(trial.alignment, Vec6::Unit(0)));
  EXPECT_TRUE(isDegenerateAlong(trial.alignment, Vec6::Unit(1)));
  EXPECT_TRUE(isDegenerateAlong(trial.alignment, Vec6::Unit(5)));
  EXPECT_EQ(trial.alignment.degenerate_directions.size(), 3U);
  EXPECT_EQ(trial.alignment.source, PoseSource::kDegenerate);
  expectTheRestIsOdometrys(trial);
}

TEST(Align, NothingInViewIsOdometry) {
  Place nothing(4);
  const Trial trial = alignIn(nothing, at(0.5, 0), at(0.53, 0.03));
  EXPECT_LT(awayFromPrior(trial), 1e-6);
  EXPECT_EQ(trial.alignment.degenerate_directions.size(), 6U);
  EXPECT_EQ(trial.alignment.source, PoseSource::kOdometry);
}

TEST(Align, AnEmptyMapIsOdometry) {
  Place place = carPark();
  Config config;
  config.creation.beam_spacing_deg = 0.2;
  const Frame frame = place.seenFrom(at(0.5, 0), 600'000);
  Trial trial{{}, startPose(at(0.53, 0.03), false)};
  const LocalGraph local = createLocalGraph(frame, trial.prior.T_map_body, testClasses(), config);
  trial.alignment = align(local, Map{}, trial.prior, config);
  EXPECT_LT(awayFromPrior(trial), 1e-6);
  EXPECT_EQ(trial.alignment.degenerate_directions.size(), 6U);
  EXPECT_EQ(trial.alignment.source, PoseSource::kOdometry);
}

TEST(Align, ASingleWallSaysHowFarItIsAndHowItIsTurned) {
  Place place(5);
  place.addPatch(kCar, Vec3(5, -2, -1), Vec3(0, 4, 0), Vec3(0, 0, 2));
  const Trial trial = alignIn(place, at(0.5, 0), at(0.52, 0.02, 0.1));
  EXPECT_NEAR(trial.alignment.pose.T_map_body.translation().x(), 0.5, 0.006);
  EXPECT_NEAR(trial.alignment.pose.T_map_body.translation().y(), 0.02, 0.01);
  EXPECT_FALSE(isDegenerateAlong(trial.alignment, Vec6::Unit(0)));
  for (const int along : {1, 2, 3}) {
    EXPECT_TRUE(isDegenerateAlong(trial.alignment, Vec6::Unit(along))) << along;
  }
  expectTheRestIsOdometrys(trial);
}

TEST(Align, ASingleObjectNeverTearsThePoseFromThePrior) {
  Place place(5);
  place.addBlock(kCar, Vec3(4, 1, -1), Vec3(4, 1.8, 1.5));
  expectTheRestIsOdometrys(alignIn(place, at(0.5, 0), at(0.52, 0.02, 0.1)));
}

TEST(Align, CoplanarObjectsOfOneClassSayNothingOfTheWayAlongThem) {
  Place place(6);
  for (int i = -4; i < 5; ++i) {
    place.addPatch(kCar, Vec3(2.0 * i, 3, -1), Vec3(1, 0, 0), Vec3(0, 0, 1));
  }
  const Trial trial = alignIn(place, at(0.5, 0), at(0.52, 0.02, 0.1));
  EXPECT_NEAR(trial.alignment.pose.T_map_body.translation().y(), 0, 0.006);
  EXPECT_NEAR(trial.alignment.pose.T_map_body.translation().x(), 0.52, 0.01);
  EXPECT_TRUE(isDegenerateAlong(trial.alignment, Vec6::Unit(0)));
  EXPECT_FALSE(isDegenerateAlong(trial.alignment, Vec6::Unit(1)));
  EXPECT_EQ(trial.alignment.source, PoseSource::kDegenerate);
  expectTheRestIsOdometrys(trial);
}

TEST(Align, ObjectsOfOneClassSufficeWhereTheyStandInEveryDirection) {
  Place place(7);
  for (const Vec3& corner : {Vec3(4, 3, -1), Vec3(-7, 4, -1), Vec3(-5, -6, -1), Vec3(3, -6, -1), Vec3(-1, 6, -1)}) {
    place.addBlock(kCar, corner, Vec3(3, 1.8, 1.5));
  }
  const Pose T_true = at(0.5, 0.1, 2);
  const Trial trial = alignIn(place, T_true, at(0.53, 0.13, 2.3));
  const Vec6 error = localCoordinates(trial.alignment.pose.T_map_body, T_true);
  EXPECT_LT(error.head<3>().norm(), 0.012);
  EXPECT_LT(error.tail<3>().norm(), 0.1 * kDegree);
  EXPECT_EQ(trial.alignment.source, PoseSource::kAligned);
}

/// A room whose right wall was seen from the other side, 12 cm behind: the face that is in view now is in no map.
TEST(Align, TheFarFaceOfAWallDoesNotPullThePose) {
  Config config;
  config.creation.beam_spacing_deg = 0.2, config.creation.tile_size = 3, config.alignment.leaf_gate = 0.15;
  config.creation.leaf_gap = 0.2, config.map.leaf_size = 0.1;
  const auto room = [](double right_wall) {
    Place place(8);
    place.addPatch(kRoad, Vec3(-4, -3, -1), Vec3(8, 0, 0), Vec3(0, 6, 0));
    place.addPatch(kRoad, Vec3(4, -3, -1), Vec3(0, 6, 0), Vec3(0, 0, 2));
    place.addPatch(kRoad, Vec3(-4, right_wall, -1), Vec3(8, 0, 0), Vec3(0, 0, 2));
    place.addPatch(kRoad, Vec3(-4, 3, -1), Vec3(3, 0, 0), Vec3(0, 0, 2));  // a little of the left wall
    return place;
  };
  Place before = room(-3.12), now = room(-3);
  Mapper mapper(config, testClasses());
  for (int i = 0; i < 5; ++i) {
    mapper.step(before.seenFrom(at(-1 + 0.2 * i, 0), 100'000 * (i + 1)));
  }
  const PoseBelief prior = propagated({at(-0.2, 0), 1e6 * Mat6::Identity()}, at(0.2, 0), config.alignment);
  const LocalGraph local = createLocalGraph(now.seenFrom(at(0, 0), 600'000), prior.T_map_body, testClasses(), config);
  const Alignment alignment = align(local, mapper.map(), prior, config);
  EXPECT_LT(std::abs(alignment.pose.T_map_body.translation().y()), 0.01);
}

/// Drives with odometry that jumps in frame 5; the last pose.
Pose driveWithAJump(double jump) {
  Place place = carPark();
  Config config;
  config.creation.beam_spacing_deg = 0.2;
  Mapper mapper(config, testClasses());
  Pose T_map_body = Pose::Identity();
  for (int i = 0; i < 12; ++i) {
    Frame frame = place.seenFrom(at(-1 + 0.1 * i, 0), 100'000 * (i + 1));
    frame.T_odom_body = at(-1 + 0.1 * i + (i >= 5 && i < 7 ? jump : 0), 0);
    T_map_body = mapper.step(frame).T_map_body;
  }
  return T_map_body;
}

TEST(Align, AGlitchOfOdometryOutAndBackLeavesThePoseWhereItIs) {
  for (const double jump : {100.0, 1000.0}) {
    const Vec6 error = localCoordinates(driveWithAJump(jump), at(0.1, 0));
    EXPECT_LT(error.head<3>().norm(), 0.05) << jump;
    EXPECT_LT(error.tail<3>().norm(), 0.5 * kDegree) << jump;
  }
}

TEST(Align, WhereThePairsAreNotHeardTheBeliefStaysOdometrys) {
  const Trial trial = alignIn(corridor(), at(0.5, 0, 0), at(0.53, 0.03, 0.2));
  const Vec6 along = Vec6::Unit(0);
  const double before = along.dot(trial.prior.information.inverse() * along);
  const double after = along.dot(trial.alignment.pose.information.inverse() * along);
  EXPECT_NEAR(after, before, 0.1 * before);
}

TEST(Align, DuplicateMapObjectsDoNotHarm) {
  Place place = carPark();
  Config config;
  config.creation.beam_spacing_deg = 0.2;
  Mapper mapper(config, testClasses());
  for (int i = 0; i < 3; ++i) {
    mapper.step(place.seenFrom(at(-0.4 + 0.2 * i, 0), 100'000 * (i + 1)));
  }
  Map map = mapper.map();
  MapUpdate update;
  for (const auto& [id, node] : mapper.map().nodes()) {
    if (!node.stuff) {
      MapNode twin = node;
      twin.id = 0;
      twin.belief.mean += Vec3(0.8, -0.6, 0.1);
      twin.T_map_object.translation() += Vec3(0.8, -0.6, 0.1);
      update.created.push_back(twin);
    }
  }
  map.apply(std::move(update));
  const Frame frame = place.seenFrom(at(0.2, 0), 500'000);
  const PoseBelief prior = propagated({at(0, 0), 1e6 * Mat6::Identity()}, at(0.22, 0.02, 0.2), config.alignment);
  const LocalGraph local = createLocalGraph(frame, prior.T_map_body, testClasses(), config);
  const Alignment alignment = align(local, map, prior, config);
  EXPECT_LT(localCoordinates(alignment.pose.T_map_body, at(0.2, 0)).head<3>().norm(), 0.015);
  EXPECT_EQ(alignment.source, PoseSource::kAligned);
}

}  // namespace
}  // namespace hgg::align_test
