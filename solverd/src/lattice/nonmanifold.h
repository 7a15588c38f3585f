// Algorithm 2 of GRIDiron (§5.3): a copy of a coarse cell per connected component of its inside voxels, copies in
// face-adjacent cells glued at the four shared corners where their voxels are connected across the face, equal copies
// collapsed; then a compact numbering in grid order and the grid/mesh counts of §5.4.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "lattice/lattice.h"
#include "lattice/voxelize.h"

namespace lappet {

// Two copies whose voxels are connected across the face between their cells; `upper` lies at +axis of `lower`.
struct CopyLink {
  Index lower, upper;
  std::int32_t axis;
};

// All links, each once, in a fixed order.
std::vector<CopyLink> find_links(const FineVoxels& fine, const Interrupt& interrupt = {});

// The connected components of the voxels, as a number per copy.
struct Fragments {
  std::vector<Index> of_copy;        // numbered by first copy; -1 once dropped
  std::vector<std::int64_t> voxels;  // per fragment
};
Fragments find_fragments(const FineVoxels& fine, std::span<const CopyLink> links);

// The voxels of a sharp tip of tissue fall apart where it is thinner than a voxel's diagonal. Such specks are no pieces
// of tissue of their own: the surface around them is joined to that of a larger fragment. Drops every fragment that
// shares a connected part of the surface with a larger one and is smaller than a cell or nowhere two voxels thick (so
// that its points are carried by the larger one); returns the number of voxels dropped and renumbers the rest.
std::int64_t drop_specks(const FineVoxels& fine, Fragments& fragments);

// Makes cells and nodes of what is left, stores in `fine` which cell each copy became, and fills the counts of
// `lattice`.
void build_cells(FineVoxels& fine, std::span<const CopyLink> links, const Fragments& fragments, Lattice& lattice,
                 const Interrupt& interrupt = {});

}  // namespace lappet
