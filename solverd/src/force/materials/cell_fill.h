// The share of a partly filled cell: what it holds has its centroid and extent away from the cell's.
#pragma once
#include <optional>

#include "force/materials/material_parameters.h"
#include "lattice/lattice.h"

namespace lappet {

inline constexpr double kFullVariance = 1.0 / 3.0;  // of a coordinate in [-1, 1]

// The whole tissue of a cell as one share; none where it fills the cell, or where no voxel of it is left.
std::optional<MaterialShare> share_of_fill(const Lattice& lattice, std::size_t cell, std::uint8_t material);

// Where tissue lies that has these moments: the volume, the sum of volume * coordinate and of volume * coordinate^2.
MaterialShare share_of_moments(std::size_t cell, std::uint8_t material, double part, double volume, const Vec3& first,
                               const Vec3& second);

}  // namespace lappet
