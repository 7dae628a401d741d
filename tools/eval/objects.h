#pragma once

#include <optional>
#include <set>
#include <span>
#include <vector>

#include "eval/calibration.h"
#include "eval/graph.h"
#include "truth/objects.h"

namespace hgg {

struct ObjectMatch {
  NodeId prediction = 0;
  std::int64_t truth = 0;
  double distance = 0;           // m between the means
  double extent_error = 0;       // m, 2-Wasserstein distance of the two Gaussians
  double normalised_square = 0;  // of the position error in the map's own frame under its published covariance
  double position_variance = 0;  // m^2, mean of that covariance's diagonal
  // The same with the extent's covariance over the points, which is what a position known by independent points would
  // have.
  double square_by_points = 0, variance_by_points = 0;
};

/// Mean, median and maximum; NaN of nothing.
struct Spread {
  double mean = 0, median = 0, max = 0;
};
Spread spreadOf(std::vector<double> values);

/// Counts and position errors of one class, or of all.
struct ObjectScore {
  std::size_t truth = 0;      // static true objects
  std::size_t predicted = 0;  // predictions, without those that stand for a dynamic true object
  std::vector<ObjectMatch> matches;
  std::vector<std::int64_t> missed;  // true objects without a match
  std::vector<NodeId> ghosts;        // predictions without a match

  /// Ratios and errors are NaN where there is nothing to divide by.
  double precision() const;
  double recall() const;
  double f1() const;
  Spread positionError() const;
  Spread extentError() const;
  Calibration calibration() const;
  Calibration calibrationByPoints() const;
};

/// A class with true objects is one of things, whatever the map says of its own objects: else a map could hide its
/// ghosts by calling them stuff.
void markThings(std::vector<MappedObject>& predictions, std::span<const TruthObject> truth);

struct ObjectEvaluation {
  std::map<ClassId, ObjectScore> classes;
  ObjectScore overall;
  std::vector<ObjectMatch> dynamic;  // predictions set aside because they stand for a dynamic true object
};

/// Object accuracy as in the paper: greedy nearest matching of the same class within `radius`, over things (predictions
/// of stuff classes are left out; the truth holds things only). All (prediction, truth) pairs in range are taken
/// closest first, each prediction and each true object at most once; ties go to the smaller ids. Dynamic true objects
/// have no single true position, and those taken away may be in a map or not: they do not count for recall, and a
/// prediction that is left over after the static ones are matched, and matches a dynamic one by the same rule, is
/// neither true nor false; nor is one that the map calls dynamic (see scoreMoving()). Only classes in `only` are looked
/// at; empty: all.
///
/// Predictions are matched where they lie. What the map says of how well it knows them is said of its own frame, that
/// of its first keyframe: `T_beliefs` moves them to where they lie when that frame is laid on its true place.
ObjectEvaluation evaluateObjects(std::span<const MappedObject> predictions, std::span<const TruthObject> truth,
                                 double radius, const std::set<ClassId>& only,
                                 const Pose& T_beliefs = Pose::Identity());

}  // namespace hgg
