#include "force/block_layout.h"

#include <algorithm>
#include <array>
#include <limits>

#include "force/cell_corners.h"
#include "lattice/blocks.h"

namespace lappet {

namespace {

// A slab has at least this many groups, so that few lanes stay empty, and there are at most kMostSlabs.
constexpr std::int64_t kLeastGroups = 8;
constexpr std::int64_t kMostSlabs = 64;

int longest_axis(const std::vector<Block>& blocks) {
  std::array<std::int32_t, 3> low{}, high{};
  low.fill(std::numeric_limits<std::int32_t>::max());
  high.fill(std::numeric_limits<std::int32_t>::min());
  for (const auto& block : blocks)
    for (std::size_t i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], block.position[i]);
      high[i] = std::max(high[i], block.position[i]);
    }
  int axis = 0;
  for (std::size_t i = 1; i < 3; ++i)
    if (high[i] - low[i] > high[static_cast<std::size_t>(axis)] - low[static_cast<std::size_t>(axis)])
      axis = static_cast<int>(i);
  return axis;
}

}  // namespace

BlockLayout lay_out_blocks(const Lattice& lattice, int lanes) {
  auto blocks = build_blocks(lattice);
  const auto axis = static_cast<std::size_t>(longest_axis(blocks));
  std::stable_sort(blocks.begin(), blocks.end(),
                   [&](const Block& a, const Block& b) { return a.position[axis] < b.position[axis]; });
  const auto count = static_cast<std::int64_t>(blocks.size());
  const std::int64_t least = std::max(kLeastGroups * lanes, (count + kMostSlabs - 1) / kMostSlabs);

  BlockLayout layout;
  layout.lanes = lanes;
  layout.slab_start = {0};
  layout.slot_of_cell.assign(lattice.cell_nodes.size(), -1);
  std::int64_t begin = 0;
  while (begin < count) {
    // whole planes of blocks, until there are enough; what is too little for a slab joins the last
    std::int64_t end = std::min(begin + least, count);
    const auto plane = [&](std::int64_t b) { return blocks[static_cast<std::size_t>(b)].position[axis]; };
    while (end < count && plane(end) == plane(end - 1)) ++end;
    if (count - end < least) end = count;
    const std::int64_t groups = (end - begin + lanes - 1) / lanes;
    const std::int64_t first = layout.groups;
    layout.groups += groups;
    layout.slab_start.push_back(layout.groups);
    layout.nodes.resize(static_cast<std::size_t>(layout.groups * kBlockNodes * lanes));
    layout.cell_of_slot.resize(static_cast<std::size_t>(layout.groups * kBlockCells * lanes), -1);
    for (std::int64_t b = begin; b < begin + groups * lanes; ++b) {
      const std::int64_t group = first + (b - begin) / lanes, lane = (b - begin) % lanes;
      const bool spare = b >= end;
      const Block& block = blocks[static_cast<std::size_t>(spare ? begin : b)];
      std::array<std::int32_t, kBlockNodes> nodes;
      nodes.fill(-1);
      std::int32_t any = -1;
      for (int place = 0; place < kBlockCells; ++place) {
        const std::int32_t cell = block.cells[static_cast<std::size_t>(place)];
        if (cell < 0) continue;
        const auto& corners = lattice.cell_nodes[static_cast<std::size_t>(cell)];
        for (int c = 0; c < 8; ++c)
          any = nodes[static_cast<std::size_t>(block_node(place, c))] = corners[static_cast<std::size_t>(c)];
        if (spare) continue;
        const std::int64_t slot = (group * kBlockCells + place) * lanes + lane;
        layout.cell_of_slot[static_cast<std::size_t>(slot)] = cell;
        layout.slot_of_cell[static_cast<std::size_t>(cell)] = static_cast<std::int32_t>(slot);
      }
      for (int n = 0; n < kBlockNodes; ++n) {
        const std::int32_t node = nodes[static_cast<std::size_t>(n)];
        layout.nodes[static_cast<std::size_t>((group * kBlockNodes + n) * lanes + lane)] = node < 0 ? any : node;
      }
    }
    begin = end;
  }
  return layout;
}

}  // namespace lappet
