#include <CLI/CLI.hpp>
#include <cstdio>

#include "convert/kitti_truth.h"
#include "convert/label_ids.h"
#include "convert/label_images.h"
#include "convert/rosbag_command.h"
#include "convert/semantickitti.h"
#include "sim/odometry.h"

namespace {

constexpr int kBadInput = 2;

constexpr const char* kKittiHelp = R"(Converts a folder in the SemanticKITTI layout into an LCM log:
  DIR/velodyne/NNNNNN.bin   x y z intensity, f32 each, LiDAR frame
  DIR/labels/NNNNNN.label   u32 a point: low 16 bits class, high 16 bits instance
  DIR/times.txt             seconds, one row a frame (optional)
  DIR/calib.txt             Tr: camera from LiDAR (needed for poses of the camera)
Poses are 3x4 rows, one a frame, of the LiDAR or of the camera, as in the downloads of KITTI odometry and SemanticKITTI:
the way they go tells which. With Tr of calib.txt a row of the camera becomes inv(Tr) * row * Tr.)";

constexpr const char* kTruthHelp =
    R"(Writes the true objects of such a folder for hgg-eval: gt_objects.json and poses.txt,
in the frame of the poses. Points with an instance id are gathered per object over all frames; objects that move are marked
dynamic, from the tracks of a boxes.csv or, without one, from their points.)";

struct Arguments {
  hgg::KittiOptions kitti;
  std::string output;
  std::optional<std::filesystem::path> boxes;
  std::string pose_frame = "auto", label_ids = "auto";
  std::string odometry;  // of odometryPreset(); empty: the poses as they are
  std::uint64_t seed = 1;
  bool label_images = false;
  int bleed = 2;
};

int fail(const std::string& error) {
  std::fprintf(stderr, "hgg-convert: %s\n", error.c_str());
  return kBadInput;
}

void addPoseFrame(CLI::App& sub, Arguments& args) {
  sub.add_option("--pose-frame", args.pose_frame, "what the poses are of: auto judges by the way they go")
      ->check(CLI::IsMember({"auto", "lidar", "camera"}))
      ->capture_default_str();
}

void addLabelIds(CLI::App& sub, Arguments& args) {
  sub.add_option(
         "--label-ids", args.label_ids,
         "learning: labels are SemanticKITTI's training ids 0..19, made raw ones; raw: taken as they are; auto: "
         "as they are, unless they look like training ids")
      ->check(CLI::IsMember({"auto", "raw", "learning"}))
      ->capture_default_str();
}

void addElevation(CLI::App& sub, Arguments& args) {
  args.kitti.elevation_deg = hgg::kKittiElevation_deg;
  sub.add_option("--elevation", args.kitti.elevation_deg,
                 "lift all points by this angle: KITTI's HDL-64 measures too low; 0 for other sensors")
      ->type_name("DEG")
      ->check(CLI::Range(-5.0, 5.0))
      ->capture_default_str();
}

CLI::App* addSemanticKitti(CLI::App& app, Arguments& args) {
  CLI::App* sub = app.add_subcommand("semantickitti", kKittiHelp);
  sub->add_option("DIR", args.kitti.dir, "folder with velodyne/")->required();
  sub->add_option("-o,--output", args.output, "LCM log to write")->required()->type_name("LOG");
  sub->add_option("--labels", args.kitti.labels, "label folder below DIR")->type_name("SUB")->capture_default_str();
  sub->add_option("--poses", args.kitti.poses, "poses [DIR/odometry.txt, else DIR/poses.txt]")->type_name("FILE");
  addPoseFrame(*sub, args);
  addLabelIds(*sub, args);
  sub->add_option("--rate", args.kitti.rate_hz, "frames a second [DIR/times.txt, else 10]")
      ->type_name("HZ")
      ->check(CLI::Range(0.001, 10000.0));
  addElevation(*sub, args);
  auto* drift =
      sub->add_option("--odometry", args.odometry, "let the poses of --poses drift as hgg-sim --odometry does")
          ->check(CLI::IsMember(hgg::odometryPresetNames()))
          ->needs("--poses");
  sub->add_option("--seed", args.seed, "of that drift")->capture_default_str()->needs(drift);
  auto* images =
      sub->add_flag("--label-images", args.label_images,
                    "what a rig sends instead of labelled clouds: LIDAR without labels, label images of four "
                    "cameras around it, and LOG's name with .rig.toml");
  sub->add_option("--bleed", args.bleed, "pixels by which the masks of these images bleed over what is behind")
      ->capture_default_str()
      ->check(CLI::Range(0, 20))
      ->needs(images);
  sub->footer("Example:\n  hgg-convert semantickitti sequences/00 -o 00.lcm --poses 00_lidar_poses.txt");
  return sub;
}

CLI::App* addKittiTruth(CLI::App& app, Arguments& args) {
  CLI::App* sub = app.add_subcommand("kitti-truth", kTruthHelp);
  sub->add_option("DIR", args.kitti.dir, "folder with velodyne/")->required();
  sub->add_option("-o,--output", args.output, "truth directory to write")->required()->type_name("TRUTH_DIR");
  sub->add_option("--labels", args.kitti.labels, "label folder below DIR [gt_labels]")->type_name("SUB");
  sub->add_option("--poses", args.kitti.poses, "true poses [DIR/poses.txt]")->type_name("FILE");
  addPoseFrame(*sub, args);
  addLabelIds(*sub, args);
  sub->add_option("--boxes", args.boxes, "csv with track_id, cx_world, cy_world")->type_name("CSV");
  addElevation(*sub, args);
  sub->footer("Example:\n  hgg-convert kitti-truth kitti_0001 -o truth --boxes kitti_0001/boxes.csv");
  return sub;
}

/// The frames of the folder, with what was made of its poses and labels said on stderr.
hgg::Result<std::vector<hgg::KittiFrame>> listFrames(const Arguments& args) {
  hgg::KittiOptions kitti = args.kitti;
  kitti.learning_ids = args.label_ids == "learning";
  kitti.pose_frame = args.pose_frame == "lidar"    ? hgg::PoseFrame::kLidar
                     : args.pose_frame == "camera" ? hgg::PoseFrame::kCamera
                                                   : hgg::PoseFrame::kUnknown;
  auto frames = hgg::listKittiFrames(kitti);
  if (!frames) {
    return frames;
  }
  if (args.label_ids == "auto" && hgg::hasLearningIds(*frames)) {
    return hgg::Result<std::vector<hgg::KittiFrame>>::fail(
        "the labels of " + (kitti.dir / kitti.labels).string() +
        " are no raw SemanticKITTI ids but look like the training ids 0..19 of learning_map: --label-ids learning "
        "converts them, --label-ids raw takes them as they are");
  }
  if (frames->front().pose_was_cameras) {
    std::fprintf(stderr, "hgg-convert: the poses are the camera's: taken to the LiDAR with Tr of calib.txt\n");
  }
  return frames;
}

/// Replaces the poses by those of an odometry that drifts from the first one on.
void letDrift(std::vector<hgg::KittiFrame>& frames, const Arguments& args) {
  const hgg::Pose T_world_start = frames.front().T_world_body;
  std::vector<hgg::Pose> T_start_body;
  for (const hgg::KittiFrame& frame : frames) {
    T_start_body.push_back(T_world_start.inverse() * frame.T_world_body);
  }
  T_start_body = hgg::disturbOdometry(T_start_body, *hgg::odometryPreset(args.odometry), args.seed);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i].T_world_body = T_world_start * T_start_body[i];
  }
}

int convert(const Arguments& args) {
  auto frames = listFrames(args);
  if (!frames) {
    return fail(frames.error);
  }
  if (!args.odometry.empty()) {
    letDrift(*frames, args);
  }
  hgg::ProgressBar bar("convert");
  const std::string error = args.label_images ? hgg::convertKittiToRig(*frames, args.bleed, args.output, onBar(bar))
                                              : hgg::convertKitti(*frames, args.output, onBar(bar));
  return error.empty() ? 0 : fail(error);
}

int writeTruth(Arguments args, bool labels_given) {
  if (!labels_given) {
    args.kitti.labels = "gt_labels";
  }
  if (args.kitti.poses.empty()) {
    args.kitti.poses = args.kitti.dir / "poses.txt";
  }
  const auto frames = listFrames(args);
  if (!frames) {
    return fail(frames.error);
  }
  hgg::ProgressBar bar("truth");
  const auto objects = hgg::kittiTruth(*frames, args.boxes, onBar(bar));
  if (!objects) {
    return fail(objects.error);
  }
  std::vector<hgg::Pose> poses;
  for (const hgg::KittiFrame& frame : *frames) {
    poses.push_back(frame.T_world_body);
  }
  const std::string error = hgg::writeTruth(*objects, poses, args.output);
  return error.empty() ? 0 : fail(error);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("hgg-convert: data sets -> LCM log for hggmap, truth for hgg-eval");
  app.require_subcommand(1);
  app.footer(
      "Example:\n  hgg-convert semantickitti kitti_0001 -o kitti.lcm\n  hgg-convert rosbag drive.bag -o "
      "drive.lcm\nExit codes: 0 done, 2 bad input or usage.");
  Arguments args;
  CLI::App* kitti = addSemanticKitti(app, args);
  CLI::App* truth = addKittiTruth(app, args);
  std::function<int()> rosbag;
  hgg::addRosbag(app, rosbag);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return e.get_exit_code() == 0 ? app.exit(e) : fail(std::string(e.what()) + " (see --help)");
  }
  return rosbag ? rosbag() : kitti->parsed() ? convert(args) : writeTruth(args, truth->count("--labels") > 0);
}
