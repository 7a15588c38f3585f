// The bodies of bones that move, and the steps of their way.
#include "session/bone_bodies.h"

#include <gtest/gtest.h>

#include "box.h"

namespace lappet {
namespace {

// Two boxes whose triangles take turns.
SessionSettings two_bodies() {
  SessionSettings settings;
  settings.spacing = 2.0;
  Surface both = box_surface({0, 0, 0}, {1, 2, 3});
  append(both, box_surface({10, 0, 0}, {14, 1, 1}));
  settings.bones.points = both.points;
  for (std::size_t t = 0; t < 12; ++t)
    for (const std::size_t body : {0, 1}) {
      settings.bones.triangles.push_back(both.triangles[12 * body + t]);
      settings.bone_bodies.push_back(static_cast<std::int32_t>(body));
    }
  return settings;
}

Eigen::Matrix4d shifted(double x) {
  Eigen::Matrix4d motion = Eigen::Matrix4d::Identity();
  motion(0, 3) = x;
  return motion;
}

TEST(BoneBodies, EachHasItsOwnTrianglesAndNoOtherPoints) {
  const std::vector<Surface> bodies = bone_bodies(two_bodies());
  ASSERT_EQ(bodies.size(), 2U);
  for (const Surface& body : bodies) {
    EXPECT_EQ(body.points.size(), 8U);
    EXPECT_EQ(body.triangles.size(), 12U);
  }
  EXPECT_EQ(box_around(bodies[0]).max(), Vec3(1, 2, 3));
  EXPECT_EQ(box_around(bodies[1]).min(), Vec3(10, 0, 0));
  EXPECT_EQ(bodies[1].points[bodies[1].triangles[0][0]], Vec3(10, 0, 0));
}

TEST(BoneBodies, TheWayOfTheOneThatMovesFarthestIsDividedIntoQuartersOfTheSpacing) {
  const BoneWay way(two_bodies());
  const std::vector<Eigen::Matrix4d> to{shifted(0.3), shifted(1.6)};
  EXPECT_EQ(way.steps({}, to), 4);
  EXPECT_EQ(way.steps(to, to), 1);
  EXPECT_EQ(way.steps({}, {}), 1);
  const auto half = way.at({}, to, 0.5);
  ASSERT_EQ(half.size(), 2U);
  EXPECT_LT((half[1] - shifted(0.8)).norm(), 1e-12);
  EXPECT_TRUE(way.at({}, {}, 0.5).empty());
}

TEST(BoneBodies, BonesThatAllStayAreOneBodyAndTakeOneStep) {
  SessionSettings settings = two_bodies();
  settings.bone_bodies.clear();
  EXPECT_EQ(bone_bodies(settings).size(), 1U);
  EXPECT_EQ(BoneWay(settings).steps({}, {}), 1);
}

}  // namespace
}  // namespace lappet
