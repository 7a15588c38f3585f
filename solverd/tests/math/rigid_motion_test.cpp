// The way between two rigid motions.
#include "math/rigid_motion.h"

#include <gtest/gtest.h>

namespace lappet {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector3d;

Matrix4d turned(double angle, const Vector3d& about, const Vector3d& by) {
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.translate(about + by);
  motion.rotate(Eigen::AngleAxisd(angle, Vector3d(1, 2, 3).normalized()));
  motion.translate(-about);
  return motion.matrix();
}

TEST(RigidMotion, HalfwayBetweenTwoMotionsTurnsByHalfAboutAPointThatGoesStraight) {
  const Vector3d center(1, 2, 3);
  const Matrix4d to = turned(0.8, center, {2, 0, -4});
  const Matrix4d half = between_motions(Matrix4d::Identity(), to, 0.5, center);
  EXPECT_LT((half - turned(0.4, center, {1, 0, -2})).norm(), 1e-12);
  EXPECT_LT((between_motions(Matrix4d::Identity(), to, 1.0, center) - to).norm(), 1e-12);
}

}  // namespace
}  // namespace lappet
