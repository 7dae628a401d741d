#include "map/position.h"

#include <tuple>

#include "core/so3.h"
#include "map/drift.h"

namespace hgg {
namespace {

/// Of a position that is rigidly fixed to a keyframe.
Mat3 carried(const Map& map, KeyframeId anchor, const Mat6& cov, const Vec3& p_map) {
  const Vec3& origin = map.keyframes().poses().at(static_cast<std::size_t>(anchor)).T_map_body.translation();
  const Mat6 F = tangentTransport(p_map - origin);
  return (F * cov * F.transpose()).topLeftCorner<3, 3>();
}

/// Whether drift between their anchors can move one against the other.
bool areApart(const MapNode& a, const MapNode& b) { return a.anchor != b.anchor && a.anchor >= 0 && b.anchor >= 0; }

/// `between` is the covariance of b's anchor relative to a's, zero where they are not apart.
Mat3 relative(const Map& map, const MapNode& a, const MapNode& b, const Mat6& between) {
  const Vec3 apart = b.belief.mean - a.belief.mean;
  const Mat3 swing = skew(apart);
  Mat3 cov = positionCovariance(a) + positionCovariance(b);
  cov += swing * map.poseCovariance(a.anchor).bottomRightCorner<3, 3>() * swing.transpose();
  if (areApart(a, b)) {
    cov += carried(map, b.anchor, between, b.belief.mean);
  }
  return cov;
}

}  // namespace

Mat3 positionCovarianceInMap(const Map& map, const MapNode& node) {
  const Mat3 local = positionCovariance(node);
  return node.anchor < 0 ? local
                         : Mat3(local + carried(map, node.anchor, map.poseCovariance(node.anchor), node.belief.mean));
}

Mat3 relativeCovariance(const Map& map, const MapNode& a, const MapNode& b) {
  const auto& [first, second] = a.anchor <= b.anchor ? std::tie(a, b) : std::tie(b, a);  // the same in both orders
  const Mat6 between =
      areApart(a, b) ? covarianceBetween(map.keyframes(), first.anchor, second.anchor) : Mat6(Mat6::Zero());
  return relative(map, first, second, between);
}

Mat3 relativeCovariance(const Map& map, const MapNode& a, const MapNode& b, const std::vector<Mat6>& from_anchor) {
  return relative(map, a, b, areApart(a, b) ? from_anchor.at(static_cast<std::size_t>(b.anchor)) : Mat6(Mat6::Zero()));
}

}  // namespace hgg
