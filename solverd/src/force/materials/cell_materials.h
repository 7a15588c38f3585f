// Which materials each cell of a lattice is made of: by the place on the skin above it and by its depth below the skin.
//
// Both are seen from the skin before any cut, so a place keeps its material whatever is cut. A cell through which a
// boundary passes holds a share of each material (cell_shares.h).
#pragma once
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "force/materials/material_parameters.h"
#include "force/materials/strands.h"
#include "lattice/lattice.h"

namespace lappet {

struct MaterialRegion {
  std::int32_t material = 0;                                  // index into the table
  double from_depth = 0.0;                                    // mm below the skin, included
  double to_depth = std::numeric_limits<double>::infinity();  // left out
  std::vector<std::uint8_t> faces;                            // per triangle of the skin: whether the region lies below
};

// What the points of the skin say of the tissue below them.
struct SkinFields {
  std::vector<Vec3> directions{};  // of fibers, muscle and prestretch; 0: no matter. Empty: the materials'
  std::vector<std::array<double, 2>> stretch{};  // in vivo, along and across. Empty: the materials'
};

// A place is of the material of the last region that holds the skin's triangle closest to it and the distance to that;
// where none does, of table[0]. Where a material has a direction (fibers, muscle, prestretch) each cell gets the skin's
// normal at the point closest to its center too, unless all of them are z, and the direction and stretch there that
// `fields` has. Strands of muscle lie in all of it (strands.h). `skin` need not be closed; it may be empty without
// regions. At most 256 materials.
CellMaterials assign_materials(const Lattice& lattice, std::vector<MaterialParameters> table, const Surface& skin,
                               std::span<const MaterialRegion> regions, const SkinFields& fields = {},
                               const Interrupt& interrupt = {}, std::span<const Strand> strands = {});

}  // namespace lappet
