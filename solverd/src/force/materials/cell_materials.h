// Which material each cell of a lattice is made of: by the place on the skin above it and by its depth below the skin.
//
// Both are those of the cell's rest center, seen from the skin before any cut. So a place keeps its material whatever
// is cut, and both copies of a cell at a wound have the same.
#pragma once
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "force/materials/material_parameters.h"
#include "lattice/lattice.h"

namespace lappet {

struct MaterialRegion {
  std::int32_t material = 0;                                  // index into the table
  double from_depth = 0.0;                                    // mm below the skin, included
  double to_depth = std::numeric_limits<double>::infinity();  // left out
  std::vector<std::uint8_t> faces;                            // per triangle of the skin: whether the region lies below
};

// The material of a cell is that of the last region that holds the skin's triangle closest to the cell's center and
// the distance to it; where none does, table[0]. Where a material has a direction (fibers, muscle, prestretch) each
// cell gets the skin's normal at the closest point too, unless all of them are z. `skin` need not be closed; it may be
// empty without regions. At most 256 materials.
CellMaterials assign_materials(const Lattice& lattice, std::vector<MaterialParameters> table, const Surface& skin,
                               std::span<const MaterialRegion> regions);

}  // namespace lappet
