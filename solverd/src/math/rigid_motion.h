// Rigid motions as 4x4 matrices for column vectors.
#pragma once
#include <Eigen/Geometry>

namespace lappet {

// A fraction of the way between two rigid motions: `center`, a point at rest, moves straight and what is around it
// turns.
inline Eigen::Matrix4d between_motions(const Eigen::Matrix4d& from, const Eigen::Matrix4d& to, double fraction,
                                       const Eigen::Vector3d& center) {
  const Eigen::Quaterniond first(Eigen::Matrix3d(from.topLeftCorner<3, 3>()));
  const Eigen::Quaterniond last(Eigen::Matrix3d(to.topLeftCorner<3, 3>()));
  Eigen::Matrix4d result = Eigen::Matrix4d::Identity();
  result.topLeftCorner<3, 3>() = first.slerp(fraction, last).toRotationMatrix();
  const Eigen::Vector4d place =
      (1.0 - fraction) * (from * center.homogeneous()) + fraction * (to * center.homogeneous());
  result.topRightCorner<3, 1>() = place.head<3>() - result.topLeftCorner<3, 3>() * center;
  return result;
}

}  // namespace lappet
