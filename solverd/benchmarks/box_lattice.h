// The lattice of a box of x by y by z cells, all of them full: what build_lattice makes of one, without its voxels.
#pragma once
#include "lattice/lattice.h"

namespace lappet {

inline Lattice box_lattice(std::int32_t x, std::int32_t y, std::int32_t z) {
  Lattice lattice;
  const auto node = [&](std::int32_t i, std::int32_t j, std::int32_t k) { return (i * (y + 1) + j) * (z + 1) + k; };
  for (std::int32_t i = 0; i <= x; ++i)
    for (std::int32_t j = 0; j <= y; ++j)
      for (std::int32_t k = 0; k <= z; ++k) lattice.node_rest.push_back({i, j, k});
  for (std::int32_t i = 0; i < x; ++i)
    for (std::int32_t j = 0; j < y; ++j)
      for (std::int32_t k = 0; k < z; ++k) {
        std::array<std::int32_t, 8> nodes{};
        for (std::int32_t c = 0; c < 8; ++c) nodes[c] = node(i + (c >> 2), j + (c >> 1 & 1), k + (c & 1));
        lattice.cell_nodes.push_back(nodes);
      }
  lattice.cell_fill.assign(lattice.cell_nodes.size(), 1.0f);
  lattice.grid_cells = to_index(lattice.cell_nodes.size());
  return lattice;
}

}  // namespace lappet
