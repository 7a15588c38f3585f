#include "lattice/blocks.h"

#include <algorithm>
#include <map>

namespace lappet {

namespace {

std::int32_t half(std::int32_t a) { return a >= 0 ? a / 2 : -((1 - a) / 2); }

// How two blocks fit: the faces on which their cells are joined, and those on which cells meet without being joined.
struct Fit {
  bool overlaps = false;
  int joined = 0, mismatched = 0;
};

bool share_face(const Lattice& lattice, std::int32_t a, std::int32_t b, int bit) {
  const auto& na = lattice.cell_nodes[static_cast<std::size_t>(a)];
  const auto& nb = lattice.cell_nodes[static_cast<std::size_t>(b)];
  for (std::size_t c = 0; c < 8; ++c)
    if ((c & static_cast<std::size_t>(bit)) != 0 && na[c] != nb[c & ~static_cast<std::size_t>(bit)]) return false;
  return true;
}

Fit fit(const Lattice& lattice, const Block& a, const Block& b) {
  Fit result;
  for (std::size_t i = 0; i < 8; ++i) {
    if (a.cells[i] < 0) continue;
    result.overlaps = result.overlaps || b.cells[i] >= 0;
    for (int bit = 1; bit < 8; bit <<= 1) {
      const std::size_t j = i ^ static_cast<std::size_t>(bit);
      if (b.cells[j] < 0) continue;
      const bool upper = (i & static_cast<std::size_t>(bit)) != 0;
      const bool joined =
          upper ? share_face(lattice, b.cells[j], a.cells[i], bit) : share_face(lattice, a.cells[i], b.cells[j], bit);
      ++(joined ? result.joined : result.mismatched);
    }
  }
  return result;
}

void collapse(const Lattice& lattice, std::vector<Block>& blocks) {
  while (true) {
    std::size_t best_a = 0, best_b = 0;
    int fewest = -1;
    for (std::size_t a = 0; a < blocks.size(); ++a)
      for (std::size_t b = a + 1; b < blocks.size(); ++b) {
        const Fit f = fit(lattice, blocks[a], blocks[b]);
        if (f.overlaps || f.joined == 0) continue;
        if (fewest < 0 || f.mismatched < fewest) {
          fewest = f.mismatched;
          best_a = a;
          best_b = b;
        }
      }
    if (fewest < 0) return;
    for (std::size_t i = 0; i < 8; ++i)
      if (blocks[best_b].cells[i] >= 0) blocks[best_a].cells[i] = blocks[best_b].cells[i];
    blocks.erase(blocks.begin() + static_cast<std::ptrdiff_t>(best_b));
  }
}

}  // namespace

std::vector<Block> build_blocks(const Lattice& lattice) {
  std::map<std::array<std::int32_t, 3>, std::vector<std::int32_t>> regions;
  for (std::size_t c = 0; c < lattice.cell_position.size(); ++c) {
    const auto& p = lattice.cell_position[c];
    regions[{half(p[0]), half(p[1]), half(p[2])}].push_back(static_cast<std::int32_t>(c));
  }
  std::vector<Block> result;
  for (const auto& [region, cells] : regions) {
    std::vector<Block> blocks;
    for (const std::int32_t c : cells) {
      const auto& p = lattice.cell_position[static_cast<std::size_t>(c)];
      Block block{region, {-1, -1, -1, -1, -1, -1, -1, -1}};
      const int place = (p[0] - 2 * region[0]) << 2 | (p[1] - 2 * region[1]) << 1 | (p[2] - 2 * region[2]);
      block.cells[static_cast<std::size_t>(place)] = c;
      blocks.push_back(block);
    }
    collapse(lattice, blocks);
    result.insert(result.end(), blocks.begin(), blocks.end());
  }
  return result;
}

}  // namespace lappet
