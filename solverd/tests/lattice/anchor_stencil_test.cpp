// What sutures and hooks hold: the weights of a stencil, on which side of a cut it is, and that what a suture asks of
// the tissue no longer depends on the lattice.
#include "lattice/anchor_stencil.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

#include "box.h"
#include "force/constraints/point_constraint.h"
#include "session/session.h"
#include "solve/system/system.h"
#include "test_surfaces.h"

namespace lappet {
namespace {

LatticeSettings spaced(double spacing) {
  LatticeSettings result;
  result.spacing = spacing;
  return result;
}

AnchorStencil held_at(const Lattice& lattice, const Surface& surface, std::size_t triangle) {
  return AnchorStencils(lattice, surface, kStencilRadius).around(center(surface, triangle), to_index(triangle));
}

// The mean of x x^T about the anchor.
Eigen::Matrix3d spread(const Lattice& lattice, const AnchorStencil& held, const Vec3& anchor) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < held.nodes.size(); ++k) {
    const Vec3 x = lattice.node_rest[held.nodes[k]] - anchor;
    sum += held.weights[k] * x * x.transpose();
  }
  return sum;
}

// The lowest node of the piece of tissue that each node belongs to.
std::vector<std::size_t> pieces(const Lattice& lattice) {
  std::vector<std::size_t> root(lattice.node_rest.size());
  std::iota(root.begin(), root.end(), std::size_t{0});
  const auto find = [&](std::size_t a) {
    while (root[a] != a) a = root[a] = root[root[a]];
    return a;
  };
  for (const auto& nodes : lattice.cell_nodes)
    for (const std::int32_t n : nodes) {
      const std::size_t a = find(nodes[0]), b = find(n);
      root[std::max(a, b)] = std::min(a, b);
    }
  for (std::size_t n = 0; n < root.size(); ++n) root[n] = find(n);
  return root;
}

TEST(AnchorStencil, HoldsItsAnchorInEveryAffineMotion) {
  const Surface ball = test::sphere(Vec3(5, 5, 5), 4.0, 12);
  Eigen::Matrix3d turn;
  turn << 0.2, -1.3, 0.4, 1.1, 0.3, -0.2, 0.1, 0.6, 0.9;
  for (const double h : {0.3, 0.7, 1.0, 2.2}) {
    const Lattice lattice = build_lattice(ball, spaced(h));
    const AnchorStencils stencils(lattice, ball, kStencilRadius);
    for (std::size_t t = 0; t < ball.triangles.size(); t += 7) {
      const AnchorStencil held = stencils.around(center(ball, t), to_index(t));
      EXPECT_NEAR(std::accumulate(held.weights.begin(), held.weights.end(), 0.0), 1.0, 1e-12);
      Vec3 moved = Vec3::Zero();
      for (std::size_t k = 0; k < held.nodes.size(); ++k)
        moved += held.weights[k] * (turn * lattice.node_rest[held.nodes[k]] + Vec3(7, 8, 9));
      EXPECT_LT((moved - turn * center(ball, t) - Vec3(7, 8, 9)).norm(), 1e-10);
    }
  }
}

// Trilinear functions spread a point by t (1 - t) h^2 along an axis, t its place in the cell: at most h^2 / 4.
TEST(AnchorStencil, SpreadsOverAsMuchTissueHoweverTheLatticeLies) {
  const Surface block = box_surface({0, 0, 0}, {8, 8, 4});
  std::size_t top = 0;
  while (center(block, top)[2] < 4 - 1e-9) ++top;
  const Vec3 anchor = center(block, top);
  const auto spread_with = [&](double h, const Vec3& origin) {
    LatticeSettings settings = spaced(h);
    settings.origin = origin;
    const Lattice lattice = build_lattice(block, settings);
    return spread(lattice, held_at(lattice, block, top), anchor);
  };
  const Eigen::Matrix3d fine = spread_with(0.125, Vec3::Zero());
  // Under a flat face the second moment along the face is that of k over half a ball, radius^2 / 7; the weights that
  // hold the first moment in depth leave more near the face, where the ball is wider.
  EXPECT_NEAR(fine(0, 0), kStencilRadius * kStencilRadius / 7.0, 0.4 * kStencilRadius * kStencilRadius / 7.0);
  EXPECT_NEAR(fine(0, 0), fine(1, 1), 0.02);
  EXPECT_NEAR(fine(0, 1), 0.0, 0.02);
  for (const double h : {0.25, 0.5, 1.0, 2.0})
    for (const Vec3& share : {Vec3(0, 0, 0), Vec3(0.5, 0.5, 0.5), Vec3(0.3, 0.8, 0.1)}) {
      const Eigen::Matrix3d wide = spread_with(h, h * share);
      for (int axis = 0; axis < 2; ++axis) {
        EXPECT_GT(wide(axis, axis), fine(axis, axis) - 0.02) << h;
        EXPECT_LT(wide(axis, axis), fine(axis, axis) + 0.25 * h * h + 0.02) << h;
      }
    }
}

TEST(AnchorStencil, IsTheSameOnEverySideOfAnAnchorDeepInTheTissue) {
  const Surface block = box_surface({0, 0, 0}, {8, 8, 8});
  const Lattice lattice = build_lattice(block, spaced(0.25));
  const Vec3 anchor(4.1, 3.9, 4.05);
  const AnchorStencil held = AnchorStencils(lattice, block, kStencilRadius).around(anchor, 0);
  const Eigen::Matrix3d mean = spread(lattice, held, anchor);
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)  // over a ball; the trilinear functions add 0.25 h^2 at most
      EXPECT_NEAR(mean(a, b), a == b ? kStencilRadius * kStencilRadius / 7.0 : 0.0, 0.02);
  for (const double weight : held.weights) EXPECT_GE(weight, 0.0);
}

TEST(AnchorStencil, NeverReachesAcrossACut) {
  const auto slab = test::cut_slab(10, 8, 3, {{5.03, -1}, {4.9, 3.1}, {5.2, 9}}, 0.04);
  for (const double h : {0.4, 1.0, 2.0}) {
    const Lattice lattice = build_lattice(slab.surface, spaced(h));
    const auto piece = pieces(lattice);
    const AnchorStencils stencils(lattice, slab.surface, kStencilRadius);
    std::size_t beside = 0;
    for (std::size_t t = 0; t < slab.surface.triangles.size(); ++t) {
      const Vec3 anchor = center(slab.surface, t);
      const AnchorStencil held = stencils.around(anchor, to_index(t));
      const EmbeddedPoint point = embed_on_triangle(lattice, slab.surface, anchor, to_index(t));
      const std::size_t own = lattice.cell_nodes[point.cell][0];
      for (const std::int32_t n : held.nodes) EXPECT_EQ(piece[n], piece[own]);
      beside += std::abs(anchor[0] - 5.0) < 0.5;
    }
    EXPECT_GE(beside, 4u) << "anchors on the walls of the cut";
    EXPECT_NE(piece.front(), piece.back()) << "two pieces";
  }
}

// The surface triangle nearest to a point beside the cut lies on its wall, whichever side that is.
TEST(AnchorStencil, HoldsDeepAnchorsOnTheirOwnSideOfACut) {
  const auto slab = test::cut_slab(10, 8, 6, {{5.0, -1}, {5.0, 9}}, 0.04);
  const Lattice lattice = build_lattice(slab.surface, spaced(1.0));
  const auto piece = pieces(lattice);
  const AnchorStencils stencils(lattice, slab.surface, kStencilRadius);
  for (const double x : {2.0, 4.3, 4.9, 5.1, 5.7, 8.0}) {
    const Vec3 anchor(x, 4.2, 3.1);
    double nearest = 1e9;
    std::size_t triangle = 0;
    for (std::size_t t = 0; t < slab.surface.triangles.size(); ++t) {
      const auto& c = slab.surface.triangles[t];
      const Vec3 &a = slab.surface.points[c[0]], &b = slab.surface.points[c[1]], &d = slab.surface.points[c[2]];
      const Vec3 normal = (b - a).cross(d - a).normalized();
      const double height = (a - anchor).dot(normal);
      if (height >= 0.0 && height < nearest) nearest = height, triangle = t;
    }
    const AnchorStencil held = stencils.around(anchor, to_index(triangle));
    Vec3 mean = Vec3::Zero();
    for (std::size_t k = 0; k < held.nodes.size(); ++k) mean += held.weights[k] * lattice.node_rest[held.nodes[k]];
    EXPECT_LT((mean - anchor).norm(), 1e-9) << "it stays where it is put";
    for (const Index n : held.nodes) EXPECT_EQ(piece[n], piece[x < 5.0 ? 0 : lattice.node_rest.size() - 1]) << x;
  }
}

TEST(AnchorStencil, SaysHowMuchOfItAnotherHoldsToo) {
  const AnchorStencil a{{1, 2, 3}, {0.5, 0.25, 0.25}}, b{{2, 3, 4}, {0.25, 0.25, 0.5}}, c{{7, 8}, {0.5, 0.5}};
  EXPECT_DOUBLE_EQ(shared_hold(a, a), 1.0);
  EXPECT_DOUBLE_EQ(shared_hold(a, b), 0.5);
  EXPECT_DOUBLE_EQ(shared_hold(a, c), 0.0);
}

// Two blocks of 6 x 8 x 3 mm, 1 mm apart.
Surface two_blocks() {
  Surface s = box_surface({0, 0, 0}, {6, 8, 3});
  append(s, box_surface({7, 0, 0}, {13, 8, 3}));
  return s;
}

std::size_t triangle_at(const Surface& s, double x) {
  for (std::size_t t = 0; t < s.triangles.size(); ++t)
    if (std::abs(center(s, t)[0] - x) < 1e-9) return t;
  return s.triangles.size();
}

TEST(AnchorStencil, ItsForceIsTheGradientOfItsEnergy) {
  const Surface s = two_blocks();
  const Lattice lattice = build_lattice(s, spaced(0.5));
  Attachments loose;
  loose.node_group.assign(lattice.node_rest.size(), kFree);
  System<double> system(lattice, CellMaterials{{MaterialParameters{}}}, 1, loose, 0, {}, Vec3::Zero());
  const AnchorStencil left = held_at(lattice, s, triangle_at(s, 6.0)), right = held_at(lattice, s, triangle_at(s, 7.0));
  EXPECT_GT(left.nodes.size(), 20u);
  PointConstraint suture = make_suture(lattice, left, right, Vec3(0.1, 0.2, 0.3), 5000.0);
  suture.id.kind = ConstraintId::Kind::kSuture;
  system.set_point_constraints({suture, make_hook(lattice, left, Vec3(5, 5, 5), 300.0)});
  const Multipliers multipliers{{{suture.id, Vec3(10, -20, 30)}}, {}, {}, {}};
  std::mt19937 random(5);
  std::uniform_real_distribution<double> draw(-0.05, 0.05);
  std::vector<double> u(3 * system.nodes()), way(u.size()), trial(u.size());
  for (double& x : u) x = draw(random);
  for (double& x : way) x = draw(random);
  const Evaluation at = system.evaluate(u, multipliers);
  double expected = 0.0;
  for (std::size_t i = 0; i < u.size(); ++i) expected += at.gradient[i] * way[i];
  const auto energy = [&](double step) {
    for (std::size_t i = 0; i < u.size(); ++i) trial[i] = u[i] + step * way[i];
    return system.evaluate(trial, multipliers).energy;
  };
  EXPECT_NEAR((energy(1e-4) - energy(-1e-4)) / 2e-4, expected, 1e-5 * std::abs(expected));
}

// A suture between the walls of two blocks draws them together; the force that this takes would fall to nothing with
// the spacing were it held at points.
TEST(AnchorStencil, ASutureNeedsAsMuchForceAndBendsCellsAsMuchOnAFinerLattice) {
  const auto closed = [](double spacing) {
    SessionSettings settings;
    settings.spacing = spacing;
    settings.sutures = 1;
    Session session(settings);
    EpochInput epoch = make_epoch(two_blocks(), [](const Vec3& c) { return c[0] < 1e-9 || c[0] > 13 - 1e-9; });
    add_landmark(epoch, Vec3(6, 4.4, 1.4));
    add_landmark(epoch, Vec3(7, 4.4, 1.4));
    add_landmark(epoch, Vec3(6, 6, 1.4));
    session.set_epoch(epoch);
    FrameInput frame;
    frame.time = 1;
    frame.sutures = {{0,
                      {epoch.landmarks[0], epoch.landmark_triangles[0]},
                      {epoch.landmarks[1], epoch.landmark_triangles[1]},
                      1.0,
                      1000.0}};
    const FrameOutput out = session.solve(frame, {}, kNever);
    EXPECT_TRUE(out.converged) << out.failure.message;
    return out;
  };
  const FrameOutput coarse = closed(0.5), fine = closed(0.25);
  EXPECT_GT(coarse.suture_forces[0], 10.0);
  EXPECT_NEAR(fine.suture_forces[0], coarse.suture_forces[0], 0.1 * coarse.suture_forces[0]);
  EXPECT_NEAR(fine.energy, coarse.energy, 0.1 * coarse.energy);
  EXPECT_NEAR(fine.landmarks[6], coarse.landmarks[6], 0.02);  // 2 mm beside it
  EXPECT_GT(fine.minimum_j, 0.5 * coarse.minimum_j);
  for (const FrameOutput* out : {&coarse, &fine})
    for (const std::size_t axis : {0, 1, 2}) EXPECT_NEAR(out->suture_points[axis], out->suture_points[3 + axis], 2e-3);
}

}  // namespace
}  // namespace lappet
