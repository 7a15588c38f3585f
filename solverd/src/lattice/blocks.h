// Manifold blocks of 2x2x2 cells (GRIDiron Algorithm 3): every cell is in one block, a block never holds two cells or
// two nodes at one place, and where incisions put several cells at a position the cells are gathered greedily along
// what connects them.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "lattice/lattice.h"

namespace lappet {

struct Block {
  std::array<std::int32_t, 3> position;  // of its corner, in blocks
  std::array<Index, 8> cells;            // by place in the block (x<<2 | y<<1 | z), -1 where missing
};

// Ordered by position; deterministic.
std::vector<Block> build_blocks(const Lattice& lattice);

}  // namespace lappet
