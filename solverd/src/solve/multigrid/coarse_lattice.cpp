#include "solve/multigrid/coarse_lattice.h"

#include <algorithm>
#include <numeric>

namespace lappet {

namespace {

class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }
  std::int32_t find(std::int32_t a) {
    while (parent_[static_cast<std::size_t>(a)] != a)
      a = parent_[static_cast<std::size_t>(a)] =
          parent_[static_cast<std::size_t>(parent_[static_cast<std::size_t>(a)])];
    return a;
  }
  void unite(std::int32_t a, std::int32_t b) {
    a = find(a);
    b = find(b);
    if (a != b) parent_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
  }

 private:
  std::vector<std::int32_t> parent_;
};

// start, list: indices 0..keys.size()-1 grouped by key, ascending in each group.
void group(std::span<const std::int32_t> keys, std::size_t groups, std::vector<std::int32_t>& start,
           std::vector<std::int32_t>& list) {
  start.assign(groups + 1, 0);
  for (const std::int32_t key : keys) ++start[static_cast<std::size_t>(key) + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  list.resize(keys.size());
  std::vector<std::int32_t> next(start.begin(), start.end() - 1);
  for (std::size_t i = 0; i < keys.size(); ++i)
    list[static_cast<std::size_t>(next[static_cast<std::size_t>(keys[i])]++)] = static_cast<std::int32_t>(i);
}

// Pairs of cells that share the four nodes of a face, found by the lowest node of the upper cell.
class FacePairs {
 public:
  FacePairs(std::span<const CellNodes> cells, std::size_t nodes) : cells_(cells) {
    std::vector<std::int32_t> lowest(cells.size());
    for (std::size_t c = 0; c < cells.size(); ++c) lowest[c] = cells[c][0];
    group(lowest, nodes, start_, by_lowest_);
  }
  // body(a, b, bit): b one step further along the axis of the corner bit.
  template <class Body>
  void for_each(const Body& body) const {
    for (std::size_t a = 0; a < cells_.size(); ++a)
      for (std::size_t bit = 1; bit < 8; bit <<= 1) {
        const auto node = static_cast<std::size_t>(cells_[a][bit]);
        for (auto i = start_[node]; i < start_[node + 1]; ++i) {
          const std::int32_t b = by_lowest_[static_cast<std::size_t>(i)];
          const auto& upper = cells_[static_cast<std::size_t>(b)];
          bool joined = true;
          for (std::size_t c = 0; c < 8; ++c) joined = joined && ((c & bit) != 0 || upper[c] == cells_[a][c | bit]);
          if (joined) body(static_cast<std::int32_t>(a), b, static_cast<int>(bit));
        }
      }
  }

 private:
  std::span<const CellNodes> cells_;
  std::vector<std::int32_t> start_, by_lowest_;
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
          entry[static_cast<std::size_t>(k)] = weight;
        }
      }
  return table;
}

std::array<std::uint8_t, 3> CoarseLattice::corner_place(const CellPosition& cell, std::size_t coarse,
                                                        int corner) const {
  std::array<std::uint8_t, 3> place{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    place[axis] = static_cast<std::uint8_t>(cell[axis] + (corner >> (2 - static_cast<int>(axis)) & 1) -
                                            ratio * cell_position[coarse][axis]);
  return place;
}

std::int32_t CoarseLattice::owner(std::int32_t slot) const {
  return static_cast<std::int32_t>(std::upper_bound(slot_start.begin(), slot_start.end(), slot) - slot_start.begin()) -
         1;
}

std::size_t CoarseLattice::bytes() const {
  return cell_nodes.size() * sizeof(CellNodes) + cell_position.size() * sizeof(CellPosition) + 3 * local.size() +
         4 * (cell_start.size() + cells.size() + slot_start.size() + slot_node.size() + slot_of.size() +
              corner_start.size() + corners.size());
}

namespace {

// Cells of one box that hang together are a coarse cell; returns that of each cell.
std::vector<std::int32_t> merge_cells(const FacePairs& faces, std::span<const CellPosition> cell_position,
                                      CoarseLattice& result) {
  const std::size_t cells = cell_position.size();
  const auto box = [&, ratio = result.ratio](std::int32_t cell) {
    const auto& p = cell_position[static_cast<std::size_t>(cell)];
    return CellPosition{floor_div(p[0], ratio), floor_div(p[1], ratio), floor_div(p[2], ratio)};
  };
  DisjointSets components(cells);
  faces.for_each([&](std::int32_t a, std::int32_t b, int) {
    if (box(a) == box(b)) components.unite(a, b);
  });
  std::vector<std::int32_t> coarse_of(cells, -1);
  for (std::size_t c = 0; c < cells; ++c) {
    const auto root = static_cast<std::size_t>(components.find(static_cast<std::int32_t>(c)));
    if (coarse_of[root] < 0) {
      coarse_of[root] = static_cast<std::int32_t>(result.cell_position.size());
      result.cell_position.push_back(box(static_cast<std::int32_t>(c)));
    }
    coarse_of[c] = coarse_of[root];
  }
  return coarse_of;
}

// Corners of coarse cells are one node where fine cells on either side share a face.
void merge_corners(const FacePairs& faces, std::span<const std::int32_t> coarse_of, CoarseLattice& result) {
  const std::size_t coarse_cells = result.cell_position.size();
  DisjointSets merged(8 * coarse_cells);
  faces.for_each([&](std::int32_t a, std::int32_t b, int bit) {
    const std::int32_t ca = coarse_of[static_cast<std::size_t>(a)], cb = coarse_of[static_cast<std::size_t>(b)];
    if (ca == cb) return;
    for (int c = 0; c < 8; ++c)
      if (c & bit) merged.unite(8 * ca + c, 8 * cb + (c & ~bit));
  });
  std::vector<std::int32_t> number(8 * coarse_cells, -1), node_of_corner(8 * coarse_cells);
  result.cell_nodes.resize(coarse_cells);
  for (std::size_t c = 0; c < coarse_cells; ++c)
    for (std::size_t k = 0; k < 8; ++k) {
      auto& id = number[static_cast<std::size_t>(merged.find(static_cast<std::int32_t>(8 * c + k)))];
      if (id < 0) id = static_cast<std::int32_t>(result.nodes++);
      result.cell_nodes[c][k] = node_of_corner[8 * c + k] = id;
    }
  group(node_of_corner, result.nodes, result.corner_start, result.corners);
}

}  // namespace

CoarseLattice coarsen(std::span<const CellNodes> cell_nodes, std::span<const CellPosition> cell_position,
                      std::size_t nodes, int ratio) {
  CoarseLattice result;
  result.ratio = ratio;
  const std::size_t cells = cell_nodes.size();
  const FacePairs faces(cell_nodes, nodes);
  const auto coarse_of = merge_cells(faces, cell_position, result);
  const std::size_t coarse_cells = result.cell_position.size();
  group(coarse_of, coarse_cells, result.cell_start, result.cells);
  merge_corners(faces, coarse_of, result);

  std::vector<std::int32_t> owner(nodes, -1);
  std::vector<std::array<std::uint8_t, 3>> place(nodes);
  for (std::size_t c = 0; c < cells; ++c)
    for (int corner = 0; corner < 8; ++corner) {
      const auto n = static_cast<std::size_t>(cell_nodes[c][static_cast<std::size_t>(corner)]);
      if (owner[n] >= 0) continue;
      owner[n] = coarse_of[c];
      place[n] = result.corner_place(cell_position[c], static_cast<std::size_t>(coarse_of[c]), corner);
    }
  group(owner, coarse_cells, result.slot_start, result.slot_node);
  result.slot_of.resize(nodes);
  result.local.resize(nodes);
  for (std::size_t slot = 0; slot < nodes; ++slot) {
    const auto n = static_cast<std::size_t>(result.slot_node[slot]);
    result.slot_of[n] = static_cast<std::int32_t>(slot);
    result.local[slot] = place[n];
  }
  return result;
}

}  // namespace lappet
