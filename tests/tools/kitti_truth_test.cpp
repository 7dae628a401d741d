#include "convert/kitti_truth.h"

#include <gtest/gtest.h>

#include "tools/scratch.h"

namespace hgg::kitti_truth_test {
namespace {

const Progress kQuiet = [](std::size_t, std::size_t) {};

struct Annotated {
  Vec3 p_body;
  std::uint32_t label, instance;
};

/// A sequence whose sensor stands `step` m further along x in every frame.
struct Sequence {
  Scratch scratch;
  std::string poses;
  int frames = 0;
  double step = 1.0;

  void add(const std::vector<Annotated>& points) {
    std::vector<float> cloud;
    std::vector<std::uint32_t> words;
    for (const Annotated& p : points) {
      cloud.insert(cloud.end(), {float(p.p_body.x()), float(p.p_body.y()), float(p.p_body.z()), 0.0F});
      words.push_back(p.instance << 16 | p.label);
    }
    const std::string stem = std::to_string(frames);
    writeBinary<float>(scratch / ("velodyne/" + stem + ".bin"), cloud);
    writeBinary<std::uint32_t>(scratch / ("gt_labels/" + stem + ".label"), words);
    poses += "1 0 0 " + std::to_string(step * frames) + " 0 1 0 0 0 0 1 0\n";
    writeText(scratch / "poses.txt", poses);
    ++frames;
  }
  Result<std::vector<TruthObject>> truth(std::optional<std::filesystem::path> boxes = std::nullopt) const {
    KittiOptions options;
    options.dir = scratch / "";
    options.labels = "gt_labels";
    return kittiTruth(*listKittiFrames(options), boxes, kQuiet);
  }
};

TEST(KittiTruth, PointsOfAllFramesArePooledInTheWorld) {
  Sequence sequence;
  sequence.add({{Vec3(10, 0, 0), 10, 7}, {Vec3(12, 2, 0), 10, 7}, {Vec3(1, 1, 1), 40, 0}});
  sequence.add({{Vec3(9, 0, 2), 10, 7}, {Vec3(11, 2, 2), 10, 7}, {Vec3(5, 5, 5), 80, 7}});
  const auto truth = sequence.truth();
  ASSERT_TRUE(truth) << truth.error;
  ASSERT_EQ(truth->size(), 2u);
  const TruthObject& car = (*truth)[0];
  EXPECT_EQ(car.id, 1000007);
  EXPECT_EQ(car.label, 10);
  EXPECT_EQ(car.frames, 2);
  EXPECT_EQ(car.belief.kappa, 4.0);
  EXPECT_LT((car.belief.mean - Vec3(11, 1, 1)).norm(), 1e-6);
  Mat3 cov;
  cov << 1, 1, 0, 1, 1, 0, 0, 0, 1;
  EXPECT_LT((car.belief.cov - cov).norm(), 1e-6);
  EXPECT_EQ((*truth)[1].id, 8000007);
  EXPECT_EQ((*truth)[1].frames, 1);
}

TEST(KittiTruth, ParkedCarSeenFromTwoSidesIsStaticAndDrivingOneIsNot) {
  Sequence sequence;
  for (int k = 0; k < 8; ++k) {
    // The parked car, x 20..24, y 3..4.7: first its back is seen, then its whole side, at last its front end only.
    const double from = k < 6 ? 20.0 : 22.5, to = k < 2 ? 20.2 : 24.0;
    std::vector<Annotated> points;
    for (int i = 0; i <= 10; ++i) {
      points.push_back({Vec3(from + (to - from) * i / 10 - k, k < 2 ? 3.0 + 0.17 * i : 3.0, 0), 10, 1});
    }
    for (int i = 0; i <= 10; ++i) {
      points.push_back({Vec3(30.0 + 0.4 * i - 0.5 * k, -3, 0), 10, 2});  // drives at half the sensor's speed
    }
    sequence.add(points);
  }
  const auto truth = sequence.truth();
  ASSERT_EQ(truth->size(), 2u);
  EXPECT_FALSE((*truth)[0].dynamic);
  EXPECT_TRUE((*truth)[1].dynamic);
}

TEST(KittiTruth, MovingLabelsFoldAndAreDynamic) {
  Sequence sequence;
  sequence.add({{Vec3(10, 0, 0), 252, 3}, {Vec3(10, 0, 0), 254, 3}});
  const auto truth = sequence.truth();
  ASSERT_EQ(truth->size(), 2u);
  EXPECT_EQ((*truth)[0].label, 10);
  EXPECT_TRUE((*truth)[0].dynamic);
  EXPECT_EQ((*truth)[1].label, 30);
}

TEST(KittiTruth, BoxesDecideWhatMoves) {
  Sequence sequence;
  for (int k = 0; k < 2; ++k) {
    sequence.add({{Vec3(10, 0, 0), 10, 1}, {Vec3(20.0 - k, 0, 0), 10, 2}});
  }
  const auto boxes = sequence.scratch / "boxes.csv";
  writeText(
      boxes,
      "frame,track_id,type,cx_world,cy_world\r\n0,1,Car,10,0\r\n0,2,Car,20,0\r\n1,1,Car,10.9,0\r\n1,2,Car,20,1.1\r\n");
  const auto truth = sequence.truth(boxes);
  ASSERT_TRUE(truth) << truth.error;
  EXPECT_FALSE((*truth)[0].dynamic);
  EXPECT_TRUE((*truth)[1].dynamic);
}

TEST(KittiTruth, UnusableBoxesAreAnError) {
  Sequence sequence;
  sequence.add({{Vec3(10, 0, 0), 10, 1}});
  EXPECT_NE(sequence.truth("/nonexistent/boxes.csv").error.find("boxes.csv"), std::string::npos);
  const auto boxes = sequence.scratch / "boxes.csv";
  writeText(boxes, "track_id,cx_world\n1,10\n");
  EXPECT_NE(sequence.truth(boxes).error.find("line 2"), std::string::npos);
}

}  // namespace
}  // namespace hgg::kitti_truth_test
