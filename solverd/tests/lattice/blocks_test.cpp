// Manifold blocks (GRIDiron Algorithm 3), their layout for lanes and slabs, and the nodes of the hybrid lattice
// (Algorithm 2), on lattices with random cuts.
#include "lattice/blocks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <set>

#include "cut_lattices.h"
#include "force/elastic/block_layout.h"
#include "force/kernels/cell_corners.h"

namespace lappet {
namespace {

using test::CutLattice;

class CutLattices : public ::testing::TestWithParam<CutLattice> {
 protected:
  CutLattices() : lattice_(test::make_lattice(GetParam())) {}
  std::size_t cells() const { return lattice_.cell_nodes.size(); }
  // How many nodes lie at the place of each node.
  std::vector<int> copies() const {
    std::map<std::array<double, 3>, int> at;
    for (const Vec3& p : lattice_.node_rest) ++at[{p.x(), p.y(), p.z()}];
    std::vector<int> result;
    for (const Vec3& p : lattice_.node_rest) result.push_back(at[{p.x(), p.y(), p.z()}]);
    return result;
  }
  Lattice lattice_;
};

// Paper 5.4: what follows Algorithm 2.
TEST_P(CutLattices, GridCellsConsistOfGridNodesAndMeshCellsHoldAMeshNode) {
  const auto copies_of = copies();
  std::int32_t grid = 0, mesh = 0;
  std::map<std::array<std::int32_t, 3>, int> at;
  for (const auto& position : lattice_.cell_positions()) ++at[position];
  for (std::size_t c = 0; c < cells(); ++c) {
    const bool on_grid = std::all_of(lattice_.cell_nodes[c].begin(), lattice_.cell_nodes[c].end(),
                                     [&](std::int32_t n) { return copies_of[n] == 1; });
    ++(on_grid ? grid : mesh);
    if (on_grid) {
      EXPECT_EQ(at[lattice_.cell_position(c)], 1) << "two cells at the place of a grid cell";
    }
    EXPECT_EQ(std::set<std::int32_t>(lattice_.cell_nodes[c].begin(), lattice_.cell_nodes[c].end()).size(), 8U);
  }
  EXPECT_EQ(lattice_.grid_cells, grid);
  EXPECT_EQ(lattice_.mesh_cells, mesh);
  EXPECT_GT(mesh, 0) << "the cut left no mesh cell: the lattice tests nothing";
  EXPECT_GT(grid, 0);
}

TEST_P(CutLattices, EveryCellIsInOneBlockAndNoPlaceOfABlockHasTwoCellsOrTwoNodes) {
  std::vector<int> seen(cells(), 0);
  std::size_t crowded = 0;
  std::map<std::array<std::int32_t, 3>, int> at;
  for (const auto& block : build_blocks(lattice_)) {
    crowded += ++at[block.position] > 1;
    std::array<std::int32_t, kBlockNodes> nodes;
    nodes.fill(-1);
    for (int place = 0; place < kBlockCells; ++place) {
      const std::int32_t cell = block.cells[place];
      if (cell < 0) continue;
      ++seen[cell];
      const auto& p = lattice_.cell_position(cell);
      EXPECT_EQ(p[0], 2 * block.position[0] + (place >> 2));
      EXPECT_EQ(p[1], 2 * block.position[1] + (place >> 1 & 1));
      EXPECT_EQ(p[2], 2 * block.position[2] + (place & 1));
      for (int c = 0; c < 8; ++c) {
        auto& node = nodes[block_node(place, c)];
        const std::int32_t corner = lattice_.cell_nodes[cell][c];
        EXPECT_TRUE(node == -1 || node == corner) << "two nodes at one place of a block";
        node = corner;
      }
    }
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), static_cast<std::ptrdiff_t>(cells()));
  EXPECT_GT(crowded, 0U) << "no region needed two blocks: the lattice tests nothing";
}

TEST_P(CutLattices, EveryCellHasOneSlotWithItsNodesAndEmptySlotsUseNodesOfTheirBlock) {
  for (const int lanes : {1, 4, 8, 16}) {
    const BlockLayout layout = lay_out_blocks(lattice_, lanes);
    const std::size_t w = lanes;
    ASSERT_EQ(layout.slots(), static_cast<std::size_t>(layout.groups * kBlockCells) * w);
    std::vector<int> seen(cells(), 0);
    for (std::size_t slot = 0; slot < layout.slots(); ++slot) {
      const std::int32_t cell = layout.cell_of_slot[slot];
      if (cell < 0) continue;
      ++seen[cell];
      EXPECT_EQ(layout.slot_of_cell[cell], to_index(slot));
      const std::size_t group = slot / (kBlockCells * w), place = slot / w % kBlockCells, lane = slot % w;
      for (std::size_t c = 0; c < 8; ++c)
        EXPECT_EQ(test::node_of(layout, group, static_cast<std::size_t>(block_node(int(place), int(c))), lane),
                  lattice_.cell_nodes[cell][c]);
    }
    EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), static_cast<std::ptrdiff_t>(cells()));
    for (std::size_t group = 0; group < static_cast<std::size_t>(layout.groups); ++group)
      for (std::size_t n = 0; n < kBlockNodes; ++n)
        for (std::size_t lane = 0; lane < w; ++lane) {
          const std::int32_t node = test::node_of(layout, group, n, lane);
          ASSERT_GE(node, 0);
          ASSERT_LT(node, to_index(lattice_.node_rest.size()));
        }
  }
}

TEST_P(CutLattices, BlocksOfTheGridStoreOnlyWhereTheirColumnsBegin) {
  for (const int lanes : {1, 4}) {
    const BlockLayout layout = lay_out_blocks(lattice_, lanes);
    std::size_t grid = 0, mesh = 0;
    for (std::size_t group = 0; group < static_cast<std::size_t>(layout.groups); ++group) {
      const auto stored = layout.node_start[group + 1] - layout.node_start[group];
      ASSERT_TRUE(stored == 9 * lanes || stored == 27 * lanes);
      ++(stored == 9 * lanes ? grid : mesh);
      if (stored != 9 * lanes) continue;
      for (std::size_t lane = 0; lane < static_cast<std::size_t>(lanes); ++lane)
        for (std::size_t n = 0; n < kBlockNodes; ++n) {
          const auto at = [&](std::size_t k) { return lattice_.node_rest[test::node_of(layout, group, k, lane)]; };
          const Vec3 step(double(n / 9), double(n / 3 % 3), double(n % 3));
          EXPECT_LT((at(n) - at(0) - lattice_.settings.spacing * step).norm(), 1e-12);
        }
    }
    EXPECT_EQ(layout.node_start.back(), std::int64_t(layout.nodes.size()));
    EXPECT_GT(grid, 0U);
    EXPECT_GT(mesh, 0U);
  }
}

TEST_P(CutLattices, SlabsThatRunAtTheSameTimeShareNoNode) {
  std::size_t most = 0;
  for (const int lanes : {1, 4, 8, 16}) {
    const BlockLayout layout = lay_out_blocks(lattice_, lanes);
    ASSERT_EQ(layout.slab_start.front(), 0);
    ASSERT_EQ(layout.slab_start.back(), layout.groups);
    ASSERT_TRUE(std::is_sorted(layout.slab_start.begin(), layout.slab_start.end()));
    most = std::max(most, layout.slabs());
    for (std::size_t color = 0; color < 2; ++color) {
      std::vector<std::size_t> slab_of_node(lattice_.node_rest.size(), layout.slabs());
      for (std::size_t slab = color; slab < layout.slabs(); slab += 2)
        for (auto group = layout.slab_start[slab]; group < layout.slab_start[slab + 1]; ++group)
          for (std::size_t n = 0; n < kBlockNodes; ++n)
            for (int lane = 0; lane < lanes; ++lane) {
              const std::int32_t node = test::node_of(layout, static_cast<std::size_t>(group), n, lane);
              auto& owner = slab_of_node[node];
              ASSERT_TRUE(owner == layout.slabs() || owner == slab) << "slabs " << owner << " and " << slab;
              owner = slab;
            }
    }
  }
  EXPECT_GT(most, 2U) << "one slab of a color cannot share";
}

TEST_P(CutLattices, ForEachSlabVisitsEverySlabOnce) {
  const BlockLayout layout = lay_out_blocks(lattice_, 4);
  std::vector<int> visits(layout.slabs(), 0);
  layout.for_each_slab([&](std::size_t slab, std::int64_t begin, std::int64_t end) {
    ++visits[slab];
    EXPECT_EQ(begin, layout.slab_start[slab]);
    EXPECT_EQ(end, layout.slab_start[slab + 1]);
  });
  EXPECT_EQ(std::count(visits.begin(), visits.end(), 1), static_cast<std::ptrdiff_t>(layout.slabs()));
}

TEST_P(CutLattices, BlocksThatCannotMoveAreLeftOutAndNoOthers) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Vec3& rest : lattice_.node_rest) {
    low = std::min(low, rest[0]);
    high = std::max(high, rest[0]);
  }
  std::vector<std::uint8_t> still;
  for (const Vec3& rest : lattice_.node_rest) still.push_back(rest[0] <= 0.5 * (low + high));
  const BlockLayout layout = lay_out_blocks(lattice_, 4, still), whole = lay_out_blocks(lattice_, 4);
  const auto moves = [&](std::size_t cell) {
    return std::ranges::any_of(lattice_.cell_nodes[cell], [&](std::int32_t n) { return !still[n]; });
  };
  std::size_t left_out = 0;
  for (std::size_t c = 0; c < cells(); ++c) {
    if (layout.slot_of_cell[c] >= 0) continue;
    ++left_out;
    EXPECT_FALSE(moves(c)) << c;
  }
  EXPECT_GT(left_out, cells() / 8);
  EXPECT_LT(layout.blocks, whole.blocks);
  // Every block that is there has a cell that moves.
  std::vector<int> of_lane(static_cast<std::size_t>(4 * layout.groups), -1);
  for (std::size_t slot = 0; slot < layout.slots(); ++slot) {
    const std::int32_t cell = layout.cell_of_slot[slot];
    if (cell < 0) continue;
    int& found = of_lane[slot / (4 * kBlockCells) * 4 + slot % 4];
    found = std::max(found, int(moves(cell)));
  }
  EXPECT_EQ(std::ranges::count(of_lane, 0), 0);
  EXPECT_EQ(std::ranges::count(of_lane, 1), layout.blocks);
}

TEST(BlockLayout, AnUncutSlabOfWholeBlocksIsAllColumns) {
  LatticeSettings settings;
  settings.fine_ratio = 2;
  const Lattice lattice = build_lattice(test::box(Vec3::Zero(), Vec3(32, 16, 4)), settings);
  const BlockLayout layout = lay_out_blocks(lattice, 8);
  EXPECT_EQ(layout.groups, 32);
  EXPECT_EQ(layout.nodes.size(), 32U * 9 * 8);
}

TEST(BlockLayout, NeighborsAlongAColumnAreHalfTheLanesApart) {
  LatticeSettings settings;
  settings.fine_ratio = 2;
  const Lattice lattice = build_lattice(test::box(Vec3::Zero(), Vec3(64, 8, 8)), settings);
  for (const int lanes : {1, 2, 4, 8, 16}) {
    const BlockLayout layout = lay_out_blocks(lattice, lanes);
    std::size_t pairs = 0;
    for (std::size_t group = 0; group < static_cast<std::size_t>(layout.groups); ++group)
      for (int a = 0; a < lanes; ++a)
        for (int b = 0; b < lanes; ++b) {
          const auto node = [&](std::size_t n, int lane) { return test::node_of(layout, group, n, lane); };
          if (node(2, a) != node(0, b)) continue;
          ++pairs;
          // the first of a pair where the second is; else the next pair's first is one lane on and half the lanes back
          EXPECT_TRUE(b == a + lanes / 2 || b == a - lanes / 2 + 1) << lanes << " lanes: " << a << " and " << b;
          EXPECT_GE(std::abs(b - a), lanes / 2 - 1);
        }
    EXPECT_EQ(pairs > 0, lanes > 1);
  }
}

INSTANTIATE_TEST_SUITE_P(RandomCuts, CutLattices, ::testing::ValuesIn(test::kCutLattices),
                         [](const auto& info) { return test::name(info.param); });

}  // namespace
}  // namespace lappet
