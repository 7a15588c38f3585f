// Where the cells of a lattice lie for the kernels: blocks of 2x2x2 cells (lattice/blocks.h), `lanes` of them in
// lockstep as a group, groups in slabs across the longest side of the tissue.
//
// Hybrid (GRIDiron 5.4): within a slab come first the blocks of the regular grid, whose nodes are nine columns of three
// consecutive numbers, in groups of their own that store only where each column begins; then all others.
//
// Where a cell is of several materials, its second, third … part lie in further blocks over the same nodes, at the end
// of their slab.
//
// Only neighboring slabs share nodes: the even ones may scatter at the same time, then the odd ones. What a slab holds
// does not depend on the number of threads, so neither does any sum.
#pragma once
#include <tbb/parallel_for.h>

#include <cstdint>
#include <span>
#include <vector>

#include "lattice/lattice.h"

namespace lappet {

struct BlockLayout {
  int lanes = 1;
  std::int64_t blocks = 0, groups = 0;
  std::vector<Index> nodes;              // per group [27][lane], or of a grid group [9][lane]
  std::vector<std::int64_t> node_start;  // where the nodes of each group begin, and the end
  std::vector<Index> cell_of_slot;       // [group][place][lane]; -1 where missing
  std::vector<Index> slot_of_cell;       // index into cell_of_slot; -1 for a cell of a block that is left out
  std::vector<Index> slot_of_part;       // likewise for each further part; cell_of_slot is -1 there
  std::vector<std::int64_t> slab_start;  // first group of each slab, and the end

  std::size_t slots() const { return cell_of_slot.size(); }
  std::size_t slabs() const { return slab_start.size() - 1; }

  // Calls body(slab, first group, end) for every slab, those that share nodes one after the other.
  template <class Body>
  void for_each_slab(const Body& body) const {
    for (std::size_t color = 0; color < 2; ++color)
      tbb::parallel_for(std::size_t{0}, (slabs() + 1 - color) / 2, [&](std::size_t i) {
        const std::size_t slab = 2 * i + color;
        body(slab, slab_start[slab], slab_start[slab + 1]);
      });
  }
};

// still: per node, 1 where it never moves; empty: all may. Blocks that no node of theirs moves are left out. parts: the
// cell of each further part of a cell, ascending.
BlockLayout lay_out_blocks(const Lattice& lattice, int lanes, std::span<const std::uint8_t> still = {},
                           std::span<const Index> parts = {}, const Interrupt& interrupt = {});

}  // namespace lappet
