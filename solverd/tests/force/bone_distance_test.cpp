// The distance to bones that move.
#include "force/constraints/bone_distance.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "test_surfaces.h"

namespace lappet {
namespace {

BoneDistance two_boxes() {
  const auto field = [](const Surface& surface) {
    return std::make_shared<const SignedDistance>(surface, 0.5, 3.0, std::size_t{1} << 28);
  };
  return BoneDistance({field(test::box({0, 0, 0}, {4, 4, 4})), field(test::box({10, 0, 0}, {14, 4, 4}))});
}

Eigen::Matrix4d turned(double angle, const Vec3& about, const Vec3& by) {
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.translate(about + by);
  motion.rotate(Eigen::AngleAxisd(angle, Vec3(1, 2, 3).normalized()));
  motion.translate(-about);
  return motion.matrix();
}

TEST(BoneDistance, OfAMovedBoneIsThatOfThePointMovedBack) {
  const BoneDistance still = two_boxes();
  BoneDistance moved = two_boxes();
  const Eigen::Matrix4d motion = turned(0.7, {2, 2, 2}, {0.5, -1, 0.25});
  moved.place(std::array{motion, Eigen::Matrix4d(Eigen::Matrix4d::Identity())});
  for (const Vec3& rest : {Vec3(2, 2, 4.6), Vec3(4.4, 1, 2), Vec3(2, 3.5, 2)}) {
    const Vec3 now = (motion * rest.homogeneous()).head<3>();
    const auto here = moved.at(now), there = still.at(rest);
    EXPECT_NEAR(here.value, there.value, 1e-9);
    EXPECT_LT((here.gradient - motion.topLeftCorner<3, 3>() * there.gradient).norm(), 1e-9);
    EXPECT_NEAR(moved.at_rest(rest).value, there.value, 0.0);
  }
  EXPECT_NEAR(moved.at({14.5, 2, 2}).value, 0.5, 1e-6);
}

}  // namespace
}  // namespace lappet
