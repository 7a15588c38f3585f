// Where in a cell its tissue lies, by the fine voxels and by how far the tissue of those at the surface reaches.
#pragma once
#include <array>

#include "lattice/lattice.h"

namespace lappet {

// The tissue of an eighth of a cell, as a box, in coordinates of the cell from -1 to 1. That of the last voxel below
// the surface may reach out of the cell by half a voxel, where the lattice has no other cell for it.
struct TissueSample {
  double volume = 0.0;                               // of the cell's
  Vec3 center = Vec3::Zero(), edges = Vec3::Ones();  // a whole eighth has edges of 1
};

// Fills the samples that hold tissue and returns how many there are.
std::size_t tissue_samples(const Lattice& lattice, std::size_t cell, std::array<TissueSample, 8>& found);

// The tissue that each cell holds, as `Lattice::cell_fill`.
void measure_fill(Lattice& lattice, const Interrupt& interrupt = {});

}  // namespace lappet
