#include "lattice/nonmanifold.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <utility>

#include "math/disjoint_sets.h"

namespace lappet {
namespace {

std::int32_t corner_bit(int axis) { return 4 >> axis; }  // corner number: x 4, y 2, z 1

// Does a fragment hold a block of 2 x 2 x 2 voxels?
bool is_two_voxels_thick(const FineVoxels& fine, const Fragments& fragments, std::span<const Index> cells,
                         Index fragment) {
  const std::int32_t r = fine.box().ratio;
  const auto belongs = [&](const Voxel& voxel) {
    const Index copy = fine.copy_of(voxel);
    return copy >= 0 && fragments.of_copy[copy] == fragment;
  };
  for (const Index cell : cells) {
    const auto& at = fine.position(cell);
    for (std::int32_t i = 0; i < r * r * r; ++i) {
      const Voxel voxel{at[0] * r + i / (r * r), at[1] * r + i / r % r, at[2] * r + i % r};
      bool full = true;
      for (Index c = 0; c < 8 && full; ++c)
        full = belongs({voxel[0] + (c >> 2 & 1), voxel[1] + (c >> 1 & 1), voxel[2] + (c & 1)});
      if (full) return true;
    }
  }
  return false;
}

void renumber(Fragments& fragments, std::span<const char> dropped) {
  std::vector<Index> name(fragments.voxels.size(), -1);
  std::vector<std::int64_t> voxels;
  for (std::size_t f = 0; f < name.size(); ++f)
    if (!dropped[f]) {
      name[f] = to_index(voxels.size());
      voxels.push_back(fragments.voxels[f]);
    }
  for (Index& f : fragments.of_copy)
    if (f >= 0) f = name[f];
  fragments.voxels = std::move(voxels);
}

}  // namespace

std::vector<CopyLink> find_links(const FineVoxels& fine, const Interrupt& interrupt) {
  constexpr std::int32_t kChunk = 1024;
  const std::int32_t r = fine.box().ratio, cells = fine.occupied_count();
  const auto copies_of = [&](Index cell) { return fine.first_copy(cell + 1) - fine.first_copy(cell); };
  std::vector<std::vector<CopyLink>> chunks((cells + kChunk - 1) / kChunk);
  tbb::parallel_for(std::size_t{0}, chunks.size(), [&](std::size_t chunk) {
    interrupt.check();
    std::vector<CopyLink>& links = chunks[chunk];
    const Index first = to_index(chunk) * kChunk;
    for (Index cell = first; cell < std::min(cells, first + kChunk); ++cell) {
      const auto& at = fine.position(cell);
      for (int axis = 0; axis < 3; ++axis) {
        std::array<std::int32_t, 3> above = at;
        ++above[axis];
        const Index other = fine.occupied_at(above[0], above[1], above[2]);
        if (other < 0) continue;
        if (fine.is_whole(cell) && fine.is_whole(other)) {
          links.push_back({fine.first_copy(cell), fine.first_copy(other), axis});
          continue;
        }
        const std::size_t start = links.size();
        const bool one_each = copies_of(cell) == 1 && copies_of(other) == 1;
        const std::size_t a = axis, u = (a + 1) % 3, v = (a + 2) % 3;
        Voxel lower;
        lower[a] = (at[a] + 1) * r - 1;
        for (std::int32_t i = 0; i < r; ++i)
          for (std::int32_t j = 0; j < r; ++j) {
            if (one_each && links.size() > start) break;
            lower[u] = at[u] * r + i;
            lower[v] = at[v] * r + j;
            Voxel upper = lower;
            ++upper[a];
            const Index from = fine.copy_of(lower), to = fine.copy_of(upper);
            if (from < 0 || to < 0 || fine.cut_above(lower, axis)) continue;
            const auto known = std::any_of(links.begin() + start, links.end(),
                                           [&](const CopyLink& l) { return l.lower == from && l.upper == to; });
            if (!known) links.push_back({from, to, axis});
          }
      }
    }
  });
  std::size_t count = 0;
  for (const auto& chunk : chunks) count += chunk.size();
  std::vector<CopyLink> links;
  links.reserve(count);
  for (auto& chunk : chunks) {
    links.insert(links.end(), chunk.begin(), chunk.end());
    chunk = {};
  }
  return links;
}

Fragments find_fragments(const FineVoxels& fine, std::span<const CopyLink> links) {
  const std::size_t copies = fine.copy_count();
  DisjointSets same(copies);
  for (const CopyLink& link : links) same.unite(link.lower, link.upper);
  Fragments result;
  result.of_copy.resize(copies);
  for (Index copy = 0; copy < fine.copy_count(); ++copy) {
    const Index root = same.find(copy);
    auto& fragment = result.of_copy[copy];
    if (root == copy) {
      fragment = to_index(result.voxels.size());
      result.voxels.push_back(0);
    } else {
      fragment = result.of_copy[root];
    }
    result.voxels[fragment] += fine.voxels_of_copy(copy);
  }
  return result;
}

std::int64_t drop_specks(const FineVoxels& fine, Fragments& fragments) {
  const std::size_t count = fragments.voxels.size();
  if (count <= 1) return 0;
  // Which fragments each component of the surface bounds, and the largest of them.
  std::vector<std::pair<Index, Index>> bounds;  // component, fragment
  for (Index t = 0; t < fine.triangle_count(); ++t)
    for (const Voxel voxel : fine.inner_voxels(t)) {
      const Index copy = fine.copy_of(voxel);
      if (copy < 0) continue;
      const std::pair pair{fine.component_of(t), fragments.of_copy[copy]};
      if (bounds.empty() || bounds.back() != pair) bounds.push_back(pair);
    }
  std::sort(bounds.begin(), bounds.end());
  bounds.erase(std::unique(bounds.begin(), bounds.end()), bounds.end());
  const auto before = [&](Index a, Index b) {  // larger first, then the lower number
    const std::int64_t va = fragments.voxels[a];
    const std::int64_t vb = fragments.voxels[b];
    return va != vb ? va > vb : a < b;
  };
  std::vector<Index> largest(fine.component_count(), -1);
  for (const auto& [component, fragment] : bounds) {
    Index& best = largest[component];
    if (best < 0 || before(fragment, best)) best = fragment;
  }
  std::vector<char> dropped(count, 0);
  for (const auto& [component, fragment] : bounds)
    if (largest[component] != fragment) dropped[fragment] = 1;

  // Keep those that are pieces in their own right: joined to the rest by a bridge that the voxels do not resolve.
  const std::int64_t cell_voxels = std::int64_t{fine.box().ratio} * fine.box().ratio * fine.box().ratio;
  std::vector<std::vector<Index>> cells(count);
  for (Index cell = 0; cell < fine.occupied_count(); ++cell)
    for (Index copy = fine.first_copy(cell); copy < fine.first_copy(cell + 1); ++copy) {
      const std::size_t f = fragments.of_copy[copy];
      if (dropped[f] && fragments.voxels[f] >= cell_voxels && (cells[f].empty() || cells[f].back() != cell))
        cells[f].push_back(cell);
    }
  std::int64_t voxels = 0;
  for (std::size_t f = 0; f < count; ++f) {
    if (!dropped[f]) continue;
    if (fragments.voxels[f] >= cell_voxels && is_two_voxels_thick(fine, fragments, cells[f], to_index(f)))
      dropped[f] = 0;
    else
      voxels += fragments.voxels[f];
  }
  renumber(fragments, dropped);
  return voxels;
}

namespace {

// Corner c of copy k is number 8 k + c; those that are one node of the lattice form a set.
DisjointSets glue_corners(std::span<const CopyLink> links, const Fragments& fragments) {
  DisjointSets corners(8 * fragments.of_copy.size());
  for (const CopyLink& link : links) {
    if (fragments.of_copy[link.lower] < 0) continue;
    const Index bit = corner_bit(link.axis);
    for (Index c = 0; c < 8; ++c)
      if (c & bit) corners.unite(8 * link.lower + c, 8 * link.upper + (c ^ bit));
  }
  return corners;
}

// Cells that have no nodes yet: the kept copies, equal ones collapsed.
struct CollapsedCells {
  std::vector<Index> of_copy;  // -1 where it was dropped
  std::vector<Index> first_copy;
  std::vector<std::int64_t> voxels;
  std::vector<GridPoint> position;

  std::size_t size() const { return voxels.size(); }
  GridPoint corner(std::size_t cell, Index c) const {
    const auto& p = position[cell];
    return {p[0] + (c >> 2 & 1), p[1] + (c >> 1 & 1), p[2] + (c & 1)};
  }
};

CollapsedCells collapse_copies(const FineVoxels& fine, const Fragments& fragments, DisjointSets& corners) {
  const VoxelBox& box = fine.box();
  CollapsedCells cells;
  cells.of_copy.assign(fragments.of_copy.size(), -1);
  const auto equal = [&](Index a, Index b) {
    for (Index c = 0; c < 8; ++c)
      if (corners.find(8 * a + c) != corners.find(8 * b + c)) return false;
    return true;
  };
  for (Index place = 0; place < fine.occupied_count(); ++place) {
    const std::size_t start = cells.size();
    for (Index copy = fine.first_copy(place); copy < fine.first_copy(place + 1); ++copy) {
      if (fragments.of_copy[copy] < 0) continue;
      std::size_t match = start;
      while (match < cells.size() && !equal(cells.first_copy[match], copy)) ++match;
      if (match == cells.size()) {
        cells.voxels.push_back(0);
        cells.first_copy.push_back(copy);
        const auto& at = fine.position(place);
        cells.position.push_back({box.low[0] + at[0], box.low[1] + at[1], box.low[2] + at[2]});
      }
      cells.voxels[match] += fine.voxels_of_copy(copy);
      cells.of_copy[copy] = to_index(match);
    }
  }
  return cells;
}

// The nodes: sets of corners in grid order, duplicates of a grid point side by side.
struct NumberedNodes {
  std::vector<Index> of_root;  // by the root of a set of corners
  std::vector<char> has_duplicate;
};

NumberedNodes number_nodes(const VoxelBox& box, const CollapsedCells& cells, DisjointSets& corners) {
  struct Node {
    std::int64_t place;
    Index root;
    bool operator<(const Node& other) const { return place != other.place ? place < other.place : root < other.root; }
  };
  std::vector<Node> nodes;
  for (std::size_t cell = 0; cell < cells.size(); ++cell)
    for (Index c = 0; c < 8; ++c) {
      const Index corner = 8 * cells.first_copy[cell] + c;
      if (corners.find(corner) != corner) continue;
      const auto p = cells.corner(cell, c);
      nodes.push_back({(std::int64_t{p[0] - box.low[0]} * (box.cells[1] + 1) + p[1] - box.low[1]) * (box.cells[2] + 1) +
                           p[2] - box.low[2],
                       corner});
    }
  tbb::parallel_sort(nodes.begin(), nodes.end());
  NumberedNodes result;
  result.of_root.assign(8 * cells.of_copy.size(), -1);
  result.has_duplicate.assign(nodes.size(), 0);
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    result.of_root[nodes[n].root] = to_index(n);
    if (n > 0 && nodes[n].place == nodes[n - 1].place) result.has_duplicate[n] = result.has_duplicate[n - 1] = 1;
  }
  return result;
}

}  // namespace

void build_cells(FineVoxels& fine, std::span<const CopyLink> links, const Fragments& fragments, Lattice& lattice,
                 const Interrupt& interrupt) {
  DisjointSets corners = glue_corners(links, fragments);
  interrupt.check();
  CollapsedCells cells = collapse_copies(fine, fragments, corners);
  interrupt.check();
  const NumberedNodes nodes = number_nodes(fine.box(), cells, corners);
  interrupt.check();

  lattice.cell_nodes.resize(cells.size());
  lattice.cell_fill.resize(cells.size());
  lattice.node_rest = RestPositions(lattice.settings.origin, lattice.settings.spacing);
  lattice.node_rest.resize(nodes.has_duplicate.size());
  for (std::size_t cell = 0; cell < cells.size(); ++cell) {
    bool on_grid = true;
    for (Index c = 0; c < 8; ++c) {
      const Index node = nodes.of_root[corners.find(8 * cells.first_copy[cell] + c)];
      lattice.cell_nodes[cell][c] = node;
      lattice.node_rest.grid_point(node) = cells.corner(cell, c);
      on_grid = on_grid && !nodes.has_duplicate[node];
    }
    ++(on_grid ? lattice.grid_cells : lattice.mesh_cells);
    lattice.fine_voxels += cells.voxels[cell];
  }
  lattice.fragments = to_index(fragments.voxels.size());
  fine.set_lattice_cells(std::move(cells.of_copy));
}

}  // namespace lappet
