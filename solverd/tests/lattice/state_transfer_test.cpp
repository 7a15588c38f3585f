#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/LU>

#include "lattice/lattice.h"
#include "lattice/refused.h"
#include "test_surfaces.h"

namespace lappet {
namespace {

LatticeSettings settings(int ratio) {
  LatticeSettings result;
  result.fine_ratio = ratio;
  return result;
}

std::vector<Vec3> affine(const Lattice& lattice) {
  Eigen::Matrix3d f;
  f << 1.2, 0.1, -0.05, 0.02, 0.9, 0.3, -0.1, 0.07, 1.1;
  std::vector<Vec3> result;
  for (const Vec3& x : lattice.node_rest) result.push_back(f * x + Vec3(1, -2, 3));
  return result;
}

TEST(StateTransfer, AnAffineFieldAcrossACutIsExact) {
  const Lattice whole = build_lattice(test::box(Vec3(0, 0, 0), Vec3(14, 9, 3)), settings(4));
  for (const double kerf : {0.01, 1.3}) {
    const Lattice cut = build_lattice(
        test::cut_slab(14, 9, 3, {{6, 0}, {6, 2}, {9.3, 3}, {3.6, 6}, {6, 7}, {6, 9}}, kerf).surface, settings(4));
    const auto carried = transfer_positions(whole, affine(whole), cut);
    const auto expected = affine(cut);
    ASSERT_EQ(carried.size(), expected.size());
    for (std::size_t n = 0; n < carried.size(); ++n) EXPECT_EQ(carried[n], expected[n]);
  }
}

TEST(StateTransfer, AFieldThatJumpsAcrossACutKeepsItsJumpThroughASecondCut) {
  const auto first = test::cut_slab(16, 8, 3, {{6.4, 0}, {7.1, 8}}, 0.01);
  const Lattice one = build_lattice(first.surface, settings(4));
  // Second epoch: the right piece is cut once more, and the rest is as it was.
  Surface again = test::prism({{0, 0}, {6.395, 0}, {7.095, 8}, {0, 8}}, 0.0, 3.0);
  test::append(again, test::prism({{6.405, 0}, {11.2, 0}, {11.2, 8}, {7.105, 8}}, 0.0, 3.0));
  test::append(again, test::prism({{11.21, 0}, {16, 0}, {16, 8}, {11.21, 8}}, 0.0, 3.0));
  const Lattice two = build_lattice(again, settings(4));
  ASSERT_EQ(one.fragments, 2);
  ASSERT_EQ(two.fragments, 3);
  // The left piece moved away; which nodes are left follows from where the embedded points are.
  const auto is_left = [](const Lattice& lattice) {
    std::vector<char> left(lattice.node_rest.size(), 0);
    for (std::size_t n = 0; n < left.size(); ++n) left[n] = lattice.node_rest[n].x() == 0.0;
    for (bool grew = true; grew;) {
      grew = false;
      for (const auto& nodes : lattice.cell_nodes) {
        int count = 0;
        for (const auto n : nodes) count += left[n];
        if (count == 0 || count == 8) continue;
        for (const auto n : nodes) left[n] = 1;
        grew = true;
      }
    }
    return left;
  };
  const auto place = [&](const Lattice& lattice) {
    const auto left = is_left(lattice);
    std::vector<Vec3> result = lattice.node_rest.all();
    for (std::size_t n = 0; n < result.size(); ++n) result[n] += left[n] ? Vec3(-5, 0.25, 1) : Vec3(0, 2, 0.5);
    return result;
  };
  EXPECT_EQ(transfer_positions(one, place(one), two), place(two));
}

TEST(StateTransfer, AnExcisionThatShrinksTheBoxKeepsEveryPosition) {
  const Lattice whole = build_lattice(test::box(Vec3(0, 0, 0), Vec3(10, 6, 3)), settings(6));
  const Lattice rest = build_lattice(test::box(Vec3(3.5, 1, 0), Vec3(9, 6, 3)), settings(6));
  const auto carried = transfer_positions(whole, affine(whole), rest);
  EXPECT_EQ(carried, affine(rest));
}

TEST(StateTransfer, TissueThatWasNotThereMovesWithItsNeighbors) {
  const Lattice small = build_lattice(test::box(Vec3(0, 0, 0), Vec3(4, 4, 2)), settings(4));
  Surface larger = test::box(Vec3(0, 0, 0), Vec3(9, 4, 2));
  test::append(larger, test::box(Vec3(12, 0, 0), Vec3(13, 1, 1)));
  const Lattice large = build_lattice(larger, settings(4));
  std::vector<Vec3> moved = small.node_rest.all();
  for (Vec3& p : moved) p += Vec3(0.5, -1, 2);
  const auto carried = transfer_positions(small, moved, large);
  for (std::size_t n = 0; n < carried.size(); ++n)
    EXPECT_EQ(carried[n], large.node_rest[n] + (large.node_rest[n].x() > 11 ? Vec3(0, 0, 0) : Vec3(0.5, -1, 2)));
}

TEST(StateTransfer, LatticesOfDifferentSpacingRatioOrOriginAreRefused) {
  const Surface box = test::box(Vec3(0, 0, 0), Vec3(4, 4, 2));
  const Lattice a = build_lattice(box, settings(4)), b = build_lattice(box, settings(6));
  EXPECT_THROW((void)transfer_positions(a, a.node_rest.all(), b), RefusedError);
  const std::vector<Vec3> rest = a.node_rest.all();
  EXPECT_THROW((void)transfer_positions(a, std::span(rest).first(3), a), RefusedError);
}

TEST(StateTransfer, TheSameSurfaceGivesTheSameLatticeAndKeepsTheStateBitForBit) {
  const auto slab = test::cut_slab(14, 9, 3, {{6, 0}, {9.3, 3}, {3.6, 6}, {6, 9}}, 0.05);
  const Lattice a = build_lattice(slab.surface, settings(4)), b = build_lattice(slab.surface, settings(4));
  EXPECT_EQ(a.cell_nodes, b.cell_nodes);
  EXPECT_EQ(a.cell_positions(), b.cell_positions());
  EXPECT_EQ(a.cell_fill, b.cell_fill);
  for (std::size_t p = 0; p < a.surface_points.size(); ++p) {
    EXPECT_EQ(a.surface_points[p].cell, b.surface_points[p].cell);
    EXPECT_EQ(a.surface_points[p].weights, b.surface_points[p].weights);
  }
  std::vector<Vec3> state = a.node_rest.all();
  for (std::size_t n = 0; n < state.size(); ++n) state[n] += Vec3::Constant(0.1 / (1.0 + double(n)));
  EXPECT_EQ(transfer_positions(a, state, b), state);
}

}  // namespace
}  // namespace lappet
