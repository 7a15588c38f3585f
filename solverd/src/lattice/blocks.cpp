#include "lattice/blocks.h"

#include <tbb/parallel_sort.h>

#include <algorithm>

#include "math/parallel.h"

namespace lappet {

namespace {

constexpr int kFaceNodes = 4;

std::int32_t half(std::int32_t a) { return a >= 0 ? a / 2 : -((1 - a) / 2); }

// The nodes of a block by place, 9 x + 3 y + z; -1 where no cell has one.
std::array<Index, 27> nodes_of(const Lattice& lattice, const Block& block) {
  std::array<Index, 27> nodes;
  nodes.fill(-1);
  for (std::size_t i = 0; i < 8; ++i) {
    if (block.cells[i] < 0) continue;
    const auto& corners = lattice.cell_nodes[block.cells[i]];
    for (std::size_t c = 0; c < 8; ++c)
      nodes[9 * ((i >> 2) + (c >> 2)) + 3 * ((i >> 1 & 1) + (c >> 1 & 1)) + (i & 1) + (c & 1)] = corners[c];
  }
  return nodes;
}

// How many nodes two blocks share; -1 where they have different cells or nodes at one place.
int shared_nodes(const Lattice& lattice, const Block& a, const Block& b) {
  for (std::size_t i = 0; i < 8; ++i)
    if (a.cells[i] >= 0 && b.cells[i] >= 0) return -1;
  const auto na = nodes_of(lattice, a), nb = nodes_of(lattice, b);
  int shared = 0;
  for (std::size_t n = 0; n < na.size(); ++n) {
    if (na[n] < 0 || nb[n] < 0) continue;
    if (na[n] != nb[n]) return -1;
    ++shared;
  }
  return shared;
}

// Merges the pair that shares most nodes until none is left that fits and shares a face.
void collapse(const Lattice& lattice, std::vector<Block>& blocks) {
  while (true) {
    std::size_t best_a = 0, best_b = 0;
    int max_shared = kFaceNodes - 1;
    for (std::size_t a = 0; a < blocks.size(); ++a)
      for (std::size_t b = a + 1; b < blocks.size(); ++b) {
        const int shared = shared_nodes(lattice, blocks[a], blocks[b]);
        if (shared <= max_shared) continue;
        max_shared = shared;
        best_a = a;
        best_b = b;
      }
    if (max_shared < kFaceNodes) return;
    for (std::size_t i = 0; i < 8; ++i)
      if (blocks[best_b].cells[i] >= 0) blocks[best_a].cells[i] = blocks[best_b].cells[i];
    blocks.erase(blocks.begin() + best_b);
  }
}

// Cells at eight places, with one node at each: whatever the order they collapse to one block, as any two parts of the
// eight have a face between them. Returns whether that was so.
bool join_at_once(const Lattice& lattice, std::vector<Block>& blocks) {
  if (blocks.size() != 8) return false;
  Block all = blocks[0];
  for (const Block& block : blocks)
    for (std::size_t i = 0; i < 8; ++i)
      if (block.cells[i] >= 0) all.cells[i] = block.cells[i];
  std::array<Index, 27> nodes;
  nodes.fill(-1);
  for (std::size_t i = 0; i < 8; ++i) {
    if (all.cells[i] < 0) return false;
    const auto& corners = lattice.cell_nodes[all.cells[i]];
    for (std::size_t c = 0; c < 8; ++c) {
      Index& node = nodes[9 * ((i >> 2) + (c >> 2)) + 3 * ((i >> 1 & 1) + (c >> 1 & 1)) + (i & 1) + (c & 1)];
      if (node >= 0 && node != corners[c]) return false;
      node = corners[c];
    }
  }
  blocks.assign(1, all);
  return true;
}

}  // namespace

std::vector<Block> build_blocks(const Lattice& lattice) {
  const std::size_t count = lattice.cell_nodes.size();
  const auto region_of = [&](Index cell) {
    const auto& p = lattice.cell_position(cell);
    return std::array<std::int32_t, 3>{half(p[0]), half(p[1]), half(p[2])};
  };
  std::vector<std::pair<std::array<std::int32_t, 3>, Index>> cells(count);
  for_each_index(count, [&](std::size_t c) {
    const Index cell = to_index(c);
    cells[c] = {region_of(cell), cell};
  });
  tbb::parallel_sort(cells.begin(), cells.end());
  // A chunk takes the regions that begin in it.
  std::vector<std::vector<Block>> chunks((count + kChunk - 1) / kChunk);
  for_each_chunk(count, [&](std::size_t chunk, std::size_t begin, std::size_t chunk_end) {
    while (begin > 0 && begin < chunk_end && cells[begin].first == cells[begin - 1].first) ++begin;
    std::vector<Block> blocks;
    while (begin < chunk_end) {
      const auto region = cells[begin].first;
      blocks.clear();
      for (; begin < count && cells[begin].first == region; ++begin) {
        const Index cell = cells[begin].second;
        const auto& p = lattice.cell_position(cell);
        Block block{region, {-1, -1, -1, -1, -1, -1, -1, -1}};
        const int place = (p[0] - 2 * region[0]) << 2 | (p[1] - 2 * region[1]) << 1 | (p[2] - 2 * region[2]);
        block.cells[place] = cell;
        blocks.push_back(block);
      }
      if (!join_at_once(lattice, blocks)) collapse(lattice, blocks);
      chunks[chunk].insert(chunks[chunk].end(), blocks.begin(), blocks.end());
    }
  });
  cells = {};
  std::size_t total = 0;
  for (const auto& chunk : chunks) total += chunk.size();
  std::vector<Block> result;
  result.reserve(total);
  for (auto& chunk : chunks) {
    result.insert(result.end(), chunk.begin(), chunk.end());
    chunk = {};
  }
  return result;
}

}  // namespace lappet
