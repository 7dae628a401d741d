#include <gtest/gtest.h>

#include "bus/codec.h"
#include "bus/log.h"
#include "convert/label_ids.h"
#include "convert/semantickitti.h"
#include "tools/scratch.h"
#include "truth/poses.h"

namespace hgg::convert_test {
namespace {

const Progress kQuiet = [](std::size_t, std::size_t) {};
constexpr const char* kForwardPoses =
    "1 0 0 0 0 1 0 0 0 0 1 0\n"
    "1 0 0 1.5 0 1 0 0.25 0 0 1 -0.125\n"
    "0 -1 0 3 1 0 0 0.5 0 0 1 0\n";

/// Three frames of two points; frame k, point i lies at (k, i, 0.5) and has label word (k + 1) << 16 | label.
class KittiFolder {
 public:
  KittiFolder() {
    for (int k = 0; k < 3; ++k) {
      const float cloud[] = {float(k), 0, 0.5F, 0.9F, float(k), 1, 0.5F, 0.1F};
      const auto instance = static_cast<std::uint32_t>(k + 1) << 16;
      const std::uint32_t labels[] = {instance | 10, instance | 252};
      writeBinary<float>(scratch_ / ("velodyne/" + stem(k) + ".bin"), cloud);
      writeBinary<std::uint32_t>(scratch_ / ("labels/" + stem(k) + ".label"), labels);
    }
    writeText(path("poses.txt"), kForwardPoses);
  }
  static std::string stem(int k) { return "00000" + std::to_string(k); }
  std::filesystem::path path(const std::string& name) const { return scratch_ / name; }
  KittiOptions options() const {
    KittiOptions options;
    options.dir = scratch_ / "";
    return options;
  }

 private:
  Scratch scratch_;
};

struct Message {
  std::string channel;
  Micros timestamp_us;
  std::vector<std::uint8_t> data;
};

std::vector<Message> convertAndRead(const KittiFolder& folder, const KittiOptions& options) {
  const auto frames = listKittiFrames(options);
  EXPECT_TRUE(frames) << frames.error;
  EXPECT_EQ(convertKitti(*frames, folder.path("out.lcm"), kQuiet), "");
  auto reader = LogReader::open(folder.path("out.lcm").string());
  EXPECT_TRUE(reader) << reader.error;
  std::vector<Message> messages;
  while (auto event = reader->next()) {
    messages.push_back({event->channel, event->timestamp_us, event->data});
  }
  return messages;
}

void expectError(const KittiOptions& options, const std::string& part) {
  const auto frames = listKittiFrames(options);
  ASSERT_FALSE(frames);
  EXPECT_NE(frames.error.find(part), std::string::npos) << frames.error;
  EXPECT_EQ(frames.error.find('\n'), std::string::npos) << frames.error;
}

TEST(Convert, ElevationIsLiftedAndRangeAndBearingStay) {
  const KittiFolder folder;
  KittiOptions options = folder.options();
  const auto before = readKittiPoints(listKittiFrames(options)->back());
  options.elevation_deg = 0.205;
  const auto after = readKittiPoints(listKittiFrames(options)->back());
  ASSERT_EQ(before->size(), after->size());
  for (std::size_t i = 0; i < before->size(); ++i) {
    const Vec3 a((*before)[i].x, (*before)[i].y, (*before)[i].z), b((*after)[i].x, (*after)[i].y, (*after)[i].z);
    EXPECT_NEAR(a.norm(), b.norm(), 1e-6);
    EXPECT_NEAR(std::atan2(a.y(), a.x()), std::atan2(b.y(), b.x()), 1e-6);
    const auto elevation_deg = [](const Vec3& p) { return std::atan2(p.z(), std::hypot(p.x(), p.y())) * 180 / M_PI; };
    EXPECT_NEAR(elevation_deg(b) - elevation_deg(a), 0.205, 1e-4);
  }
}

TEST(Convert, FolderComesBackThroughTheLog) {
  const KittiFolder folder;
  writeText(folder.path("times.txt"), "1317042145.964\n1317042146.074001\n1.3170421461745e+09\n");
  const auto messages = convertAndRead(folder, folder.options());
  ASSERT_EQ(messages.size(), 6u);
  const Micros times_us[] = {1317042145964000, 1317042146074001, 1317042146174500};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto& pose = messages[2 * k];
    const auto& cloud = messages[2 * k + 1];
    ASSERT_EQ(pose.channel, "POSE_ODOM");
    ASSERT_EQ(cloud.channel, "LIDAR_SEMANTIC");
    EXPECT_EQ(pose.timestamp_us, times_us[k]);
    EXPECT_EQ(cloud.timestamp_us, times_us[k]);
    const auto decoded = decodeSemanticCloud(cloud.data, 0.0F);
    ASSERT_TRUE(decoded) << decoded.error;
    EXPECT_EQ(decoded->utime_us, times_us[k]);
    ASSERT_EQ(decoded->points.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) {
      const Point& p = decoded->points[i];
      EXPECT_EQ(Vec3(p.x, p.y, p.z), Vec3(double(k), double(i), 0.5));
      EXPECT_EQ(p.label, i == 0 ? 10 : 252);
      EXPECT_EQ(p.instance, k + 1);
    }
  }
  const auto last = decodePose(messages[4].data);
  ASSERT_TRUE(last) << last.error;
  EXPECT_EQ(last->utime_us, times_us[2]);
  EXPECT_LT((last->T_odom_body * Vec3(1, 0, 0) - Vec3(3, 1.5, 0)).norm(), 1e-12);
}

TEST(Convert, SameFolderSameBytes) {
  const KittiFolder folder;
  const auto frames = listKittiFrames(folder.options());
  ASSERT_EQ(convertKitti(*frames, folder.path("a"), kQuiet), "");
  ASSERT_EQ(convertKitti(*frames, folder.path("b"), kQuiet), "");
  EXPECT_FALSE(readText(folder.path("a")).empty());
  EXPECT_EQ(readText(folder.path("a")), readText(folder.path("b")));
}

TEST(Convert, WithoutTimesFramesComeAtTheRate) {
  const KittiFolder folder;
  auto options = folder.options();
  EXPECT_EQ(listKittiFrames(options)->at(2).utime_us, 200'000);
  options.rate_hz = 4.0;
  EXPECT_EQ(listKittiFrames(options)->at(2).utime_us, 500'000);
  writeText(folder.path("times.txt"), "5\n6\n7\n");
  EXPECT_EQ(listKittiFrames(options)->at(2).utime_us, 500'000);
  options.rate_hz.reset();
  EXPECT_EQ(listKittiFrames(options)->at(2).utime_us, 7'000'000);
}

TEST(Convert, OdometryIsPreferredAndPosesCanBeChosen) {
  const KittiFolder folder;
  writeText(folder.path("odometry.txt"), "1 0 0 9 0 1 0 0 0 0 1 0\n1 0 0 9 0 1 0 0 0 0 1 0\n1 0 0 9 0 1 0 0 0 0 1 0\n");
  auto options = folder.options();
  EXPECT_EQ(listKittiFrames(options)->at(0).T_world_body.translation().x(), 9.0);
  options.poses = folder.path("poses.txt");
  EXPECT_EQ(listKittiFrames(options)->at(1).T_world_body.translation().x(), 1.5);
}

TEST(Convert, FramesOfAPartOfASequenceTakeTheirOwnRows) {
  const KittiFolder folder;
  std::filesystem::remove(folder.path("velodyne/000000.bin"));
  const auto frames = listKittiFrames(folder.options());
  ASSERT_TRUE(frames) << frames.error;
  ASSERT_EQ(frames->size(), 2u);
  EXPECT_EQ(frames->at(0).T_world_body.translation().x(), 1.5);
  EXPECT_EQ(frames->at(0).utime_us, 100'000);
}

TEST(Convert, OtherLabelFolderIsRead) {
  const KittiFolder folder;
  auto options = folder.options();
  options.labels = "predictions";
  expectError(options, "predictions");
  std::filesystem::copy(folder.path("labels"), folder.path("predictions"));
  const std::uint32_t words[] = {72, 40};
  writeBinary<std::uint32_t>(folder.path("predictions/000000.label"), words);
  const auto points = readKittiPoints(listKittiFrames(options)->at(0));
  EXPECT_EQ((*points)[0].label, 72);
  EXPECT_EQ((*points)[0].instance, 0u);
}

TEST(Convert, MissingFolderIsAnError) {
  KittiOptions options;
  options.dir = "/nonexistent/sequence";
  expectError(options, "/nonexistent/sequence/velodyne");
}

TEST(Convert, EmptyFolderIsAnError) {
  const KittiFolder folder;
  std::filesystem::remove_all(folder.path("velodyne"));
  writeText(folder.path("velodyne/readme.txt"), "not a frame");
  expectError(folder.options(), "no frames");
}

TEST(Convert, LabelCountUnlikePointCountIsAnError) {
  const KittiFolder folder;
  const std::uint32_t one[] = {10};
  writeBinary<std::uint32_t>(folder.path("labels/000001.label"), one);
  expectError(folder.options(), "000001.label holds 1 labels for the 2 points");
}

TEST(Convert, MissingLabelFileIsAnError) {
  const KittiFolder folder;
  std::filesystem::remove(folder.path("labels/000002.label"));
  expectError(folder.options(), "000002.label");
}

TEST(Convert, CutCloudIsAnError) {
  const KittiFolder folder;
  std::filesystem::resize_file(folder.path("velodyne/000001.bin"), 31);
  expectError(folder.options(), "000001.bin is cut");
}

TEST(Convert, FewerPosesThanFramesIsAnError) {
  const KittiFolder folder;
  writeText(folder.path("poses.txt"), "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 0\n");
  expectError(folder.options(), "has 2 rows, but frame 000002 needs row 3");
}

TEST(Convert, FewerTimesThanFramesIsAnError) {
  const KittiFolder folder;
  writeText(folder.path("times.txt"), "0.0\n0.1\n");
  expectError(folder.options(), "has 2 rows, but frame 000002 needs row 3");
}

TEST(Convert, TimeThatDoesNotIncreaseIsAnError) {
  const KittiFolder folder;
  writeText(folder.path("times.txt"), "0.0\n0.1\n0.1\n");
  expectError(folder.options(), "the time of frame 000002");
}

TEST(Convert, MissingPosesAreAnError) {
  const KittiFolder folder;
  std::filesystem::remove(folder.path("poses.txt"));
  expectError(folder.options(), "poses.txt");
}

TEST(Convert, PoseRowThatIsNoRigidTransformIsAnError) {
  const KittiFolder folder;
  for (const char* row : {"1 0 0 0 0 1 0 0 0 0 1\n", "1 0 0 0 0 1 0 0 0 0 1 0 0\n", "1 0 0 x 0 1 0 0 0 0 1 0\n",
                          "2 0 0 0 0 2 0 0 0 0 2 0\n", "1 0 0 nan 0 1 0 0 0 0 1 0\n", "1 0 0 0 0 1 0 0 0 0 -1 0\n",
                          "0 0 0 0 0 0 0 0 0 0 0 0\n"}) {
    writeText(folder.path("poses.txt"), "# poses\n\n" + std::string(row));
    expectError(folder.options(), "poses.txt line 3");
  }
}

// ------------------------------------------------------------------------------- poses of the camera

// Of KITTI's sequence 00.
constexpr const char* kCalib =
    "P0: 7.188560000000e+02 0 6.071928000000e+02 0 0 7.188560000000e+02 1.852157000000e+02 0 0 0 1 0\n"
    "Tr: 4.276802385584e-04 -9.999672484946e-01 -8.084491683471e-03 -1.198459927713e-02 -7.210626507497e-03 "
    "8.081198471645e-03 -9.999413164504e-01 -5.403984729748e-02 9.999738645903e-01 4.859485810390e-04 "
    "-7.206933692422e-03 -2.921968648686e-01\n";

/// The poses of the folder as those of the camera.
std::vector<Pose> cameraPoses(const KittiFolder& folder) {
  writeText(folder.path("calib.txt"), kCalib);
  const Pose T = *readCameraLidar(folder.path("calib.txt"));
  return lidarPoses(*readPoses(folder.path("poses.txt")), T.inverse());
}

TEST(Convert, PosesOfTheCameraAreTakenToTheLidar) {
  const KittiFolder folder;
  const auto expected = *readPoses(folder.path("poses.txt"));
  const auto camera = cameraPoses(folder);
  EXPECT_GT(std::abs(camera[1].translation().z()), 1.0);
  ASSERT_EQ(writePoses(camera, folder.path("poses.txt")), "");
  const auto frames = listKittiFrames(folder.options());
  ASSERT_TRUE(frames) << frames.error;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_TRUE(frames->at(i).T_world_body.isApprox(expected[i], 1e-9)) << i;
    EXPECT_TRUE(frames->at(i).pose_was_cameras);
  }
}

TEST(Convert, PosesOfTheLidarBesideACalibrationStayAsTheyAre) {
  const KittiFolder folder;
  writeText(folder.path("calib.txt"), kCalib);
  const auto frames = listKittiFrames(folder.options());
  ASSERT_TRUE(frames) << frames.error;
  EXPECT_FALSE(frames->at(1).pose_was_cameras);
  EXPECT_EQ(frames->at(1).T_world_body.translation().x(), 1.5);
}

TEST(Convert, PosesOfTheCameraWithoutItsCalibrationAreRefused) {
  const KittiFolder folder;
  ASSERT_EQ(writePoses(cameraPoses(folder), folder.path("poses.txt")), "");
  std::filesystem::remove(folder.path("calib.txt"));
  expectError(folder.options(), "poses.txt holds poses of the camera (they go along z); cannot read");
  writeText(folder.path("calib.txt"), "P0: 1 0 0 0 0 1 0 0 0 0 1 0\n");
  expectError(folder.options(), "calib.txt has no line Tr:");
  writeText(folder.path("calib.txt"), "Tr: 1 0 0 0 0 1 0 0 0 0\n");
  expectError(folder.options(), "calib.txt: Tr: is not followed by a 3x4 rigid transform");
  auto options = folder.options();
  options.pose_frame = PoseFrame::kLidar;
  EXPECT_FALSE(listKittiFrames(options)->at(1).pose_was_cameras);
}

TEST(Convert, WhereItCannotBeToldWhosePosesTheyAreItMustBeSaid) {
  const KittiFolder folder;
  writeText(folder.path("calib.txt"), kCalib);
  writeText(folder.path("poses.txt"), "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 0\n");
  expectError(folder.options(), "--pose-frame camera or lidar says it");
  auto options = folder.options();
  options.pose_frame = PoseFrame::kCamera;
  EXPECT_TRUE(listKittiFrames(options)->at(1).pose_was_cameras);
  options.pose_frame = PoseFrame::kLidar;
  EXPECT_FALSE(listKittiFrames(options)->at(1).pose_was_cameras);
}

TEST(Convert, TheWayTellsWhosePosesTheyAre) {
  const auto drive = [](const Vec3& step, const Vec3& axis) {
    std::vector<Pose> poses{Pose::Identity()};
    for (int k = 0; k < 40; ++k) {
      Pose T = Pose::Identity();
      T.linear() = Eigen::AngleAxisd(0.1, axis).toRotationMatrix();
      T.translation() = step;
      poses.push_back(poses.back() * T);
    }
    return poses;
  };
  EXPECT_EQ(judgePoseFrame(drive({0.8, 0.05, 0.02}, Vec3::UnitZ())), PoseFrame::kLidar);
  EXPECT_EQ(judgePoseFrame(drive({0.1, 0, 0}, Vec3::UnitZ())), PoseFrame::kLidar);
  EXPECT_EQ(judgePoseFrame(drive({-0.8, 0, 0}, Vec3::UnitZ())), PoseFrame::kLidar);
  EXPECT_EQ(judgePoseFrame(drive({0.05, 0.02, 0.8}, Vec3::UnitY())), PoseFrame::kCamera);
  EXPECT_EQ(judgePoseFrame(drive({0, 0, 0.01}, Vec3::UnitY())), PoseFrame::kUnknown);  // stands
  EXPECT_EQ(judgePoseFrame(drive({0.8, 0, 0.8}, Vec3::UnitY())), PoseFrame::kUnknown);
  EXPECT_EQ(judgePoseFrame({}), PoseFrame::kUnknown);
}

// ------------------------------------------------------------------------------------------ training ids

void labelAll(const KittiFolder& folder, std::uint32_t first, std::uint32_t second) {
  for (int k = 0; k < 3; ++k) {
    const std::uint32_t words[] = {first | 7U << 16, second};
    writeBinary<std::uint32_t>(folder.path("labels/" + KittiFolder::stem(k) + ".label"), words);
  }
}

TEST(Convert, TrainingIdsAreRecognised) {
  const KittiFolder folder;
  const auto looksLikeThem = [&](std::uint32_t a, std::uint32_t b) {
    labelAll(folder, a, b);
    return hasLearningIds(*listKittiFrames(folder.options()));
  };
  EXPECT_TRUE(looksLikeThem(1, 9));
  EXPECT_TRUE(looksLikeThem(13, 19));
  EXPECT_FALSE(looksLikeThem(10, 40));
  EXPECT_FALSE(looksLikeThem(9, 252));
  EXPECT_FALSE(looksLikeThem(0, 10));  // both are raw ids, too
}

TEST(Convert, TrainingIdsBecomeRawOnesWhereAsked) {
  const KittiFolder folder;
  labelAll(folder, 1, 13);
  auto options = folder.options();
  EXPECT_EQ(readKittiPoints(listKittiFrames(options)->at(0))->at(1).label, 13);
  options.learning_ids = true;
  const auto points = readKittiPoints(listKittiFrames(options)->at(0));
  EXPECT_EQ(points->at(0).label, 10);
  EXPECT_EQ(points->at(0).instance, 7U);
  EXPECT_EQ(points->at(1).label, 50);
  EXPECT_EQ(rawOfLearningId(19), 81);
  EXPECT_EQ(rawOfLearningId(20), 20);
}

TEST(Convert, UnwritableLogIsAnError) {
  const KittiFolder folder;
  const auto frames = listKittiFrames(folder.options());
  EXPECT_NE(convertKitti(*frames, folder.path("no/such/dir/out.lcm"), kQuiet), "");
}

}  // namespace
}  // namespace hgg::convert_test
