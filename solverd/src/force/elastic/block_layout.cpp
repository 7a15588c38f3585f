#include "force/elastic/block_layout.h"

#include <algorithm>
#include <array>
#include <limits>
#include <span>

#include "force/kernels/cell_corners.h"
#include "lattice/blocks.h"
#include "lattice/refused.h"
#include "math/features.h"

namespace lappet {

namespace {

// A slab has at least this many groups, so that few lanes stay empty, and there are at most kMaxSlabs.
constexpr std::int64_t kMinGroups = 8;
constexpr std::int64_t kMaxSlabs = 64;

// 0 of no blocks.
int longest_axis(const std::vector<Block>& blocks) {
  if (blocks.empty()) return 0;
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
    if (high[i] - low[i] > high[axis] - low[axis]) axis = int(i);
  return axis;
}

using BlockNodes = std::array<std::int32_t, kBlockNodes>;

// What no cell has is -1.
BlockNodes nodes_of(const Lattice& lattice, const Block& block) {
  BlockNodes nodes;
  nodes.fill(-1);
  for (int place = 0; place < kBlockCells; ++place) {
    const Index cell = block.cells[place];
    if (cell < 0) continue;
    const auto& corners = lattice.cell_nodes[cell];
    for (int c = 0; c < 8; ++c) nodes[block_node(place, c)] = corners[c];
  }
  return nodes;
}

// A missing node would let the kernels touch one of another block, perhaps of another thread.
bool has_columns(const BlockNodes& nodes) {
  for (std::size_t n = 0; n < kBlockNodes; n += 3)
    if (nodes[n] < 0 || nodes[n + 1] != nodes[n] + 1 || nodes[n + 2] != nodes[n] + 2) return false;
  return true;
}

// Which of a group's blocks a lane takes. Blocks that follow one another are neighbors along a column: half the lanes
// lie between them (column_lanes_kernel.h).
std::size_t block_of_lane(std::size_t lane, std::size_t lanes) {
  const std::size_t half = (lanes + 1) / 2;
  return lane % half * 2 + lane / half;
}

// Appends groups of these blocks; the lanes that the last has too many repeat the first block, without cells. Calls
// put(block, place, slot) for every place of every block.
template <class Put>
void append_groups(const Lattice& lattice, std::span<const Block> blocks, bool grid, BlockLayout& layout,
                   const Put& put) {
  const std::size_t lanes = layout.lanes;
  for (std::size_t first = 0; first < blocks.size(); first += lanes, ++layout.groups) {
    const std::size_t group = layout.groups;
    const std::size_t start = layout.node_start.back();
    layout.nodes.resize(start + (grid ? kBlockColumns : kBlockNodes) * lanes);
    layout.node_start.push_back(std::int64_t(layout.nodes.size()));
    layout.cell_of_slot.resize((group + 1) * kBlockCells * lanes, -1);
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      const std::size_t own = first + block_of_lane(lane, lanes);
      const bool spare = own >= blocks.size();
      const Block& block = blocks[spare ? first : own];
      const BlockNodes nodes = nodes_of(lattice, block);
      const Index any = *std::max_element(nodes.begin(), nodes.end());
      if (grid)
        for (std::size_t c = 0; c < kBlockColumns; ++c) layout.nodes[start + c * lanes + lane] = nodes[3 * c];
      else
        for (std::size_t n = 0; n < kBlockNodes; ++n)
          layout.nodes[start + n * lanes + lane] = nodes[n] < 0 ? any : nodes[n];
      for (std::size_t place = 0; !spare && place < kBlockCells; ++place)
        put(own, place, (group * kBlockCells + place) * lanes + lane);
    }
  }
}

void append_cells(const Lattice& lattice, std::span<const Block> blocks, bool grid, BlockLayout& layout) {
  append_groups(lattice, blocks, grid, layout, [&](std::size_t block, std::size_t place, std::size_t slot) {
    const Index cell = blocks[block].cells[place];
    if (cell < 0) return;
    layout.cell_of_slot[slot] = cell;
    layout.slot_of_cell[cell] = to_index(slot);
  });
}

// The further parts of the cells of these blocks: the n-th parts in blocks of their own.
void append_parts(const Lattice& lattice, std::span<const Block> blocks, bool grid, std::span<const Index> parts,
                  BlockLayout& layout) {
  std::vector<Block> hosts;
  std::vector<std::array<Index, kBlockCells>> members;
  for (const Block& block : blocks)
    for (Index nth = 0;; ++nth) {
      std::array<Index, kBlockCells> own;
      for (std::size_t place = 0; place < kBlockCells; ++place) {
        const auto found = std::ranges::equal_range(parts, block.cells[place]);
        own[place] = nth < std::ssize(found) ? to_index(found.begin() - parts.begin()) + nth : -1;
      }
      if (std::ranges::all_of(own, [](Index part) { return part < 0; })) break;
      hosts.push_back(block);
      members.push_back(own);
    }
  append_groups(lattice, hosts, grid, layout, [&](std::size_t block, std::size_t place, std::size_t slot) {
    if (members[block][place] >= 0) layout.slot_of_part[members[block][place]] = to_index(slot);
  });
}

}  // namespace

BlockLayout lay_out_blocks(const Lattice& lattice, int lanes, std::span<const std::uint8_t> still,
                           std::span<const Index> parts, const Interrupt& interrupt) {
  auto blocks = build_blocks(lattice);
  interrupt.check();
  const auto moves = [&](const Block& block) {
    return std::ranges::any_of(nodes_of(lattice, block), [&](Index n) { return n >= 0 && !still[n]; });
  };
  // Where no node moves the energy of all blocks is computed all the same.
  if (!still.empty() && std::ranges::any_of(blocks, moves))
    std::erase_if(blocks, [&](const Block& block) { return !moves(block); });
  const std::size_t axis = longest_axis(blocks);
  std::stable_sort(blocks.begin(), blocks.end(),
                   [&](const Block& a, const Block& b) { return a.position[axis] < b.position[axis]; });
  const std::int64_t count = blocks.size();
  const std::int64_t min_blocks = std::max(kMinGroups * lanes, (count + kMaxSlabs - 1) / kMaxSlabs);

  BlockLayout layout;
  layout.lanes = lanes;
  layout.blocks = count;
  layout.slab_start = {0};
  layout.node_start = {0};
  layout.slot_of_cell.assign(lattice.cell_nodes.size(), -1);
  layout.slot_of_part.assign(parts.size(), -1);
  std::int64_t begin = 0;
  while (begin < count) {
    interrupt.check();
    // whole planes of blocks, until there are enough; what is too little for a slab joins the last
    std::int64_t end = std::min(begin + min_blocks, count);
    const auto plane = [&](std::int64_t b) { return blocks[b].position[axis]; };
    while (end < count && plane(end) == plane(end - 1)) ++end;
    if (count - end < min_blocks) end = count;
    const auto from = blocks.begin() + begin, to = blocks.begin() + end;
    const auto mesh =
        std::stable_partition(from, to, [&](const Block& b) { return has_columns(nodes_of(lattice, b)); });
    if constexpr (!kHasMeshCells)
      if (mesh != to)
        throw RefusedError(ErrorCode::kInvalidInput,
                           "this daemon was built without mesh cells, and the tissue is no box of whole blocks");
    append_cells(lattice, {from, mesh}, true, layout);
    append_cells(lattice, {mesh, to}, false, layout);
    if (!parts.empty()) {
      append_parts(lattice, {from, mesh}, true, parts, layout);
      append_parts(lattice, {mesh, to}, false, parts, layout);
    }
    layout.slab_start.push_back(layout.groups);
    begin = end;
  }
  return layout;
}

}  // namespace lappet
