// The non-manifold lattice coarsened by a whole number: a coarse cell is a connected component of the cells in a box,
// so a cut stays a cut. Works on lattices of any level.
//
// Every node belongs to one coarse cell (the first that touches it) and lies there at local / ratio in [0, 1]^3; the
// corners with weight there are the same in all coarse cells that share the node.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "math/groups.h"

namespace lappet {

using CellNodes = std::array<Index, 8>;
using CellPosition = std::array<std::int32_t, 3>;

struct CoarseLattice {
  int ratio = 0;
  std::vector<CellNodes> cell_nodes;
  std::vector<CellPosition> cell_position;
  std::size_t nodes = 0;

  Groups cells;    // coarse cell -> cells below
  Groups slots;    // coarse cell -> its nodes of the level below; a slot is a place in this list
  Groups corners;  // coarse node -> 8 * coarse cell + corner
  std::vector<std::array<std::uint8_t, 3>> local;  // per slot, 0..ratio
  std::vector<Index> slot_of;                      // node below -> slot

  // Trilinear weights of the eight corners, by (local[0] (ratio + 1) + local[1]) (ratio + 1) + local[2].
  std::vector<std::array<double, 8>> weights() const;
  int weight_index(const std::array<std::uint8_t, 3>& place) const {
    return (place[0] * (ratio + 1) + place[1]) * (ratio + 1) + place[2];
  }
  int weight_index(std::size_t slot) const { return weight_index(local[slot]); }
  // The local position of a corner of a cell below inside its coarse cell.
  std::array<std::uint8_t, 3> corner_place(const CellPosition& cell, std::size_t coarse, int corner) const;
  Index node_of(std::size_t slot) const { return slots.items[slot]; }
  // The coarse cell of a slot.
  Index owner(Index slot) const;
  std::size_t bytes() const;
};

CoarseLattice coarsen(std::span<const CellNodes> cell_nodes, std::span<const CellPosition> cell_position,
                      std::size_t nodes, int ratio);

}  // namespace lappet
