// Where a suture's ends meet: on walls, and where a flap's tip comes into a corner on the edges of both.
#include "session/wall_ends.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <vector>

#include "lattice/lattice.h"
#include "test_surfaces.h"

namespace lappet {
namespace {

constexpr double kTip = 20.0;  // where the flap is
const double kSlope = std::tan(std::numbers::pi / 6.0);

// A slab with a notch of 60 degrees whose corner is at the origin, and apart from it a flap with a tip of 60 degrees.
// Both are 4 mm thick, and what is upright is a wall.
struct NotchAndFlap {
  explicit NotchAndFlap(double slope = kSlope) {
    surface = test::prism({{-6, -6}, {6, -6}, {6, -6 * slope}, {0, 0}, {6, 6 * slope}, {6, 6}, {-6, 6}}, 0.0, 4.0);
    test::append(surface, test::prism({{kTip, 0}, {kTip + 6, -6 * slope}, {kTip + 6, 6 * slope}}, 0.0, 4.0));
    for (const auto& t : surface.triangles) {
      const Vec3 &a = surface.points[t[0]], &b = surface.points[t[1]], &c = surface.points[t[2]];
      walls.push_back(std::abs((b - a).cross(c - a).normalized().z()) < 0.5 ? 1 : 0);
    }
    lattice = build_lattice(surface, {});
  }
  auto ends(const Vec3& first, const Vec3& second) const {
    return find_wall_ends(AnchorStencils(lattice, surface, kStencilRadius), surface, walls, first, second);
  }

  Surface surface;
  std::vector<std::uint8_t> walls;
  Lattice lattice;
};

TEST(WallEnds, AreTheEdgesWhereAFlapsTipComesIntoACorner) {
  const NotchAndFlap scene;
  const Vec3 behind(-0.39, 0.0, 2.0), inside(kTip + 0.34, 0.0, 2.0);
  const auto ends = scene.ends(behind, inside);
  ASSERT_TRUE(ends);
  EXPECT_LT((behind + ends->first.out - Vec3(0.0, 0.0, 2.0)).norm(), 1e-9);
  EXPECT_LT((inside + ends->second.out - Vec3(kTip, 0.0, 2.0)).norm(), 1e-9);
  // Each wall moves on by a millimeter where the edge moves on by 1 / sin 30.
  EXPECT_LT((ends->first.ahead - Vec3(2.0, 0.0, 0.0)).norm(), 1e-9);
  EXPECT_LT((ends->second.ahead - Vec3(-2.0, 0.0, 0.0)).norm(), 1e-9);

  const auto turned = scene.ends(inside, behind);
  ASSERT_TRUE(turned);
  EXPECT_EQ(turned->first.out, ends->second.out);
  EXPECT_EQ(turned->second.out, ends->first.out);
}

TEST(WallEnds, LeaveWallsThatTouchThatFarApart) {
  const NotchAndFlap scene;
  const Vec3 behind(-0.39, 0.0, 2.0), inside(kTip + 0.34, 0.0, 2.0);
  const auto ends = scene.ends(behind, inside);
  ASSERT_TRUE(ends);
  // The flap moves so that the ends meet; its tip is then so far from each wall of the notch.
  constexpr double kApart = 0.1;
  const Vec3 way = behind + ends->first.beyond(kApart) - inside - ends->second.beyond(kApart);
  const Vec3 tip = Vec3(kTip, 0.0, 2.0) + way;
  for (const double side : {-1.0, 1.0}) {
    const Vec3 normal = Vec3(kSlope, side, 0.0).normalized();  // into the notch
    EXPECT_NEAR(tip.dot(normal), kApart, 1e-9);
  }
}

TEST(WallEnds, LieAboveTheirAnchorsWhereTwoWallsFaceEachOther) {
  const NotchAndFlap scene;
  const Vec3 upper = Vec3(-kSlope, 1.0, 0.0).normalized();  // out of the flap
  const Vec3 notch(4.0, 4.0 * kSlope + 0.2 / std::cos(std::numbers::pi / 6.0), 2.0);
  const Vec3 flap(kTip + 4.0, 4.0 * kSlope - 0.3 / std::cos(std::numbers::pi / 6.0), 2.0);
  const auto ends = scene.ends(notch, flap);
  ASSERT_TRUE(ends);
  EXPECT_LT((ends->first.out + 0.2 * upper).norm(), 1e-9);
  EXPECT_LT((ends->second.out - 0.3 * upper).norm(), 1e-9);
  EXPECT_LT((ends->first.beyond(0.1) + 0.25 * upper).norm(), 1e-9);
}

TEST(WallEnds, IsAPointOfAWallWhereThatAloneComesIntoACorner) {
  const NotchAndFlap scene;
  const Vec3 blunt(kTip + 5.7, 0.0, 2.0);  // under the flap's straight end
  const auto ends = scene.ends(Vec3(-0.39, 0.0, 2.0), blunt);
  ASSERT_TRUE(ends);
  EXPECT_LT((ends->first.out - Vec3(0.39, 0.0, 0.0)).norm(), 1e-9);
  EXPECT_LT((ends->second.out - Vec3(0.3, 0.0, 0.0)).norm(), 1e-9);
}

TEST(WallEnds, OfASharpTipGoThreeTimesAsFarAheadAsItsWallsAtMost) {
  const NotchAndFlap scene(std::tan(std::numbers::pi / 12.0));  // 30 degrees, 1 / sin 15 would be 3.9 times as far
  const auto ends = scene.ends(Vec3(-0.3, 0.0, 2.0), Vec3(kTip + 0.6, 0.0, 2.0));
  ASSERT_TRUE(ends);
  EXPECT_LT((ends->first.ahead - Vec3(3.0, 0.0, 0.0)).norm(), 1e-9);
  EXPECT_LT((ends->second.ahead + Vec3(3.0, 0.0, 0.0)).norm(), 1e-9);
  EXPECT_LT((ends->second.out + Vec3(0.6, 0.0, 0.0)).norm(), 1e-9);
}

TEST(WallEnds, IsTheEdgeOfATipInWhoseMiddleTheAnchorLiesWhateverItComesTo) {
  const NotchAndFlap scene;
  const Vec3 inside(kTip + 0.34, 0.0, 2.0);
  const auto ends = scene.ends(inside, Vec3(kTip + 5.7, 0.0, 2.0));
  ASSERT_TRUE(ends);
  EXPECT_LT((inside + ends->first.out - Vec3(kTip, 0.0, 2.0)).norm(), 1e-9);
  // Beside the middle it is a point of the nearer wall.
  const auto beside = scene.ends(inside + Vec3(0.0, 0.03, 0.0), Vec3(kTip + 5.7, 0.0, 2.0));
  ASSERT_TRUE(beside);
  EXPECT_NEAR(beside->first.ahead.norm(), 1.0, 1e-9);
}

TEST(WallEnds, LieOnTheNearerSideOfAThinPart) {
  const NotchAndFlap scene(std::tan(std::numbers::pi / 36.0));  // 10 degrees
  const auto ends = scene.ends(Vec3(kTip + 3.0, 0.0, 2.0), Vec3(kTip + 5.7, 0.0, 2.0));
  ASSERT_TRUE(ends);
  EXPECT_NEAR(ends->first.out.norm(), 3.0 * std::sin(std::numbers::pi / 36.0), 1e-9);
  EXPECT_NEAR(ends->first.ahead.norm(), 1.0, 1e-9);
}

TEST(WallEnds, AreNoneFarFromEveryWall) {
  const NotchAndFlap scene;
  EXPECT_FALSE(scene.ends(Vec3(-3.0, 0.0, 2.0), Vec3(kTip + 0.34, 0.0, 2.0)));
}

}  // namespace
}  // namespace lappet
