#include "lattice/nonmanifold.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace lappet {
namespace {

// Equivalence classes; the root of a class is its smallest element, so the result does not depend on the order of
// joins.
class Equivalence {
 public:
  explicit Equivalence(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }
  std::int32_t root(std::int32_t i) {
    auto at = static_cast<std::size_t>(i);
    while (parent_[at] != static_cast<std::int32_t>(at)) {
      parent_[at] = parent_[static_cast<std::size_t>(parent_[at])];
      at = static_cast<std::size_t>(parent_[at]);
    }
    return static_cast<std::int32_t>(at);
  }
  void join(std::int32_t a, std::int32_t b) {
    a = root(a);
    b = root(b);
    if (a != b) parent_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
  }

 private:
  std::vector<std::int32_t> parent_;
};

std::int32_t corner_bit(int axis) { return 4 >> axis; }  // corner number: x 4, y 2, z 1

// Does a fragment hold a block of 2 x 2 x 2 voxels?
bool is_two_voxels_thick(const FineVoxels& fine, const Fragments& fragments, std::span<const std::int32_t> cells,
                         std::int32_t fragment) {
  const std::int32_t r = fine.box().ratio;
  const auto belongs = [&](const Voxel& voxel) {
    const std::int32_t copy = fine.copy_of(voxel);
    return copy >= 0 && fragments.of_copy[static_cast<std::size_t>(copy)] == fragment;
  };
  for (const std::int32_t cell : cells) {
    const auto& at = fine.position(cell);
    for (std::int32_t i = 0; i < r * r * r; ++i) {
      const Voxel voxel{at[0] * r + i / (r * r), at[1] * r + i / r % r, at[2] * r + i % r};
      bool full = true;
      for (std::int32_t c = 0; c < 8 && full; ++c)
        full = belongs({voxel[0] + (c >> 2 & 1), voxel[1] + (c >> 1 & 1), voxel[2] + (c & 1)});
      if (full) return true;
    }
  }
  return false;
}

void renumber(Fragments& fragments, std::span<const char> dropped) {
  std::vector<std::int32_t> name(fragments.voxels.size(), -1);
  std::vector<std::int64_t> voxels;
  for (std::size_t f = 0; f < name.size(); ++f)
    if (!dropped[f]) {
      name[f] = static_cast<std::int32_t>(voxels.size());
      voxels.push_back(fragments.voxels[f]);
    }
  for (std::int32_t& f : fragments.of_copy)
    if (f >= 0) f = name[static_cast<std::size_t>(f)];
  fragments.voxels = std::move(voxels);
}

}  // namespace

std::vector<CopyLink> find_links(const FineVoxels& fine) {
  constexpr std::int32_t kChunk = 1024;
  const std::int32_t r = fine.box().ratio, cells = fine.occupied_count();
  const auto copies_of = [&](std::int32_t cell) { return fine.first_copy(cell + 1) - fine.first_copy(cell); };
  std::vector<std::vector<CopyLink>> chunks(static_cast<std::size_t>((cells + kChunk - 1) / kChunk));
  tbb::parallel_for(std::size_t{0}, chunks.size(), [&](std::size_t chunk) {
    std::vector<CopyLink>& links = chunks[chunk];
    const auto first = static_cast<std::int32_t>(chunk) * kChunk;
    for (std::int32_t cell = first; cell < std::min(cells, first + kChunk); ++cell) {
      const auto& at = fine.position(cell);
      for (int axis = 0; axis < 3; ++axis) {
        std::array<std::int32_t, 3> above = at;
        ++above[static_cast<std::size_t>(axis)];
        const std::int32_t other = fine.occupied_at(above[0], above[1], above[2]);
        if (other < 0) continue;
        if (fine.is_whole(cell) && fine.is_whole(other)) {
          links.push_back({fine.first_copy(cell), fine.first_copy(other), axis});
          continue;
        }
        const std::size_t start = links.size();
        const bool one_each = copies_of(cell) == 1 && copies_of(other) == 1;
        const auto a = static_cast<std::size_t>(axis), u = (a + 1) % 3, v = (a + 2) % 3;
        Voxel lower;
        lower[a] = (at[a] + 1) * r - 1;
        for (std::int32_t i = 0; i < r; ++i)
          for (std::int32_t j = 0; j < r; ++j) {
            if (one_each && links.size() > start) break;
            lower[u] = at[u] * r + i;
            lower[v] = at[v] * r + j;
            Voxel upper = lower;
            ++upper[a];
            const std::int32_t from = fine.copy_of(lower), to = fine.copy_of(upper);
            if (from < 0 || to < 0 || fine.cut_above(lower, axis)) continue;
            const auto known = std::any_of(links.begin() + static_cast<std::ptrdiff_t>(start), links.end(),
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
  const auto copies = static_cast<std::size_t>(fine.copy_count());
  Equivalence same(copies);
  for (const CopyLink& link : links) same.join(link.lower, link.upper);
  Fragments result;
  result.of_copy.resize(copies);
  for (std::int32_t copy = 0; copy < fine.copy_count(); ++copy) {
    const std::int32_t root = same.root(copy);
    auto& fragment = result.of_copy[static_cast<std::size_t>(copy)];
    if (root == copy) {
      fragment = static_cast<std::int32_t>(result.voxels.size());
      result.voxels.push_back(0);
    } else {
      fragment = result.of_copy[static_cast<std::size_t>(root)];
    }
    result.voxels[static_cast<std::size_t>(fragment)] += fine.voxels_of_copy(copy);
  }
  return result;
}

std::int64_t drop_specks(const FineVoxels& fine, Fragments& fragments) {
  const std::size_t count = fragments.voxels.size();
  if (count <= 1) return 0;
  // Which fragments each component of the surface bounds, and the largest of them.
  std::vector<std::pair<std::int32_t, std::int32_t>> bounds;  // component, fragment
  for (std::int32_t t = 0; t < fine.triangle_count(); ++t)
    for (const Voxel voxel : fine.inner_voxels(t)) {
      const std::int32_t copy = fine.copy_of(voxel);
      if (copy < 0) continue;
      const std::pair pair{fine.component_of(t), fragments.of_copy[static_cast<std::size_t>(copy)]};
      if (bounds.empty() || bounds.back() != pair) bounds.push_back(pair);
    }
  std::sort(bounds.begin(), bounds.end());
  bounds.erase(std::unique(bounds.begin(), bounds.end()), bounds.end());
  const auto before = [&](std::int32_t a, std::int32_t b) {  // larger first, then the lower number
    const std::int64_t va = fragments.voxels[static_cast<std::size_t>(a)];
    const std::int64_t vb = fragments.voxels[static_cast<std::size_t>(b)];
    return va != vb ? va > vb : a < b;
  };
  std::vector<std::int32_t> largest(static_cast<std::size_t>(fine.component_count()), -1);
  for (const auto& [component, fragment] : bounds) {
    std::int32_t& best = largest[static_cast<std::size_t>(component)];
    if (best < 0 || before(fragment, best)) best = fragment;
  }
  std::vector<char> dropped(count, 0);
  for (const auto& [component, fragment] : bounds)
    if (largest[static_cast<std::size_t>(component)] != fragment) dropped[static_cast<std::size_t>(fragment)] = 1;

  // Keep those that are pieces in their own right: joined to the rest by a bridge that the voxels do not resolve.
  const std::int64_t cell_voxels = std::int64_t{fine.box().ratio} * fine.box().ratio * fine.box().ratio;
  std::vector<std::vector<std::int32_t>> cells(count);
  for (std::int32_t cell = 0; cell < fine.occupied_count(); ++cell)
    for (std::int32_t copy = fine.first_copy(cell); copy < fine.first_copy(cell + 1); ++copy) {
      const auto f = static_cast<std::size_t>(fragments.of_copy[static_cast<std::size_t>(copy)]);
      if (dropped[f] && fragments.voxels[f] >= cell_voxels && (cells[f].empty() || cells[f].back() != cell))
        cells[f].push_back(cell);
    }
  std::int64_t voxels = 0;
  for (std::size_t f = 0; f < count; ++f) {
    if (!dropped[f]) continue;
    if (fragments.voxels[f] >= cell_voxels &&
        is_two_voxels_thick(fine, fragments, cells[f], static_cast<std::int32_t>(f)))
      dropped[f] = 0;
    else
      voxels += fragments.voxels[f];
  }
  renumber(fragments, dropped);
  return voxels;
}

void build_cells(FineVoxels& fine, std::span<const CopyLink> links, const Fragments& fragments, Lattice& lattice) {
  const std::int32_t copies = fine.copy_count();
  const VoxelBox& box = fine.box();
  const auto kept = [&](std::int32_t copy) { return fragments.of_copy[static_cast<std::size_t>(copy)] >= 0; };

  // Corner c of copy k is number 8 k + c.
  Equivalence corners(8 * static_cast<std::size_t>(copies));
  for (const CopyLink& link : links) {
    if (!kept(link.lower)) continue;
    const std::int32_t bit = corner_bit(link.axis);
    for (std::int32_t c = 0; c < 8; ++c)
      if (c & bit) corners.join(8 * link.lower + c, 8 * link.upper + (c ^ bit));
  }

  // Cells: the kept copies, equal ones collapsed.
  std::vector<std::int32_t> cell_of_copy(static_cast<std::size_t>(copies), -1);
  std::vector<std::int32_t> first_copy_of_cell;
  std::vector<std::int64_t> voxels;
  std::vector<GridPoint> position;  // by cell
  for (std::int32_t cell = 0; cell < fine.occupied_count(); ++cell) {
    const std::size_t start = voxels.size();
    for (std::int32_t copy = fine.first_copy(cell); copy < fine.first_copy(cell + 1); ++copy) {
      if (!kept(copy)) continue;
      std::size_t match = start;
      for (; match < voxels.size(); ++match) {
        bool equal = true;
        for (std::int32_t c = 0; c < 8 && equal; ++c)
          equal = corners.root(8 * first_copy_of_cell[match] + c) == corners.root(8 * copy + c);
        if (equal) break;
      }
      if (match == voxels.size()) {
        voxels.push_back(0);
        first_copy_of_cell.push_back(copy);
        const auto& at = fine.position(cell);
        position.push_back({box.low[0] + at[0], box.low[1] + at[1], box.low[2] + at[2]});
      }
      voxels[match] += fine.voxels_of_copy(copy);
      cell_of_copy[static_cast<std::size_t>(copy)] = static_cast<std::int32_t>(match);
    }
  }

  // Nodes: the classes of corners, in grid order, duplicates of a grid point side by side.
  struct Node {
    std::int64_t place;
    std::int32_t root;
    bool operator<(const Node& other) const { return place != other.place ? place < other.place : root < other.root; }
  };
  const auto grid_point = [&](std::size_t cell, std::int32_t c) {
    const auto& p = position[cell];
    return GridPoint{p[0] + (c >> 2 & 1), p[1] + (c >> 1 & 1), p[2] + (c & 1)};
  };
  std::vector<Node> nodes;
  for (std::size_t cell = 0; cell < voxels.size(); ++cell)
    for (std::int32_t c = 0; c < 8; ++c) {
      const std::int32_t element = 8 * first_copy_of_cell[cell] + c;
      const std::int32_t root = corners.root(element);
      if (root != element) continue;
      const auto p = grid_point(cell, c);
      nodes.push_back({(std::int64_t{p[0] - box.low[0]} * (box.cells[1] + 1) + p[1] - box.low[1]) * (box.cells[2] + 1) +
                           p[2] - box.low[2],
                       root});
    }
  tbb::parallel_sort(nodes.begin(), nodes.end());
  std::vector<std::int32_t> node_of_root(8 * static_cast<std::size_t>(copies), -1);
  std::vector<char> has_duplicate(nodes.size(), 0);
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    node_of_root[static_cast<std::size_t>(nodes[n].root)] = static_cast<std::int32_t>(n);
    if (n > 0 && nodes[n].place == nodes[n - 1].place) has_duplicate[n] = has_duplicate[n - 1] = 1;
  }

  const std::int32_t r = box.ratio;
  const double cell_voxels = double(r) * r * r;
  lattice.cell_nodes.resize(voxels.size());
  lattice.cell_fill.resize(voxels.size());
  lattice.node_rest = RestPositions(lattice.settings.origin, lattice.settings.spacing);
  lattice.node_rest.resize(nodes.size());
  for (std::size_t cell = 0; cell < voxels.size(); ++cell) {
    bool on_grid = true;
    for (std::int32_t c = 0; c < 8; ++c) {
      const auto node = static_cast<std::size_t>(
          node_of_root[static_cast<std::size_t>(corners.root(8 * first_copy_of_cell[cell] + c))]);
      lattice.cell_nodes[cell][static_cast<std::size_t>(c)] = static_cast<std::int32_t>(node);
      lattice.node_rest.grid_point(node) = grid_point(cell, c);
      on_grid = on_grid && !has_duplicate[node];
    }
    ++(on_grid ? lattice.grid_cells : lattice.mesh_cells);
    const double fill = std::max(double(voxels[cell]) / cell_voxels, lattice.settings.fill_floor);
    lattice.cell_fill[cell] = static_cast<float>(std::min(fill, 1.0));
    lattice.fine_voxels += voxels[cell];
  }
  lattice.fragments = static_cast<std::int32_t>(fragments.voxels.size());
  fine.set_lattice_cells(std::move(cell_of_copy));
}

}  // namespace lappet
