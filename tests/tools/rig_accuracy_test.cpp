// How well labels get from images to points, on a simulated rig whose segmenter bleeds: in the simulator it is known
// what each point is of.
#include <gtest/gtest.h>

#include <cstdio>

#include "bus/codec.h"
#include "bus/log.h"
#include "core/units.h"
#include "frame/labelling.h"
#include "sim/simulate.h"
#include "tools/scratch.h"

namespace hgg::rig_accuracy_test {
namespace {

using Channels = std::map<std::string, std::map<Micros, std::vector<std::uint8_t>>>;

/// A drive through the yard with three cameras whose masks go wrong as `errors` say; points have their true labels.
Channels drive(const Scratch& scratch, const LabelErrors& errors) {
  SimOptions options;
  options.frames = 6;
  options.rate_hz = 0.5;
  options.sensors = {spinningLidar(64, false), rigCameras(3)};
  options.image_labels = errors;
  options.perfect_transfer = true;
  options.walk_grid = false;
  options.threads = 2;
  const auto result = simulate(makeYard(3), options, scratch / "rig.lcm", [](std::size_t, std::size_t) {});
  EXPECT_TRUE(result) << result.error;
  auto reader = LogReader::open((scratch / "rig.lcm").string());
  Channels channels;
  while (auto event = reader->next()) {
    channels[event->channel][event->timestamp_us] = event->data;
  }
  return channels;
}

struct Share {
  std::int64_t right = 0, all = 0;
  double value() const { return static_cast<double>(right) / static_cast<double>(all); }
};

/// Pixels that are right, of those whose neighbours up to 2 pixels away truly are of one label.
Share pixelAccuracy(const Channels& channels, const Channels& truth, const Rig& rig) {
  Share share;
  for (const RigCamera& camera : rig.cameras) {
    for (const auto& [utime_us, message] : truth.at(camera.labels)) {
      const LabelImage is = *decodeLabelImage(message),
                       said = *decodeLabelImage(channels.at(camera.labels).at(utime_us));
      for (int y = 2; y < is.height - 2; ++y) {
        for (int x = 2; x < is.width - 2; ++x) {
          const ClassId label = is.labels[is.at(x, y)];
          bool is_inside = label != 0;
          for (int k = 0; k < 25 && is_inside; ++k) {
            is_inside = is.labels[is.at(x + k % 5 - 2, y + k / 5 - 2)] == label;
          }
          share.all += is_inside ? 1 : 0;
          share.right += is_inside && said.labels[is.at(x, y)] == label ? 1 : 0;
        }
      }
    }
  }
  return share;
}

struct Transfer {
  Share points;           // that got a label and truly have one
  std::int64_t seen = 0;  // that a camera truly sees
};

/// Labels the clouds of the drive anew.
Transfer transfer(const Channels& channels, Rig rig, int margin) {
  for (RigCamera& camera : rig.cameras) {
    camera.margin = margin;
  }
  Transfer out;
  for (const auto& [utime_us, message] : channels.at("LIDAR")) {
    std::vector<Point> points = decodeCloud(message)->points;
    const std::vector<Point> truth = decodeSemanticCloud(channels.at("LIDAR_SEMANTIC").at(utime_us), 0)->points;
    std::vector<LabelImage> images;
    for (const RigCamera& camera : rig.cameras) {
      images.push_back(*decodeLabelImage(channels.at(camera.labels).at(utime_us)));
    }
    std::vector<LabelView> views;
    for (std::size_t k = 0; k < images.size(); ++k) {
      views.push_back({&rig.cameras[k], &images[k], k, rig.cameras[k].T_body_camera.inverse(),
                       rig.cameras[k].T_body_camera.translation().norm()});
    }
    labelPoints(points, views, {0.45 * kDegree, 0});
    for (std::size_t i = 0; i < points.size(); ++i) {
      out.seen += truth[i].label != 0 ? 1 : 0;
      if (truth[i].label != 0 && points[i].label != kUnknownClass) {
        ++out.points.all;
        out.points.right += points[i].label == truth[i].label ? 1 : 0;
      }
    }
  }
  return out;
}

TEST(RigAccuracy, PointsAreLabelledAsWellAsPixelsAwayFromBorders) {
  const Scratch bled, clean;
  LabelErrors errors = *labelPreset("good", Segmented::kImage);
  errors.confused = errors.missed = 0;  // those are no matter of carrying labels over
  const Channels channels = drive(bled, errors), truth = drive(clean, {});
  const auto rig = loadRig((bled / "rig.rig.toml").string(), ClassTable::builtin());
  ASSERT_TRUE(rig) << rig.error;
  const Share pixels = pixelAccuracy(channels, truth, *rig);
  const Transfer blind = transfer(channels, *rig, 0), careful = transfer(channels, *rig, 2);
  std::printf("pixels away from borders %.4f; points %.4f of %.3f seen, without a margin %.4f of %.3f\n",
              pixels.value(), careful.points.value(),
              static_cast<double>(careful.points.all) / static_cast<double>(careful.seen), blind.points.value(),
              static_cast<double>(blind.points.all) / static_cast<double>(blind.seen));
  EXPECT_GT(pixels.all, 100'000);
  EXPECT_GE(careful.points.value(), 0.97 * pixels.value());
  EXPECT_GT(careful.points.value(), blind.points.value());
  EXPECT_GE(careful.points.all, 0.95 * static_cast<double>(careful.seen));
}

}  // namespace
}  // namespace hgg::rig_accuracy_test
