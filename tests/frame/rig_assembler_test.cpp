#include "frame/rig_assembler.h"

#include <gtest/gtest.h>

#include <cmath>

#include "bus/codec.h"
#include "frame/rig_scene.h"

namespace hgg::rig_assembler_test {
namespace {

using rig_scene::kCar, rig_scene::kRoad;

constexpr Micros kStart_us = 10'000'000, kPeriod_us = 100'000;

/// A body that turns on the spot at 60 degrees a second.
Pose turned(Micros utime_us) {
  Pose T = Pose::Identity();
  T.linear() = Eigen::AngleAxisd(60 * kDegree * 1e-6 * static_cast<double>(utime_us - kStart_us), Vec3::UnitZ())
                   .toRotationMatrix();
  return T;
}

/// Drives a rig of one LiDAR and the cameras given, frame by frame, as a log would. Images are of the cloud's time and
/// come 20 ms after it unless a test says otherwise.
class RigDrive {
 public:
  explicit RigDrive(std::vector<RigCamera> cameras = {rig_scene::camera("front", 0)})
      : rig_(makeRig(std::move(cameras))), assembler_(rig_, {}, [](Bytes b) { return decodeLabelImage(b); }) {}

  /// One frame; `image` goes to camera 0 unless it is empty. Whether the frame had labels.
  void step(const std::optional<LabelImage>& image, Micros image_offset_us = 0, Micros arrives_after_us = 20'000) {
    const Micros utime_us = kStart_us + kPeriod_us * frame_++;
    odometry(utime_us);
    SemanticCloud cloud;
    cloud.utime_us = utime_us;
    cloud.points = points;
    assembler_.addCloud(0, cloud, utime_us, frames_);
    if (image) {
      LabelImage stamped = *image;
      stamped.utime_us = utime_us + image_offset_us;
      pending_.push_back({utime_us + arrives_after_us, stamped.utime_us, encodeLabelImage(stamped)});
    }
    for (Micros now_us = utime_us; now_us < utime_us + kPeriod_us; now_us += 10'000) {
      odometry(now_us);
      deliver(now_us);
      take(now_us);
    }
  }

  /// A frame whose image is these bytes, whatever they are.
  void stepBytes(std::vector<std::uint8_t> bytes) {
    const Micros utime_us = kStart_us + kPeriod_us * frame_;
    pending_.push_back({utime_us + 20'000, utime_us, std::move(bytes)});
    step(std::nullopt);
  }

  void finish() {
    frames_.finish();
    assembler_.finish();
    take(kStart_us + kPeriod_us * (frame_ + 10));
  }

  const RigCounts& counts() const { return assembler_.counts(); }
  std::int64_t troubles(const std::string& what) const {
    const auto it = counts().troubles.find("front: " + what);
    return it == counts().troubles.end() ? 0 : it->second;
  }
  std::string standing() const { return counts().standing.empty() ? "" : counts().standing.front().text; }

  std::vector<Point> points = rig_scene::face(5, 1);  // of each cloud, body frame
  std::vector<Frame> out;
  std::vector<Micros> out_at_us;  // when each came out

 private:
  struct Pending {
    Micros arrives_us = 0, utime_us = 0;
    std::vector<std::uint8_t> bytes;
  };

  static Rig makeRig(std::vector<RigCamera> cameras) {
    Rig rig;
    rig.lidars.push_back({"lidar", "LIDAR"});
    rig.cameras = std::move(cameras);
    return rig;
  }
  void odometry(Micros utime_us) {
    if (utime_us > last_odometry_us_) {
      frames_.addOdometry({utime_us, turned(utime_us)});
      last_odometry_us_ = utime_us;
    }
  }
  void deliver(Micros now_us) {
    std::erase_if(pending_, [&](const Pending& p) {
      if (p.arrives_us <= now_us) {
        assembler_.addLabels(0, p.utime_us, p.bytes, now_us);
      }
      return p.arrives_us <= now_us;
    });
  }
  void take(Micros now_us) {
    while (auto frame = assembler_.next(now_us, frames_, 0)) {
      out.push_back(std::move(*frame));
      out_at_us.push_back(now_us);
    }
  }

  Rig rig_;
  FrameAssembler frames_{PairingLimits{}};
  RigAssembler assembler_;
  std::vector<Pending> pending_;
  Micros last_odometry_us_ = 0;
  std::int64_t frame_ = 0;
};

LabelImage cars() { return rig_scene::blank(rig_scene::camera("front", 0), kCar); }

double labelledShare(const Frame& frame) {
  const auto n = std::ranges::count_if(frame.points, [](const Point& p) { return p.label == kCar; });
  return static_cast<double>(n) / static_cast<double>(frame.points.size());
}

TEST(RigAssembler, LabelsEveryFrameInTheOrderOfTime) {
  RigDrive drive;
  for (int k = 0; k < 10; ++k) {
    drive.step(cars());
  }
  drive.finish();
  ASSERT_EQ(drive.out.size(), 10U);
  for (std::size_t k = 0; k < drive.out.size(); ++k) {
    EXPECT_EQ(drive.out[k].utime_us, kStart_us + kPeriod_us * static_cast<Micros>(k));
    EXPECT_EQ(labelledShare(drive.out[k]), 1);
  }
  EXPECT_TRUE(drive.counts().troubles.empty());
  EXPECT_TRUE(drive.counts().standing.empty());
}

/// Column x of the image says x + 1: the label of a point tells where it was looked up.
RigCamera rulerCamera() {
  RigCamera camera = rig_scene::camera("front", 0);
  camera.margin = 0;
  camera.label_set.class_of.clear();
  for (int k = 0; k <= camera.model.width; ++k) {
    camera.label_set.class_of.push_back(k);
  }
  return camera;
}

LabelImage ruler(const RigCamera& camera) {
  LabelImage image = rig_scene::blank(camera, 0);
  for (std::size_t i = 0; i < image.labels.size(); ++i) {
    image.labels[i] = static_cast<ClassId>(i % static_cast<std::size_t>(image.width) + 1);
  }
  return image;
}

/// Where the camera of a body turned by `angle` since the cloud sees a point, column.
double column(const RigCamera& camera, const Vec3& p_body, double angle) {
  const Vec3 p = Eigen::AngleAxisd(-angle, Vec3::UnitZ()) * p_body;
  return camera.model.cx - camera.model.fx * p.y() / p.x();
}

void expectWithinAPixel(const RigDrive& drive, const RigCamera& camera, double angle) {
  int seen = 0;
  for (const Point& p : drive.out.back().points) {
    if (p.label != kUnknownClass) {
      ++seen;
      EXPECT_NEAR(p.label - 1, column(camera, Vec3(p.x, p.y, p.z), angle), 0.51);
    }
  }
  EXPECT_GT(seen, 1000);
}

TEST(RigAssembler, ATurningRobotLooksUpPixelsAtTheImagesTime) {
  const RigCamera camera = rulerCamera();
  RigDrive drive({camera});
  for (int k = 0; k < 5; ++k) {
    drive.step(ruler(camera), 40'000, 60'000);  // exposed 40 ms after the cloud: the body has turned by 2.4 degrees
  }
  drive.finish();
  ASSERT_EQ(drive.out.size(), 5U);
  expectWithinAPixel(drive, camera, 60 * kDegree * 0.040);
}

TEST(RigAssembler, ATimeOffsetIsAddedToTheStamps) {
  RigCamera camera = rulerCamera();
  camera.offset_us = -30'000;  // stamped 30 ms after the exposure
  RigDrive drive({camera});
  for (int k = 0; k < 5; ++k) {
    drive.step(ruler(camera), 0);
  }
  drive.finish();
  expectWithinAPixel(drive, camera, -60 * kDegree * 0.030);
}

TEST(RigAssembler, ACameraThatDiesCostsLabelsOnlyAndIsNotWaitedForForEver) {
  RigDrive drive;
  for (int k = 0; k < 40; ++k) {
    drive.step(k < 10 ? std::optional(cars()) : std::nullopt);
  }
  EXPECT_NE(drive.standing().find("camera front gives no labels: no image in time"), std::string::npos);
  drive.finish();
  ASSERT_EQ(drive.out.size(), 40U);
  EXPECT_EQ(labelledShare(drive.out[9]), 1);
  EXPECT_EQ(labelledShare(drive.out[39]), 0);
  EXPECT_EQ(drive.out[39].points.size(), drive.points.size());  // geometry goes on
  EXPECT_GT(drive.troubles("no image in time"), 20);
  EXPECT_LE(drive.out_at_us[13] - drive.out[13].utime_us, 220'000);  // waited for as long as wait_s says
  EXPECT_EQ(drive.out_at_us[35], drive.out[35].utime_us);            // given up
}

TEST(RigAssembler, ACameraThatComesBackIsTakenAgain) {
  RigDrive drive;
  for (int k = 0; k < 60; ++k) {
    drive.step(k < 10 || k >= 40 ? std::optional(cars()) : std::nullopt);
  }
  EXPECT_EQ(drive.standing(), "");
  drive.finish();
  EXPECT_EQ(labelledShare(drive.out[35]), 0);
  EXPECT_EQ(labelledShare(drive.out[45]), 1);
  EXPECT_EQ(labelledShare(drive.out[59]), 1);
}

TEST(RigAssembler, ACameraThatLagsByThreeTenthsLabelsWithOlderImages) {
  const RigCamera camera = rulerCamera();
  RigDrive drive({camera});
  for (int k = 0; k < 20; ++k) {
    drive.step(ruler(camera), 0, 300'000);
  }
  EXPECT_NE(drive.standing().find("camera front is late"), std::string::npos);
  ASSERT_GT(drive.out.size(), 15U);
  EXPECT_LE(drive.out_at_us.back() - drive.out.back().utime_us, 220'000);  // no longer than wait_s
  EXPECT_GT(drive.troubles("late: labels of an older image are used"), 10);
  // 200 ms after the cloud the newest image is that of 100 ms before it: the body had turned 6 degrees less.
  expectWithinAPixel(drive, camera, -60 * kDegree * 0.100);
}

TEST(RigAssembler, AnImageOfTheWrongSizeIsLeftOut) {
  LabelImage small;
  small.width = 16, small.height = 12;
  small.labels.assign(16 * 12, kCar);
  RigDrive drive;
  for (int k = 0; k < 10; ++k) {
    drive.step(small);
  }
  EXPECT_NE(drive.standing().find("not of the size in the rig file"), std::string::npos);
  drive.finish();
  ASSERT_EQ(drive.out.size(), 10U);
  EXPECT_EQ(labelledShare(drive.out[9]), 0);
  EXPECT_EQ(drive.troubles("the image is not of the size in the rig file"), 10);
}

TEST(RigAssembler, AnotherLabelSetIsNoticed) {
  const LabelImage other = rig_scene::blank(rig_scene::camera("front", 0), 4711);
  RigDrive drive;
  for (int k = 0; k < 10; ++k) {
    drive.step(other);
  }
  EXPECT_NE(drive.standing().find("most labels are not in its label set"), std::string::npos);
  drive.finish();
  EXPECT_EQ(labelledShare(drive.out[9]), 0);
  EXPECT_EQ(drive.counts().labels.foreign, 10 * std::ssize(drive.points));
}

TEST(RigAssembler, DamagedImagesAreCountedByTheirFault) {
  RigDrive drive;
  std::vector<std::uint8_t> whole = encodeLabelImage(cars());
  std::vector<std::uint8_t> cut(whole.begin(), whole.end() - 9), corrupt = whole;
  corrupt[corrupt.size() / 2] ^= 0xFF;
  for (int k = 0; k < 4; ++k) {
    drive.stepBytes(cut);
    drive.stepBytes(corrupt);
    drive.step(cars());
  }
  drive.finish();
  EXPECT_EQ(drive.out.size(), 12U);
  std::int64_t bad = 0;
  for (const auto& [why, n] : drive.counts().troubles) {
    bad += n;
  }
  EXPECT_EQ(bad, 8);
  EXPECT_EQ(labelledShare(drive.out[11]), 1);
}

TEST(RigAssembler, AStampOutOfLineCostsItsOwnImage) {
  RigDrive drive;
  for (int k = 0; k < 12; ++k) {
    drive.step(cars(), k == 6 ? 500'000'000 : 0);
  }
  drive.finish();
  ASSERT_EQ(drive.out.size(), 12U);
  EXPECT_EQ(labelledShare(drive.out[11]), 1);
  EXPECT_EQ(drive.troubles("stamp late, twice or out of line"), 1);
}

TEST(RigAssembler, WithoutCamerasCloudsPassAtOnceAndUnlabelled) {
  RigDrive drive(std::vector<RigCamera>{});
  for (int k = 0; k < 5; ++k) {
    drive.step(std::nullopt);
  }
  ASSERT_EQ(drive.out.size(), 5U);
  EXPECT_EQ(drive.out_at_us[3], drive.out[3].utime_us);
  for (const Point& p : drive.out[3].points) {
    EXPECT_EQ(p.label, kUnknownClass);
  }
}

TEST(RigAssembler, ASecondLidarsCloudJoinsTheFirstAtItsTime) {
  Rig rig;
  rig.lidars = {{"front", "LIDAR_F"}, {"back", "LIDAR_B"}};
  RigAssembler assembler(rig, {}, [](Bytes b) { return decodeLabelImage(b); });
  FrameAssembler frames{PairingLimits{}};
  for (Micros t = kStart_us; t <= kStart_us + 300'000; t += 10'000) {
    frames.addOdometry({t, turned(t)});
  }
  const Vec3 post = Vec3(-10, 3, 0);  // world
  std::vector<Frame> out;
  for (int k = 0; k < 3; ++k) {
    const Micros utime_us = kStart_us + k * kPeriod_us, other_us = utime_us + 30'000;
    SemanticCloud front, back;
    front.utime_us = utime_us, back.utime_us = other_us;
    front.points = {{1, 2, 3, 0, 0}};
    const Eigen::Vector3f p = (turned(other_us).inverse() * post).cast<float>();
    back.points = {{p.x(), p.y(), p.z(), 0, 0}};
    assembler.addCloud(0, front, utime_us, frames);
    EXPECT_FALSE(assembler.next(utime_us, frames, 0));  // waits
    assembler.addCloud(1, back, other_us, frames);
    if (auto frame = assembler.next(other_us, frames, 0)) {
      out.push_back(std::move(*frame));
    }
  }
  ASSERT_EQ(out.size(), 3U);
  for (const Frame& frame : out) {
    ASSERT_EQ(frame.points.size(), 2U);
    const Point& p = frame.points[1];
    EXPECT_LT((turned(frame.utime_us) * Vec3(p.x, p.y, p.z) - post).norm(), 1e-3);
  }
}

}  // namespace
}  // namespace hgg::rig_assembler_test
