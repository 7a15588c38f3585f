#include "lattice/nonmanifold.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <ostream>
#include <set>

#include "lattice/lattice.h"
#include "lattice/refused.h"
#include "test_surfaces.h"

namespace lappet {
namespace {

using Polyline = std::vector<Eigen::Vector2d>;

LatticeSettings settings(double spacing, int ratio) {
  LatticeSettings result;
  result.spacing = spacing;
  result.fine_ratio = ratio;
  return result;
}

// The connected component of every cell over shared nodes.
std::vector<int> components(const Lattice& lattice, int& count) {
  std::vector<std::vector<std::size_t>> cells_of(lattice.node_rest.size());
  for (std::size_t cell = 0; cell < lattice.cell_nodes.size(); ++cell)
    for (const std::int32_t n : lattice.cell_nodes[cell]) cells_of[n].push_back(cell);
  std::vector<int> result(lattice.cell_nodes.size(), -1);
  count = 0;
  for (std::size_t seed = 0; seed < result.size(); ++seed) {
    if (result[seed] >= 0) continue;
    std::vector<std::size_t> stack{seed};
    result[seed] = count;
    while (!stack.empty()) {
      const std::size_t cell = stack.back();
      stack.pop_back();
      for (const std::int32_t n : lattice.cell_nodes[cell])
        for (const std::size_t other : cells_of[n])
          if (result[other] < 0) {
            result[other] = count;
            stack.push_back(other);
          }
    }
    ++count;
  }
  return result;
}

// What must hold for every lattice.
void expect_sound(const Lattice& lattice) {
  std::map<std::array<double, 3>, int> duplicates;
  for (const Vec3& p : lattice.node_rest) ++duplicates[{p.x(), p.y(), p.z()}];
  std::int32_t grid = 0, mesh = 0;
  std::vector<char> used(lattice.node_rest.size(), 0);
  std::set<std::array<std::int32_t, 8>> distinct;
  for (std::size_t cell = 0; cell < lattice.cell_nodes.size(); ++cell) {
    bool on_grid = true;
    for (std::size_t c = 0; c < 8; ++c) {
      const std::size_t n = lattice.cell_nodes[cell][c];
      used[n] = 1;
      const auto& at = lattice.cell_position(cell);
      const Vec3 corner(at[0] + double(c >> 2 & 1), at[1] + double(c >> 1 & 1), at[2] + double(c & 1));
      EXPECT_EQ(lattice.node_rest[n], lattice.settings.origin + lattice.settings.spacing * corner);
      const Vec3& p = lattice.node_rest[n];
      on_grid = on_grid && duplicates[{p.x(), p.y(), p.z()}] == 1;
    }
    ++(on_grid ? grid : mesh);
    EXPECT_TRUE(distinct.insert(lattice.cell_nodes[cell]).second) << "two cells with the same nodes";
    EXPECT_GE(lattice.cell_fill[cell], float(lattice.settings.fill_floor));
    // Half a voxel of tissue may lie beyond each face of a cell that is the last one.
    EXPECT_LE(lattice.cell_fill[cell], float(std::pow(1.0 + 1.0 / lattice.settings.fine_ratio, 3)));
  }
  EXPECT_EQ(grid, lattice.grid_cells);
  EXPECT_EQ(mesh, lattice.mesh_cells);
  for (const char u : used) EXPECT_TRUE(u) << "a node without a cell";
}

TEST(Nonmanifold, ALatticeAlignedBoxIsExact) {
  auto s = settings(0.7, 4);
  s.origin = Vec3(-1.3, 2.1, 0.4);
  const Lattice lattice = build_lattice(test::box(s.origin, s.origin + 0.7 * Vec3(6, 5, 3)), s);
  expect_sound(lattice);
  EXPECT_EQ(lattice.cell_nodes.size(), 6U * 5 * 3);
  EXPECT_EQ(lattice.node_rest.size(), 7U * 6 * 4);
  EXPECT_EQ(lattice.grid_cells, 90);
  EXPECT_EQ(lattice.mesh_cells, 0);
  EXPECT_EQ(lattice.fragments, 1);
  EXPECT_EQ(lattice.fine_voxels, 90 * 64);
  EXPECT_EQ(lattice.dropped_voxels, 0);
  for (const float fill : lattice.cell_fill) EXPECT_EQ(fill, 1.0F);
}

TEST(Nonmanifold, ABoxBelowTheOriginHasNegativePositions) {
  const Lattice lattice = build_lattice(test::box(Vec3(-3, -2, -1), Vec3(1, 1, 1)), settings(1.0, 4));
  expect_sound(lattice);
  EXPECT_EQ(lattice.cell_nodes.size(), 4U * 3 * 2);
  EXPECT_EQ(lattice.cell_position(0), (std::array<std::int32_t, 3>{-3, -2, -1}));
}

TEST(Nonmanifold, TheVolumeOfABallByFillConverges) {
  const double radius = 5.0, exact = 4.0 / 3.0 * std::numbers::pi * std::pow(radius, 3);
  const Surface ball = test::sphere(Vec3(6.1, 6.2, 6.3), radius, 60);
  for (const double spacing : {2.0, 1.0, 0.5}) {
    auto s = settings(spacing, 4);
    s.fill_floor = 1e-6;
    const Lattice lattice = build_lattice(ball, s);
    expect_sound(lattice);
    double volume = 0.0;
    for (const float fill : lattice.cell_fill) volume += fill * std::pow(spacing, 3);
    EXPECT_NEAR(volume / exact, 1.0, 0.005 * spacing) << spacing;
    EXPECT_EQ(lattice.fragments, 1);
  }
}

TEST(Nonmanifold, TheNumberingIsInGridOrderWithDuplicatesSideBySide) {
  const Lattice lattice = build_lattice(test::cut_slab(12, 8, 4, {{5.5, 0}, {6.3, 8}}, 0.01).surface, settings(1.0, 4));
  const auto less = [](const Vec3& a, const Vec3& b) {
    return std::tuple(a.x(), a.y(), a.z()) <= std::tuple(b.x(), b.y(), b.z());
  };
  for (std::size_t n = 1; n < lattice.node_rest.size(); ++n)
    EXPECT_TRUE(less(lattice.node_rest[n - 1], lattice.node_rest[n]));
  EXPECT_TRUE(std::ranges::is_sorted(lattice.cell_positions()));
}

struct Cut {
  const char* name;
  Polyline line;  // y never falls, so that the two pieces do not overlap
};
void PrintTo(const Cut& cut, std::ostream* out) { *out << cut.name; }

class ThroughCut : public testing::TestWithParam<Cut> {};

TEST_P(ThroughCut, SeparatesTheSlabAtEveryRatioAndKerf) {
  for (const int ratio : {4, 6, 10})
    for (const double kerf : {0.0, 0.01, 0.1, 1.0}) {
      SCOPED_TRACE(testing::Message() << "ratio " << ratio << ", kerf " << kerf);
      const auto slab = test::cut_slab(20, 12, 3, GetParam().line, kerf);
      const Lattice lattice = build_lattice(slab.surface, settings(1.0, ratio));
      expect_sound(lattice);
      EXPECT_EQ(lattice.fragments, 2);
      int count = 0;
      const auto side = components(lattice, count);
      ASSERT_EQ(count, 2);
      // The far ends of the slab belong to different pieces.
      EXPECT_NE(side.front(), side.back());
      EXPECT_GT(lattice.mesh_cells, 0);
      // Tissue is neither lost nor made: what the kerf takes is its area times the height.
      double volume = double(lattice.fine_voxels) / std::pow(ratio, 3);
      EXPECT_NEAR(volume, 20 * 12 * 3 - kerf * 12 * 3, 12 * 3 * 1.05 / ratio);
      // Every surface point is embedded in its own piece.
      for (std::size_t p = 0; p < slab.surface.points.size(); ++p)
        EXPECT_EQ(side[lattice.surface_points[p].cell], p < slab.left_points ? side.front() : side.back())
            << "point " << slab.surface.points[p].transpose();
    }
}

INSTANTIATE_TEST_SUITE_P(Cuts, ThroughCut,
                         testing::Values(Cut{"StraightAtAnyPlace", {{9.37, 0}, {9.37, 12}}},
                                         Cut{"StraightOnCellFaces", {{10, 0}, {10, 12}}},
                                         Cut{"StraightOnVoxelCenters", {{10.125, 0}, {10.125, 12}}},
                                         Cut{"StraightOnCentersAtRatioTen", {{10.05, 0}, {10.05, 12}}},
                                         Cut{"Oblique", {{6.2, 0}, {14.9, 12}}}, Cut{"Diagonal", {{4, 0}, {16, 12}}},
                                         Cut{"ZShaped", {{10, 0}, {10, 3}, {15.1, 4}, {4.8, 8}, {10, 9}, {10, 12}}},
                                         Cut{"SharpTips", {{10, 0}, {3.3, 4.1}, {16.6, 4.8}, {4.4, 8.2}, {10, 12}}}),
                         [](const auto& info) { return info.param.name; });

// A slab with a slot of width `kerf` cut down from the top, right along x, at y = 5.3.
Surface partly_cut_slab(double kerf, double bottom) {
  return test::prism({{0, 0}, {10, 0}, {10, 4}, {5.3 + kerf / 2, 4}, {5.3, bottom}, {5.3 - kerf / 2, 4}, {0, 4}}, 0.0,
                     12.0, 0);
}

TEST(Nonmanifold, ACutOfPartialDepthLeavesOnePieceWithMeshCellsAtTheCut) {
  for (const int ratio : {4, 6, 10})
    for (const double kerf : {0.01, 0.1, 1.0}) {
      SCOPED_TRACE(testing::Message() << "ratio " << ratio << ", kerf " << kerf);
      const Lattice lattice = build_lattice(partly_cut_slab(kerf, 2.0), settings(1.0, ratio));
      expect_sound(lattice);
      EXPECT_EQ(lattice.fragments, 1);
      EXPECT_GE(lattice.mesh_cells, 12);
      // The cut opens the lattice: a node at its top has a duplicate, one below its bottom has none.
      int above = 0, below = 0;
      for (const Vec3& p : lattice.node_rest) {
        above += p.x() == 6 && p.z() == 4 && (p.y() == 5 || p.y() == 6);
        below += p.x() == 6 && p.z() == 1 && (p.y() == 5 || p.y() == 6);
      }
      EXPECT_GE(above, 3);
      EXPECT_EQ(below, 2);
    }
}

TEST(Nonmanifold, ACutThatEndsInsideLeavesOnePieceWithMeshCellsAtTheCut) {
  for (const int ratio : {4, 6, 10})
    for (const double kerf : {0.01, 0.1, 1.0}) {
      SCOPED_TRACE(testing::Message() << "ratio " << ratio << ", kerf " << kerf);
      const Surface slab = test::prism(
          {{0, 0}, {6.4 - kerf / 2, 0}, {6.4, 7.3}, {6.4 + kerf / 2, 0}, {12, 0}, {12, 10}, {0, 10}}, 0.0, 3.0);
      const Lattice lattice = build_lattice(slab, settings(1.0, ratio));
      expect_sound(lattice);
      EXPECT_EQ(lattice.fragments, 1);
      EXPECT_GE(lattice.mesh_cells, 7 * 3);
      EXPECT_GT(lattice.grid_cells, 12 * 10 * 3 / 2);
      for (std::size_t cell = 0; cell < lattice.cell_nodes.size(); ++cell) EXPECT_LE(lattice.cell_position(cell)[1], 9);
      // Past the end of the cut nothing is duplicated.
      std::map<std::array<double, 3>, int> duplicates;
      for (const Vec3& p : lattice.node_rest) ++duplicates[{p.x(), p.y(), p.z()}];
      for (const auto& [p, n] : duplicates)
        if (p[1] >= 9.0) {
          EXPECT_EQ(n, 1);
        }
    }
}

TEST(Nonmanifold, VoxelsThatASharpTipTearsOffAreNoPiecesOfTheirOwn) {
  // A flap whose tip of 10 degrees points along the diagonal: its last voxels touch only at corners.
  const double a = std::numbers::pi / 180.0 * 40.0, b = std::numbers::pi / 180.0 * 50.0;
  const Polyline flap{
      {1.3, 1.2}, {1.3 + 12 * std::cos(a), 1.2 + 12 * std::sin(a)}, {1.3 + 12 * std::cos(b), 1.2 + 12 * std::sin(b)}};
  std::int64_t dropped = 0;
  for (const int ratio : {4, 6, 10}) {
    const Surface surface = test::prism(flap, 0.0, 3.0);
    const Lattice lattice = build_lattice(surface, settings(1.0, ratio));
    EXPECT_EQ(lattice.fragments, 1) << ratio;
    dropped += lattice.dropped_voxels;
    EXPECT_LT(double(lattice.dropped_voxels), 0.03 * double(lattice.fine_voxels));
    for (const EmbeddedPoint& p : lattice.surface_points) EXPECT_GE(p.cell, 0);
  }
  EXPECT_GT(dropped, 0) << "this tip should have been too sharp for the voxels";
}

TEST(Nonmanifold, SmallPiecesOfTissueThatAreReallyApartAreKept) {
  Surface two = test::box(Vec3(0, 0, 0), Vec3(6, 6, 3));
  test::append(two, test::box(Vec3(8.1, 2.1, 1.1), Vec3(8.4, 2.4, 1.4)));
  EXPECT_EQ(build_lattice(two, settings(1.0, 4)).fragments, 2);
}

TEST(Nonmanifold, PiecesThatTouchAlongAnEdgeShareNoNode) {
  // Two boxes with one common edge, points merged there.
  Surface two = test::box(Vec3(0, 0, 0), Vec3(2, 2, 2));
  test::append(two, test::box(Vec3(2, 2, 0), Vec3(4, 4, 2)));
  const Lattice lattice = build_lattice(two, settings(1.0, 4));
  expect_sound(lattice);
  EXPECT_EQ(lattice.fragments, 2);
  int count = 0;
  components(lattice, count);
  EXPECT_EQ(count, 2);
  EXPECT_EQ(lattice.mesh_cells, 4);
}

TEST(Nonmanifold, CopiesWithTheSameNodesCollapseAndAddTheirFill) {
  // A cavity that is a thin horizontal disc splits one cell in the middle of a block in two; all around it the tissue
  // is whole, so both halves have the same eight nodes.
  Surface block = test::box(Vec3(0, 0, 0), Vec3(3, 3, 3));
  Surface cavity = test::box(Vec3(1.01, 1.01, 1.49), Vec3(1.99, 1.99, 1.51));
  for (auto& t : cavity.triangles) std::swap(t[0], t[1]);
  test::append(block, cavity);
  const auto s = settings(1.0, 4);
  const FineVoxels fine(block, s);
  EXPECT_EQ(fine.copy_count(), 28);
  const Lattice lattice = build_lattice(block, s);
  expect_sound(lattice);
  EXPECT_EQ(lattice.cell_nodes.size(), 27U);
  EXPECT_EQ(lattice.mesh_cells, 0);
  EXPECT_NEAR(lattice.cell_fill[13], 1.0 - 0.02, 1e-4);  // all lines through the cell along z cross the disc
}

TEST(Nonmanifold, FragmentsEqualTheConnectedComponentsOfTheVoxels) {
  const auto slab = test::cut_slab(8, 6, 2, {{2.1, 0}, {5.7, 2.2}, {3.1, 4.4}, {4.4, 6}}, 0.03);
  const FineVoxels fine(slab.surface, settings(1.0, 4));
  const auto fragments = find_fragments(fine, find_links(fine));
  // Flood fill over single voxels, as an independent count.
  std::set<Voxel> rest;
  for (std::int32_t x = 0; x < 32; ++x)
    for (std::int32_t y = 0; y < 24; ++y)
      for (std::int32_t z = 0; z < 8; ++z)
        if (fine.inside({x, y, z})) rest.insert({x, y, z});
  std::vector<std::int64_t> sizes;
  while (!rest.empty()) {
    std::vector<Voxel> stack{*rest.begin()};
    rest.erase(rest.begin());
    sizes.push_back(0);
    while (!stack.empty()) {
      const Voxel v = stack.back();
      stack.pop_back();
      ++sizes.back();
      for (int axis = 0; axis < 3; ++axis)
        for (const int step : {-1, 1}) {
          Voxel n = v;
          n[axis] += step;
          if (rest.contains(n) && fine.connected_above(step > 0 ? v : n, axis)) {
            rest.erase(n);
            stack.push_back(n);
          }
        }
    }
  }
  auto found = fragments.voxels;
  std::sort(sizes.begin(), sizes.end());
  std::sort(found.begin(), found.end());
  EXPECT_EQ(found, sizes);
}

TEST(Nonmanifold, TissueThinnerThanTheVoxelsIsRefused) {
  for (const double top : {0.101, 0.15}) {
    try {
      (void)build_lattice(test::box(Vec3(0, 0, 0.1), Vec3(10, 10, top)), settings(1.0, 4));
      ADD_FAILURE() << "not refused: " << top;
    } catch (const RefusedError& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInvalidInput);
      EXPECT_NE(std::string(error.what()).find("too thin"), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace lappet
