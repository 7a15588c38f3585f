#include "solve/multigrid/coarse_lattice.h"

#include <algorithm>

#include "math/disjoint_sets.h"

namespace lappet {

namespace {

// Pairs of cells that share the four nodes of a face, found by the lowest node of the upper cell.
class FacePairs {
 public:
  FacePairs(std::span<const CellNodes> cells, std::size_t nodes) : cells_(cells) {
    std::vector<Index> lowest(cells.size());
    for (std::size_t c = 0; c < cells.size(); ++c) lowest[c] = cells[c][0];
    by_lowest_ = group_by(lowest, nodes);
  }
  // body(a, b, bit): b one step further along the axis of the corner bit.
  template <class Body>
  void for_each(const Body& body) const {
    for (std::size_t a = 0; a < cells_.size(); ++a)
      for (int bit = 1; bit < 8; bit <<= 1)
        for (const Index b : by_lowest_[cells_[a][bit]]) {
          const auto& upper = cells_[b];
          bool joined = true;
          for (int c = 0; c < 8; ++c) joined = joined && ((c & bit) != 0 || upper[c] == cells_[a][c | bit]);
          if (joined) body(to_index(a), b, bit);
        }
  }

 private:
  std::span<const CellNodes> cells_;
  Groups by_lowest_;
};

int floor_div(int a, int b) { return a >= 0 ? a / b : -((-a + b - 1) / b); }

}  // namespace

std::vector<std::array<double, 8>> CoarseLattice::weights() const {
  std::vector<std::array<double, 8>> table;
  for (int x = 0; x <= ratio; ++x)
    for (int y = 0; y <= ratio; ++y)
      for (int z = 0; z <= ratio; ++z) {
        const double local[3] = {double(x) / ratio, double(y) / ratio, double(z) / ratio};
        auto& entry = table.emplace_back();
        for (int k = 0; k < 8; ++k) {
          double weight = 1.0;
          for (int axis = 0; axis < 3; ++axis) weight *= (k >> (2 - axis) & 1) ? local[axis] : 1.0 - local[axis];
          entry[k] = weight;
        }
      }
  return table;
}

std::array<std::uint8_t, 3> CoarseLattice::corner_place(const CellPosition& cell, std::size_t coarse,
                                                        int corner) const {
  std::array<std::uint8_t, 3> place{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    place[axis] = std::uint8_t(cell[axis] + (corner >> (2 - axis) & 1) - ratio * cell_position[coarse][axis]);
  return place;
}

Index CoarseLattice::owner(Index slot) const {
  return to_index(std::upper_bound(slots.start.begin(), slots.start.end(), slot) - slots.start.begin()) - 1;
}

std::size_t CoarseLattice::bytes() const {
  return cell_nodes.size() * sizeof(CellNodes) + cell_position.size() * sizeof(CellPosition) + 3 * local.size() +
         sizeof(Index) * slot_of.size() + cells.bytes() + slots.bytes() + corners.bytes();
}

namespace {

// Makes the coarse cells: the components, by whole faces, of the cells in each box. Returns each cell's coarse cell.
std::vector<Index> merge_cells(const FacePairs& faces, std::span<const CellPosition> cell_position,
                               CoarseLattice& result) {
  const auto box = [&](std::size_t cell) {
    const auto& p = cell_position[cell];
    return CellPosition{floor_div(p[0], result.ratio), floor_div(p[1], result.ratio), floor_div(p[2], result.ratio)};
  };
  DisjointSets components(cell_position.size());
  faces.for_each([&](Index a, Index b, int) {
    if (box(a) == box(b)) components.unite(a, b);
  });
  std::vector<Index> coarse_of(cell_position.size(), -1);
  for (std::size_t c = 0; c < coarse_of.size(); ++c) {
    const Index root = components.find(to_index(c));
    if (coarse_of[root] < 0) {
      coarse_of[root] = to_index(result.cell_position.size());
      result.cell_position.push_back(box(c));
    }
    coarse_of[c] = coarse_of[root];
  }
  result.cells = group_by(coarse_of, result.cell_position.size());
  return coarse_of;
}

// Makes the coarse nodes: corners of coarse cells are one node where cells below share a face across.
void merge_corners(const FacePairs& faces, std::span<const Index> coarse_of, CoarseLattice& result) {
  const std::size_t coarse_cells = result.cell_position.size();
  DisjointSets merged(8 * coarse_cells);
  faces.for_each([&](Index a, Index b, int bit) {
    const Index ca = coarse_of[a], cb = coarse_of[b];
    if (ca == cb) return;
    for (int c = 0; c < 8; ++c)
      if (c & bit) merged.unite(8 * ca + c, 8 * cb + (c & ~bit));
  });
  std::vector<Index> number(8 * coarse_cells, -1), node_of_corner(8 * coarse_cells);
  result.cell_nodes.resize(coarse_cells);
  for (std::size_t c = 0; c < coarse_cells; ++c)
    for (std::size_t k = 0; k < 8; ++k) {
      Index& id = number[merged.find(to_index(8 * c + k))];
      if (id < 0) id = to_index(result.nodes++);
      result.cell_nodes[c][k] = node_of_corner[8 * c + k] = id;
    }
  result.corners = group_by(node_of_corner, result.nodes);
}

// Gives every node below its slot: the first coarse cell that touches it, and its place there.
void place_nodes(std::span<const CellNodes> cell_nodes, std::span<const CellPosition> cell_position,
                 std::span<const Index> coarse_of, std::size_t nodes, CoarseLattice& result) {
  std::vector<Index> owner(nodes, -1);
  std::vector<std::array<std::uint8_t, 3>> place(nodes);
  for (std::size_t c = 0; c < cell_nodes.size(); ++c)
    for (int corner = 0; corner < 8; ++corner) {
      const Index n = cell_nodes[c][corner];
      if (owner[n] >= 0) continue;
      owner[n] = coarse_of[c];
      place[n] = result.corner_place(cell_position[c], coarse_of[c], corner);
    }
  result.slots = group_by(owner, result.cell_position.size());
  result.slot_of.resize(nodes);
  result.local.resize(nodes);
  for (std::size_t slot = 0; slot < nodes; ++slot) {
    result.slot_of[result.node_of(slot)] = to_index(slot);
    result.local[slot] = place[result.node_of(slot)];
  }
}

}  // namespace

CoarseLattice coarsen(std::span<const CellNodes> cell_nodes, std::span<const CellPosition> cell_position,
                      std::size_t nodes, int ratio) {
  CoarseLattice result;
  result.ratio = ratio;
  const FacePairs faces(cell_nodes, nodes);
  const std::vector<Index> coarse_of = merge_cells(faces, cell_position, result);
  merge_corners(faces, coarse_of, result);
  place_nodes(cell_nodes, cell_position, coarse_of, nodes, result);
  return result;
}

}  // namespace lappet
