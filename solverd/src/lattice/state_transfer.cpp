// Carries nodal positions from one epoch's lattice to the next.
//
// Both lattices share origin, spacing and ratio, so voxels and cells coincide in space. A new cell inherits from the
// old cell at the same place that holds most of its voxels; corner c of the one is corner c of the other, so a field
// passes unchanged wherever the topology did not change.
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <string>

#include "lattice/lattice.h"
#include "lattice/refused.h"
#include "lattice/voxelize.h"

namespace lappet {
namespace {

// Per new cell: the old cell that holds most of its voxels, or -1. The smallest number wins a tie.
std::vector<Index> find_ancestors(const Lattice& from, const Lattice& to, const Interrupt& interrupt) {
  const FineVoxels &old_fine = *from.fine, &new_fine = *to.fine;
  const std::int32_t r = new_fine.box().ratio;
  std::array<std::int32_t, 3> shift;  // from the new box to the old one, cells
  for (std::size_t a = 0; a < 3; ++a) shift[a] = new_fine.box().low[a] - old_fine.box().low[a];

  std::vector<Index> ancestor(to.cell_nodes.size(), -1);
  tbb::parallel_for(tbb::blocked_range<Index>(0, new_fine.occupied_count(), 256), [&](const auto& range) {
    interrupt.check();
    struct Overlap {
      Index new_cell, old_cell;
      std::int64_t voxels;
    };
    std::vector<Overlap> overlaps;
    for (Index place = range.begin(); place != range.end(); ++place) {
      const auto& at = new_fine.position(place);
      const Index old_place = old_fine.occupied_at(at[0] + shift[0], at[1] + shift[1], at[2] + shift[2]);
      if (old_place < 0) continue;
      if (new_fine.is_whole(place) && old_fine.is_whole(old_place)) {
        const auto& old_at = old_fine.position(old_place);
        const Index cell = new_fine.lattice_cell({at[0] * r, at[1] * r, at[2] * r});
        if (cell >= 0) ancestor[cell] = old_fine.lattice_cell({old_at[0] * r, old_at[1] * r, old_at[2] * r});
        continue;
      }
      overlaps.clear();
      for (std::int32_t i = 0; i < r * r * r; ++i) {
        const Voxel voxel{at[0] * r + i / (r * r), at[1] * r + i / r % r, at[2] * r + i % r};
        const Index new_cell = new_fine.lattice_cell(voxel);
        if (new_cell < 0) continue;
        const Index old_cell =
            old_fine.lattice_cell({voxel[0] + shift[0] * r, voxel[1] + shift[1] * r, voxel[2] + shift[2] * r});
        if (old_cell < 0) continue;
        const auto known = std::find_if(overlaps.begin(), overlaps.end(), [&](const Overlap& o) {
          return o.new_cell == new_cell && o.old_cell == old_cell;
        });
        if (known == overlaps.end())
          overlaps.push_back({new_cell, old_cell, 1});
        else
          ++known->voxels;
      }
      std::sort(overlaps.begin(), overlaps.end(), [](const Overlap& a, const Overlap& b) {
        return a.voxels != b.voxels ? a.voxels > b.voxels : a.old_cell < b.old_cell;
      });
      for (const Overlap& o : overlaps) {
        Index& chosen = ancestor[o.new_cell];
        if (chosen < 0) chosen = o.old_cell;
      }
    }
  });
  return ancestor;
}

// Tissue that was not there before moves with its neighbors: nodes still without a value take, round by round, the
// mean displacement of the known nodes of their cells, or stay at rest where a whole fragment is new.
void spread(const Lattice& lattice, std::vector<char>& known, std::vector<Vec3>& position, const Interrupt& interrupt) {
  for (bool progress = true; progress;) {
    progress = false;
    interrupt.check();
    std::vector<Vec3> sum(position.size(), Vec3::Zero());
    std::vector<int> count(position.size(), 0);
    for (const auto& nodes : lattice.cell_nodes) {
      Vec3 mean = Vec3::Zero();
      int values = 0;
      for (const Index node : nodes)
        if (const std::size_t n = node; known[n]) {
          mean += position[n] - lattice.node_rest[n];
          ++values;
        }
      if (values == 0 || values == 8) continue;
      for (const Index node : nodes)
        if (const std::size_t n = node; !known[n]) {
          sum[n] += mean / values;
          ++count[n];
        }
    }
    for (std::size_t n = 0; n < position.size(); ++n)
      if (count[n] > 0) {
        position[n] = lattice.node_rest[n] + sum[n] / count[n];
        known[n] = 1;
        progress = true;
      }
  }
  for (std::size_t n = 0; n < position.size(); ++n)
    if (!known[n]) position[n] = lattice.node_rest[n];
}

}  // namespace

std::vector<Vec3> transfer_positions(const Lattice& from, std::span<const Vec3> positions, const Lattice& to,
                                     const Interrupt& interrupt) {
  const LatticeSettings &a = from.settings, &b = to.settings;
  if (a.spacing != b.spacing || a.fine_ratio != b.fine_ratio || a.origin != b.origin)
    throw RefusedError(
        ErrorCode::kInvalidInput,
        "The state of one epoch can pass only to a lattice of the same origin, spacing and fine ratio; keep "
        "them for the whole session.");
  if (positions.size() != from.node_rest.size())
    throw RefusedError(ErrorCode::kInternal, "The state to carry over has " + std::to_string(positions.size()) +
                                                 " positions, but its lattice has " +
                                                 std::to_string(from.node_rest.size()) + " nodes.");
  const auto ancestor = find_ancestors(from, to, interrupt);
  interrupt.check();
  std::vector<Vec3> result(to.node_rest.size(), Vec3::Zero());
  std::vector<Index> only(result.size(), -1);  // the one old node that reaches a node; -2: several
  std::vector<int> count(result.size(), 0);
  for (std::size_t cell = 0; cell < to.cell_nodes.size(); ++cell) {
    if (ancestor[cell] < 0) continue;
    for (std::size_t c = 0; c < 8; ++c) {
      const std::size_t node = to.cell_nodes[cell][c];
      const Index old = from.cell_nodes[ancestor[cell]][c];
      only[node] = count[node] == 0 || only[node] == old ? old : -2;
      result[node] += positions[old];
      ++count[node];
    }
  }
  std::vector<char> known(result.size(), 0);
  bool all = true;
  for (std::size_t node = 0; node < result.size(); ++node) {
    known[node] = count[node] > 0;
    all = all && known[node];
    if (only[node] >= 0)
      result[node] = positions[only[node]];
    else if (count[node] > 0)
      result[node] /= count[node];
  }
  if (!all) spread(to, known, result, interrupt);
  return result;
}

}  // namespace lappet
