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

EmbeddedPoint anchored(const Lattice& lattice, const Surface& surface, std::size_t triangle) {
  return embed_on_triangle(lattice, surface, center(surface, triangle), to_index(triangle));
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
  for (const double h : {0.3, 0.45, 0.7, 0.95}) {
    const Lattice lattice = build_lattice(ball, spaced(h));
    for (std::size_t t = 0; t < ball.triangles.size(); t += 7) {
      const AnchorStencil held = anchor_stencil(lattice, anchored(lattice, ball, t));
      EXPECT_NEAR(std::accumulate(held.weights.begin(), held.weights.end(), 0.0), 1.0, 1e-12);
      Vec3 moved = Vec3::Zero();
      for (std::size_t k = 0; k < held.nodes.size(); ++k)
        moved += held.weights[k] * (turn * lattice.node_rest[held.nodes[k]] + Vec3(7, 8, 9));
      EXPECT_LT((moved - turn * center(ball, t) - Vec3(7, 8, 9)).norm(), 1e-10);
    }
  }
}

TEST(AnchorStencil, SpreadsOverAsMuchTissueHoweverFineTheLattice) {
  // Under a flat face the second moment along the face is that of k over half a ball, radius^2 / 7.
  const Surface block = box_surface({0, 0, 0}, {8, 8, 4});
  for (const double h : {0.25, 0.125}) {
    const Lattice lattice = build_lattice(block, spaced(h));
    std::size_t top = 0;
    while (center(block, top)[2] < 4 - 1e-9) ++top;
    const Vec3 anchor = center(block, top);
    const AnchorStencil held = anchor_stencil(lattice, anchored(lattice, block, top));
    double share = 0.0, along = 0.0, off = 0.0;
    for (std::size_t k = 0; k < held.nodes.size(); ++k) {
      const Vec3 x = lattice.node_rest[held.nodes[k]] - anchor;
      EXPECT_LE(x.norm(), kStencilRadius);
      share += held.weights[k] * held.weights[k];
      along += held.weights[k] * x[0] * x[0];
      off += held.weights[k] * x[0] * x[1];
    }
    // one-sided in depth: the weights that hold the first moment there leave more near the face, where k is wider
    EXPECT_NEAR(along, kStencilRadius * kStencilRadius / 7.0, 0.4 * kStencilRadius * kStencilRadius / 7.0) << h;
    EXPECT_NEAR(off, 0.0, 0.02 * kStencilRadius * kStencilRadius) << h;
    EXPECT_LT(share, 0.2) << "many nodes share the force at " << h;
  }
}

TEST(AnchorStencil, NeverReachesAcrossACut) {
  const auto slab = test::cut_slab(10, 8, 3, {{5.03, -1}, {4.9, 3.1}, {5.2, 9}}, 0.04);
  const Lattice lattice = build_lattice(slab.surface, spaced(0.4));
  const auto piece = pieces(lattice);
  std::size_t beside = 0;
  for (std::size_t t = 0; t < slab.surface.triangles.size(); ++t) {
    const EmbeddedPoint anchor = anchored(lattice, slab.surface, t);
    const AnchorStencil held = anchor_stencil(lattice, anchor);
    const std::size_t own = lattice.cell_nodes[anchor.cell][0];
    for (const std::int32_t n : held.nodes) EXPECT_EQ(piece[n], piece[own]);
    beside += std::abs(center(slab.surface, t)[0] - 5.0) < 0.5;
  }
  EXPECT_GE(beside, 4u) << "anchors on the walls of the cut";
  EXPECT_NE(piece.front(), piece.back()) << "two pieces";
}

TEST(AnchorStencil, IsTrilinearWhereCellsAreAsLargeAsItIs) {
  const Surface ball = test::sphere(Vec3(5, 5, 5), 4.0, 12);
  for (const double h : {kStencilRadius, 1.3}) {
    const Lattice lattice = build_lattice(ball, spaced(h));
    for (std::size_t t = 0; t < ball.triangles.size(); t += 7) {
      const EmbeddedPoint anchor = anchored(lattice, ball, t);
      const AnchorStencil held = anchor_stencil(lattice, anchor);
      double sum = 0.0;
      for (std::size_t k = 0; k < 8; ++k) {
        const std::int32_t node = lattice.cell_nodes[anchor.cell][k];
        for (std::size_t i = 0; i < held.nodes.size(); ++i)
          if (held.nodes[i] == node) {
            EXPECT_NEAR(held.weights[i], anchor.weights[k], 1e-12);
            sum += held.weights[i];
          }
      }
      EXPECT_NEAR(sum, 1.0, 1e-9);
    }
  }
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
  System<double> system(lattice, CellMaterials{{MaterialParameters{}}}, 1, loose, 0, 0.0, Vec3::Zero());
  const AnchorStencil left = anchor_stencil(lattice, anchored(lattice, s, triangle_at(s, 6.0))),
                      right = anchor_stencil(lattice, anchored(lattice, s, triangle_at(s, 7.0)));
  EXPECT_GT(left.nodes.size(), 20u);
  PointConstraint suture = make_suture(lattice, left, right, Vec3(0.1, 0.2, 0.3), 5000.0);
  suture.id.kind = ConstraintId::Kind::kSuture;
  system.set_point_constraints({suture, make_hook(lattice, left, Vec3(5, 5, 5), 300.0)});
  const Multipliers multipliers{{{suture.id, Vec3(10, -20, 30)}}, {}, {}};
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
