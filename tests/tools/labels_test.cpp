#include "sim/labels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace hgg::labels_test {
namespace {

constexpr int kSize = 200;
constexpr int kStripe = 10;  // pixels of one object

/// Objects side by side as upright stripes of `kStripe` pixels, one degree a pixel: things 10, 11, 15 in turn, the
/// first one stuff 40.
struct Stripes {
  World world;
  RayGrid grid;
  Scan scan;

  Stripes() {
    grid.width = kSize, grid.height = kSize;
    grid.pitch_x_deg = grid.pitch_y_deg = 1.0;
    grid.directions.assign(kSize * kSize, Vec3::UnitX());
    scan.range.assign(grid.size(), 5.0F);
    scan.object.resize(grid.size());
    const std::vector<ClassId> labels{10, 11, 15};
    for (std::size_t i = 0; i < kSize / kStripe; ++i) {
      const ClassId label = i == 0 ? 40 : labels[i % 3];
      const ClassId confused_with = i > 0 && i % 2 == 1 ? 99 : 0;
      addObject(world, {.label = label, .thing = i > 0, .confused_with = confused_with, .name = ""}, {});
    }
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        scan.object[grid.at(x, y)] = x / kStripe;
      }
    }
  }

  ClassId truth(std::size_t i) const { return world.objects[static_cast<std::size_t>(scan.object[i])].label; }
  LabelImage label(const LabelErrors& errors, std::size_t frame, bool instances = false, int threads = 1) const {
    return segment({&world, errors, worldLabels(world), instances}, grid, scan, objectLabels(world, errors, 1, frame),
                   keyFor(1, Purpose::kPixelLabels, 0, frame), threads);
  }
};

World fleet(int size) {
  World world;
  for (int i = 0; i < size; ++i) {
    addObject(world, {.label = 10, .thing = true, .confused_with = 18, .name = "car"}, {});
  }
  return world;
}

double bound(double share, double n) { return 4.0 * std::sqrt(share * (1.0 - share) / n); }

TEST(Labels, PerfectLabelsAreTheTruth) {
  const Stripes stripes;
  const LabelImage image = stripes.label(*labelPreset("perfect", Segmented::kImage), 0, true);
  for (std::size_t i = 0; i < image.labels.size(); ++i) {
    ASSERT_EQ(image.labels[i], stripes.truth(i));
    ASSERT_EQ(image.instances[i], stripes.scan.object[i] == 0 ? 0 : stripes.scan.object[i] + 1);
  }
}

TEST(Labels, SpeckleAndUnknownComeAtTheirRates) {
  const Stripes stripes;
  const LabelErrors errors{.speckle = 0.03, .unknown = 0.02};
  double speckle = 0, unknown = 0, n = 0;
  std::set<ClassId> drawn;
  for (std::size_t frame = 0; frame < 10; ++frame) {
    const LabelImage image = stripes.label(errors, frame);
    for (std::size_t i = 0; i < image.labels.size(); ++i, ++n) {
      if (image.labels[i] == stripes.truth(i)) {
        continue;
      }
      (image.labels[i] == 0 ? unknown : speckle) += 1;
      drawn.insert(image.labels[i]);
    }
  }
  EXPECT_NEAR(speckle / n, 0.03, bound(0.03, n));
  EXPECT_NEAR(unknown / n, 0.02, bound(0.02, n));
  EXPECT_EQ(drawn, (std::set<ClassId>{0, 10, 11, 15, 40}));
}

TEST(Labels, BordersBleedAtTheirRateInClumps) {
  const Stripes stripes;
  const LabelErrors errors{.bleed = 0.4, .bleed_deg = 2.0};
  double bled = 0, border = 0, pairs = 0, same = 0;
  constexpr int kFrames = 20;
  for (std::size_t frame = 0; frame < kFrames; ++frame) {
    const LabelImage image = stripes.label(errors, frame);
    for (int y = 0; y < kSize; ++y) {
      for (int x = kStripe; x < kSize - kStripe; ++x) {
        const std::size_t i = stripes.grid.at(x, y);
        const int within = x % kStripe;
        const bool is_border = within < 2 || within >= kStripe - 2;
        const bool wrong = image.labels[i] != stripes.truth(i);
        ASSERT_TRUE(is_border || !wrong);
        border += is_border, bled += wrong;
        if (!is_border) {
          continue;
        }
        const int side = within < 2 ? -kStripe : kStripe;
        ASSERT_TRUE(!wrong || image.labels[i] == stripes.truth(stripes.grid.at(x + side, y)));
        if (y % 4 < 3 && wrong) {
          pairs += 1, same += image.labels[stripes.grid.at(x, y + 1)] == image.labels[i];
        }
      }
    }
  }
  const double clumps = kFrames * (kSize / 4) * (kSize / 4);
  EXPECT_NEAR(bled / border, 0.4, bound(0.4, clumps / 2));
  EXPECT_EQ(same, pairs);
}

TEST(Labels, BleedingReachesAcrossTheSeamOfATurnOnly) {
  Stripes stripes;
  const LabelErrors errors{.bleed = 1.0, .bleed_deg = 1.0};
  const std::size_t corner = stripes.grid.at(0, 100);
  EXPECT_EQ(stripes.label(errors, 0).labels[corner], 40);
  stripes.grid.wraps = true;
  EXPECT_EQ(stripes.label(errors, 0).labels[corner], stripes.world.objects.back().label);
}

TEST(Labels, ConfusionAndMissesComeAtTheirRates) {
  const World world = fleet(400);
  const LabelErrors errors{.confused = 0.1, .missed = 0.05, .stretch_frames = 10};
  double confused = 0, missed = 0;
  constexpr int kFrames = 500;
  for (std::size_t frame = 0; frame < kFrames; ++frame) {
    for (const ClassId label : objectLabels(world, errors, 1, frame)) {
      confused += label == 18, missed += label == 0;
    }
  }
  const double pairs = 400.0 * kFrames, stretches = pairs / 10;
  EXPECT_NEAR(confused / pairs, 0.1, bound(0.1, stretches));
  EXPECT_NEAR(missed / pairs, 0.05, bound(0.05, stretches));
}

TEST(Labels, ConfusionLastsForAStretch) {
  const World world = fleet(100);
  const LabelErrors errors{.confused = 0.2, .stretch_frames = 12};
  std::vector<ClassId> before = objectLabels(world, errors, 3, 0);
  std::vector<std::size_t> since(100, 0);
  std::set<std::size_t> change_frames;
  for (std::size_t frame = 1; frame < 200; ++frame) {
    const auto labels = objectLabels(world, errors, 3, frame);
    for (std::size_t i = 0; i < 100; ++i) {
      if (labels[i] == before[i]) {
        continue;
      }
      if (since[i] > 0) {
        EXPECT_EQ((frame - since[i]) % 12, 0u);
      }
      since[i] = frame;
      change_frames.insert(frame % 12);
    }
    before = labels;
  }
  EXPECT_GT(change_frames.size(), 8u);  // objects do not change together
}

TEST(Labels, OnlyTheConfusableAreConfusedAndOnlyThingsMissed) {
  const Stripes stripes;
  const auto labels = objectLabels(stripes.world, {.confused = 0.5, .missed = 0.5, .stretch_frames = 5}, 1, 0);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const WorldObject& object = stripes.world.objects[i];
    EXPECT_TRUE(object.thing || labels[i] == object.label);
    EXPECT_TRUE(object.confused_with == 99 ? labels[i] != object.label : labels[i] != 99);
  }
}

TEST(Labels, MissedObjectsAndSpeckleHaveNoInstance) {
  const Stripes stripes;
  const LabelImage image = stripes.label({.speckle = 0.1, .missed = 0.5, .stretch_frames = 5}, 2, true);
  int missed = 0;
  for (std::size_t i = 0; i < image.labels.size(); ++i) {
    missed += image.labels[i] == 0;
    ASSERT_EQ(image.instances[i] != 0, stripes.scan.object[i] > 0 && image.labels[i] == stripes.truth(i));
  }
  EXPECT_GT(missed, 1000);
}

TEST(Labels, NothingThereHasNoLabel) {
  Stripes stripes;
  std::fill(stripes.scan.object.begin(), stripes.scan.object.begin() + 50, -1);
  const LabelImage image = stripes.label(*labelPreset("poor", Segmented::kImage), 0);
  EXPECT_TRUE(std::all_of(image.labels.begin(), image.labels.begin() + 50, [](ClassId label) { return label == 0; }));
}

TEST(Labels, ConfidenceIsLowerWhereTheLabelIsWrong) {
  const Stripes stripes;
  const LabelImage image = stripes.label(*labelPreset("poor", Segmented::kImage), 0);
  double right = 0, wrong = 0, n_right = 0, n_wrong = 0;
  for (std::size_t i = 0; i < image.labels.size(); ++i) {
    const bool is_right = image.labels[i] == stripes.truth(i);
    (is_right ? right : wrong) += image.confidence[i];
    (is_right ? n_right : n_wrong) += 1;
  }
  ASSERT_GT(n_wrong, 100);
  EXPECT_GT(right / n_right, wrong / n_wrong + 30);
}

TEST(Labels, PresetsGetWorse) {
  for (const Segmented what : {Segmented::kCloud, Segmented::kImage}) {
    const auto good = labelPreset("good", what), poor = labelPreset("poor", what);
    ASSERT_TRUE(good && poor);
    EXPECT_LT(good->speckle, poor->speckle);
    EXPECT_LT(good->bleed * good->bleed_deg, poor->bleed * poor->bleed_deg);
    EXPECT_LT(good->confused, poor->confused);
    EXPECT_LT(good->missed, poor->missed);
  }
  EXPECT_GT(labelPreset("good", Segmented::kImage)->bleed, labelPreset("good", Segmented::kCloud)->bleed);
  EXPECT_FALSE(labelPreset("excellent", Segmented::kImage));
}

TEST(Labels, ThreadsChangeNothing) {
  const Stripes stripes;
  const LabelErrors errors = *labelPreset("poor", Segmented::kImage);
  EXPECT_EQ(stripes.label(errors, 4, true, 1), stripes.label(errors, 4, true, 3));
}

}  // namespace
}  // namespace hgg::labels_test
