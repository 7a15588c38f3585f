#include "lattice/voxelize.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "lattice/refused.h"
#include "lattice/winding_numbers.h"
#include "test_surfaces.h"

namespace lappet {
namespace {

LatticeSettings settings(double spacing, int ratio) {
  LatticeSettings result;
  result.spacing = spacing;
  result.fine_ratio = ratio;
  return result;
}

std::string refusal(const Surface& surface, const LatticeSettings& s) {
  try {
    FineVoxels fine(surface, s);
  } catch (const RefusedError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInvalidInput);
    return error.what();
  }
  return "not refused";
}

void expect_all_axes_agree(const Surface& surface, const LatticeSettings& s) {
  const auto x = test::winding_numbers(surface, s, 0);
  EXPECT_EQ(x, test::winding_numbers(surface, s, 1));
  EXPECT_EQ(x, test::winding_numbers(surface, s, 2));
  for (const std::int8_t w : x) ASSERT_TRUE(w == 0 || w == 1);
}

TEST(Voxelize, WindingNumbersAlongAllThreeAxesAgreeOnARoundBody) {
  expect_all_axes_agree(test::sphere(Vec3(5.03, 5.1, 5.2), 4.7, 20), settings(1.0, 4));
}

TEST(Voxelize, WindingNumbersAgreeWhereVerticesEdgesAndFacesLieOnVoxelCenters) {
  // With r = 4 centers lie at odd multiples of 1/8: an octahedron with its six tips, twelve edges and diagonal faces on
  // them.
  Surface octahedron;
  const Vec3 middle(2.125, 2.125, 2.125);
  for (int a = 0; a < 3; ++a)
    for (const double s : {-1.5, 1.5}) octahedron.points.emplace_back(middle + s * Vec3::Unit(a));
  for (int sx = 0; sx < 2; ++sx)
    for (int sy = 0; sy < 2; ++sy)
      for (int sz = 0; sz < 2; ++sz) {
        std::array<std::int32_t, 3> t{sx, 2 + sy, 4 + sz};
        if ((sx + sy + sz) % 2 == 0) std::swap(t[1], t[2]);
        octahedron.triangles.push_back(t);
      }
  expect_all_axes_agree(octahedron, settings(1.0, 4));
  expect_all_axes_agree(test::box(Vec3(0.125, 0.375, 0.625), Vec3(3.125, 2.875, 1.625)), settings(1.0, 4));
  // |x| + |y| + |z| <= 6 voxels about a center has 377 points of the grid; the half-open rule keeps a definite part of
  // the 146 on the boundary, and the 231 strictly inside always.
  std::int64_t inside = 0;
  for (const std::int8_t w : test::winding_numbers(octahedron, settings(1.0, 4), 0)) inside += w;
  EXPECT_GE(inside, 231);
  EXPECT_LE(inside, 377);
  // Moved centers: of a box with faces on centers the upper face is out and the lower face is in, so nothing is counted
  // twice.
  std::int64_t box = 0;
  for (const std::int8_t w :
       test::winding_numbers(test::box(Vec3(0.125, 0.375, 0.625), Vec3(3.125, 2.875, 1.625)), settings(1.0, 4), 1))
    box += w;
  EXPECT_EQ(box, 12 * 10 * 4);
}

TEST(Voxelize, RandomTrianglesThatFormAClosedSurfaceGiveTheSameWindingAlongEveryAxis) {
  // A sphere whose points are shaken onto the grid of half voxels: folded, self-crossing, full of ties, but still
  // closed.
  Surface shaken = test::sphere(Vec3(4, 4, 4), 3.0, 9);
  std::uint32_t seed = 1;
  for (Vec3& p : shaken.points)
    for (double& x : p) {
      seed = seed * 1664525U + 1013904223U;
      x = std::round((x + (seed >> 8) * 0x1p-24 - 0.5) * 8.0) / 8.0;
    }
  const auto s = settings(1.0, 4);
  const auto x = test::winding_numbers(shaken, s, 0);
  EXPECT_EQ(x, test::winding_numbers(shaken, s, 1));
  EXPECT_EQ(x, test::winding_numbers(shaken, s, 2));
}

TEST(Voxelize, ASlitBetweenTwoCentersCutsTheirLinkAndLeavesBothInside) {
  const auto slab = test::cut_slab(4, 2, 1, {{2.0, 0.0}, {2.0, 2.0}}, 0.01);
  const FineVoxels fine(slab.surface, settings(1.0, 4));
  for (std::int32_t y = 0; y < 8; ++y)
    for (std::int32_t z = 0; z < 4; ++z)
      for (std::int32_t x = 0; x < 15; ++x) {
        EXPECT_TRUE(fine.inside({x, y, z}));
        EXPECT_EQ(fine.cut_above({x, y, z}, 0), x == 7);
        EXPECT_EQ(fine.connected_above({x, y, z}, 0), x != 7);
      }
}

TEST(Voxelize, CoincidentWallsCutToo) {
  for (const double at : {2.0, 2.125, 2.03}) {
    const auto slab = test::cut_slab(4, 2, 1, {{at, 0.0}, {at, 2.0}}, 0.0);
    const FineVoxels fine(slab.surface, settings(1.0, 4));
    for (std::int32_t y = 0; y < 8; ++y) {
      int cuts = 0;
      for (std::int32_t x = 0; x < 15; ++x) {
        EXPECT_TRUE(fine.inside({x, y, 1}));
        cuts += fine.cut_above({x, y, 1}, 0);
      }
      EXPECT_EQ(cuts, 1) << "cut at " << at;
    }
  }
}

TEST(Voxelize, EveryInnerVoxelIsInsideAndOnTheInnerSideOfItsTriangle) {
  const Surface ball = test::sphere(Vec3(5, 5, 5), 4.0, 8);
  const auto s = settings(1.0, 5);
  const FineVoxels fine(ball, s);
  std::size_t seen = 0;
  for (std::int32_t t = 0; t < fine.triangle_count(); ++t) {
    const auto& tri = ball.triangles[t];
    const Vec3 a = ball.points[tri[0]], b = ball.points[tri[1]], c = ball.points[tri[2]];
    for (const Voxel voxel : fine.inner_voxels(t)) {
      if (voxel[0] < 0) continue;
      ++seen;
      EXPECT_TRUE(fine.inside(voxel));
      const Vec3 center = s.spacing * Vec3(fine.box().low[0], fine.box().low[1], fine.box().low[2]) +
                          0.2 * Vec3(voxel[0] + 0.5, voxel[1] + 0.5, voxel[2] + 0.5);
      EXPECT_LT((b - a).cross(c - a).dot(center - a), 1e-9);
    }
  }
  EXPECT_GT(seen, 5000U);
}

TEST(Voxelize, InsideVoxelsOfABallConvergeToItsVolume) {
  const double radius = 6.0, exact = 4.0 / 3.0 * std::numbers::pi * std::pow(radius, 3);
  const Surface ball = test::sphere(Vec3(7.1, 7.2, 7.3), radius, 90);
  double previous = 1.0;
  for (const int ratio : {2, 4, 8}) {
    std::int64_t count = 0;
    for (const std::int8_t w : test::winding_numbers(ball, settings(1.0, ratio), 2)) count += w;
    const double error = std::abs(double(count) / std::pow(ratio, 3) / exact - 1.0);
    EXPECT_LT(error, 0.05 / ratio);
    EXPECT_LT(error, previous + 1e-3);
    previous = error;
  }
}

TEST(Voxelize, BadSurfacesAreRefusedWithWhatAndWhere) {
  const Surface good = test::box(Vec3(0, 0, 0), Vec3(4, 4, 4));
  Surface bad = good;
  bad.points[3].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(refusal(bad, settings(1, 4)).find("Point 3"), std::string::npos);
  bad = good;
  bad.triangles.pop_back();
  EXPECT_NE(refusal(bad, settings(1, 4)).find("not closed"), std::string::npos) << refusal(bad, settings(1, 4));
  bad = good;
  for (auto& t : bad.triangles) std::swap(t[0], t[1]);
  EXPECT_NE(refusal(bad, settings(1, 4)).find("faces outwards"), std::string::npos);
  bad = good;
  bad.triangles[2][1] = 99;
  EXPECT_NE(refusal(bad, settings(1, 4)).find("Triangle 2"), std::string::npos);
  EXPECT_NE(refusal({}, settings(1, 4)).find("empty"), std::string::npos);
  EXPECT_NE(refusal(good, settings(0, 4)).find("spacing is 0 mm"), std::string::npos);
  EXPECT_NE(refusal(good, settings(1, 0)).find("fine ratio is 0"), std::string::npos);
  bad = good;
  for (Vec3& p : bad.points) p.x() += 1e12;
  EXPECT_NE(refusal(bad, settings(1, 4)).find("too far"), std::string::npos);
}

}  // namespace
}  // namespace lappet
