#include "lattice/embedding.h"

#include <gtest/gtest.h>

#include <numeric>

#include "lattice/refused.h"
#include "test_surfaces.h"

namespace lappet {
namespace {

LatticeSettings settings(double spacing, int ratio) {
  LatticeSettings result;
  result.spacing = spacing;
  result.fine_ratio = ratio;
  return result;
}

Vec3 evaluate(const Lattice& lattice, const EmbeddedPoint& point, std::span<const Vec3> positions) {
  Vec3 result = Vec3::Zero();
  for (std::size_t c = 0; c < 8; ++c) result += point.weights[c] * positions[lattice.cell_nodes[point.cell][c]];
  return result;
}

TEST(Embedding, EverySurfaceVertexReproducesItsPosition) {
  auto s = settings(0.9, 5);
  s.origin = Vec3(0.3, -0.2, 0.1);
  const Surface ball = test::sphere(Vec3(5, 5, 5), 4.0, 30);
  const Lattice lattice = build_lattice(ball, s);
  ASSERT_EQ(lattice.surface_points.size(), ball.points.size());
  for (std::size_t p = 0; p < ball.points.size(); ++p) {
    EXPECT_LT((evaluate(lattice, lattice.surface_points[p], lattice.node_rest.all()) - ball.points[p]).norm(), 1e-9);
    for (const double w : lattice.surface_points[p].weights) EXPECT_LT(std::abs(w), 2.0);  // within a voxel of its cell
  }
}

TEST(Embedding, PointsOfALatticeAlignedFaceAreHeldByTheNodesOfThatFaceAlone) {
  auto s = settings(0.1, 4);  // 0.1 has no exact binary form: rounding must not leak weight off the face
  const Surface box = test::refine(test::box(Vec3(0, 0, 0), Vec3(0.7, 0.5, 0.3)), 2);
  const Lattice lattice = build_lattice(box, s);
  for (std::size_t p = 0; p < box.points.size(); ++p) {
    if (box.points[p].x() != 0.7) continue;
    const EmbeddedPoint& e = lattice.surface_points[p];
    for (std::size_t c = 0; c < 8; ++c) {
      EXPECT_GE(e.weights[c], 0.0);
      if (e.weights[c] == 0.0) continue;
      const std::size_t node = lattice.cell_nodes[e.cell][c];
      EXPECT_NEAR(lattice.node_rest[node].x(), 0.7, 1e-12);
    }
  }
}

TEST(Embedding, APointWhoseDistanceIsNoNumberIsRefused) {
  const Surface ball = test::sphere(Vec3(5, 5, 5), 4.0, 30);
  const Lattice lattice = build_lattice(ball, settings(1.0, 4));
  for (const double far : {1e155, -1e200, 1e308})
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 point = ball.points[0];
      point[axis] = far;
      EXPECT_THROW(embed_on_triangle(lattice, ball, point, 0), RefusedError) << far;
    }
  EXPECT_GE(embed_on_triangle(lattice, ball, ball.points[0] + Vec3(1e8, 0, 0), 0).cell, 0);  // only far
}

// Slabs with a narrow slot that ends inside: which side of the slot a surface point is on is known from its
// construction.
struct Slot {
  Surface surface;
  double x;  // the slot runs along y at this x, from y = 0 to `end`
  double end;
};
Slot slot(double kerf) {
  Slot result{{}, 6.4, 7.3};
  result.surface =
      test::prism({{0, 0}, {6.4 - kerf / 2, 0}, {6.4, 7.3}, {6.4 + kerf / 2, 0}, {12, 0}, {12, 10}, {0, 10}}, 0.0, 3.0);
  return result;
}

TEST(Embedding, MovingOneSideOfAWoundMovesOnlyThePointsOfThatSide) {
  for (const int refinements : {0, 3})
    for (const int ratio : {4, 6, 10})
      for (const double kerf : {0.0, 0.01, 0.1}) {
        SCOPED_TRACE(testing::Message() << "ratio " << ratio << ", kerf " << kerf << ", refined " << refinements);
        auto slab = test::cut_slab(12, 8, 3, {{6, 0}, {6, 2}, {8.3, 3}, {3.6, 5}, {6, 6}, {6, 8}}, kerf);
        Surface left{{slab.surface.points.begin(), slab.surface.points.begin() + slab.left_points}, {}};
        for (const auto& t : slab.surface.triangles)
          if (static_cast<std::size_t>(t[0]) < slab.left_points) left.triangles.push_back(t);
        Surface right;
        right.points.assign(slab.surface.points.begin() + slab.left_points, slab.surface.points.end());
        const Index shift = to_index(slab.left_points);
        for (const auto& t : slab.surface.triangles)
          if (t[0] >= shift) right.triangles.push_back({t[0] - shift, t[1] - shift, t[2] - shift});
        left = test::refine(left, refinements);
        right = test::refine(right, refinements);
        Surface both = left;
        test::append(both, right);

        const Lattice lattice = build_lattice(both, settings(1.0, ratio));
        // Move what hangs together with the first cell.
        std::vector<char> moved(lattice.node_rest.size(), 0);
        for (const std::int32_t n : lattice.cell_nodes.front()) moved[n] = 1;
        for (bool grew = true; grew;) {
          grew = false;
          for (const auto& nodes : lattice.cell_nodes) {
            const auto count = std::count_if(nodes.begin(), nodes.end(), [&](auto n) { return moved[n]; });
            if (count == 0 || count == 8) continue;
            for (const std::int32_t n : nodes) moved[n] = 1;
            grew = true;
          }
        }
        std::vector<Vec3> positions = lattice.node_rest.all();
        const Vec3 push(-3, 0.5, 1);
        for (std::size_t n = 0; n < positions.size(); ++n)
          if (moved[n]) positions[n] += push;
        for (std::size_t p = 0; p < both.points.size(); ++p) {
          const Vec3 expected = both.points[p] + (p < left.points.size() ? push : Vec3::Zero());
          EXPECT_LT((evaluate(lattice, lattice.surface_points[p], positions) - expected).norm(), 1e-9)
              << "point " << both.points[p].transpose();
        }
      }
}

TEST(Embedding, BesideASlotThatEndsInsideEachWallFollowsItsOwnSide) {
  for (const int refinements : {0, 3})
    for (const int ratio : {4, 10})
      for (const double kerf : {0.01, 0.2}) {
        SCOPED_TRACE(testing::Message() << "ratio " << ratio << ", kerf " << kerf << ", refined " << refinements);
        const Slot wound = slot(kerf);
        const Surface surface = test::refine(wound.surface, refinements);
        const Lattice lattice = build_lattice(surface, settings(1.0, ratio));
        EXPECT_EQ(lattice.fragments, 1);
        // A node on the left side of the slot in the material sense: reached from x = 0 without passing beyond y = 6.
        std::vector<char> left(lattice.node_rest.size(), 0);
        std::vector<char> behind(left);
        for (std::size_t n = 0; n < left.size(); ++n) {
          behind[n] = lattice.node_rest[n].y() > 6.0;
          left[n] = lattice.node_rest[n].x() == 0.0;
        }
        for (bool grew = true; grew;) {
          grew = false;
          for (std::size_t cell = 0; cell < lattice.cell_nodes.size(); ++cell) {
            if (lattice.cell_position(cell)[1] >= 6) continue;
            const auto& nodes = lattice.cell_nodes[cell];
            const auto count = std::count_if(nodes.begin(), nodes.end(), [&](auto n) { return left[n]; });
            if (count == 0 || count == 8) continue;
            for (const std::int32_t n : nodes) left[n] = 1;
            grew = true;
          }
        }
        int walls = 0;
        for (std::size_t p = 0; p < surface.points.size(); ++p) {
          const Vec3& point = surface.points[p];
          if (point.y() > 5.0) continue;
          if (std::abs(point.x() - wound.x) < 0.11) ++walls;
          double weight = 0.0;
          for (std::size_t c = 0; c < 8; ++c)
            if (left[lattice.cell_nodes[lattice.surface_points[p].cell][c]])
              weight += lattice.surface_points[p].weights[c];
          EXPECT_NEAR(weight, point.x() < wound.x ? 1.0 : 0.0, 1e-9) << point.transpose();
        }
        EXPECT_GE(walls, 4);
      }
}

TEST(Embedding, AnAnchorTakesTheSideOfItsTriangle) {
  // Any point of the two walls of a slit 0.01 mm wide: both walls are nearer to it than any voxel. It may lie on the
  // other triangle of its wall, far from the one that is named.
  const auto slab = test::cut_slab(12, 8, 3, {{6.2, 0}, {6.2, 8}}, 0.01);
  const Lattice lattice = build_lattice(slab.surface, settings(1.0, 4));
  int walls = 0;
  for (std::size_t t = 0; t < slab.surface.triangles.size(); ++t) {
    const auto& tri = slab.surface.triangles[t];
    bool wall = true;
    for (const auto p : tri) wall = wall && std::abs(slab.surface.points[p].x() - 6.2) < 0.01;
    if (!wall) continue;
    ++walls;
    for (const double y : {0.4, 4.0, 7.7})
      for (const double z : {0.1, 2.9}) {
        const EmbeddedPoint e = embed_on_triangle(lattice, slab.surface, Vec3(6.2, y, z), to_index(t));
        const bool left = static_cast<std::size_t>(tri[0]) < slab.left_points;
        const std::size_t cell = e.cell;
        EXPECT_EQ(lattice.cell_position(cell)[0], 6);
        // The two copies of that cell share no node; the left one has the smaller volume (a quarter of the cell).
        EXPECT_EQ(lattice.cell_fill[cell] < 0.5F, left);
        EXPECT_LT((evaluate(lattice, e, lattice.node_rest.all()) - Vec3(6.2, y, z)).norm(), 1e-9);
      }
  }
  EXPECT_EQ(walls, 4);
}

TEST(Embedding, ACrumbWithoutAVoxelIsCarriedByTheNearestTissue) {
  Surface two = test::box(Vec3(0, 0, 0), Vec3(4, 4, 4));
  test::append(two, test::box(Vec3(4.3, 2.01, 2.01), Vec3(4.32, 2.03, 2.03)));
  const Lattice lattice = build_lattice(two, settings(1.0, 4));
  EXPECT_EQ(lattice.fragments, 1);
  for (std::size_t p = 8; p < 16; ++p) {
    EXPECT_EQ(lattice.cell_position(lattice.surface_points[p].cell), (std::array<std::int32_t, 3>{3, 2, 2}));
  }
}

TEST(Embedding, ImpossibleAnchorsAreRefused) {
  const Surface box = test::box(Vec3(0, 0, 0), Vec3(2, 2, 2));
  const Lattice lattice = build_lattice(box, settings(1.0, 4));
  EXPECT_THROW((void)embed_on_triangle(lattice, box, Vec3(1, 1, 2), 12), RefusedError);
  EXPECT_THROW((void)embed_on_triangle(lattice, box, Vec3(1, 1, 2), -1), RefusedError);
  EXPECT_THROW((void)embed_on_triangle(lattice, box, Vec3(1, NAN, 2), 0), RefusedError);
}

}  // namespace
}  // namespace lappet
