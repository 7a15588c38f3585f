// Where in a cell its tissue lies: what a partly filled cell holds has its centroid and extent away from the cell's.
#pragma once
#include <array>
#include <optional>

#include "force/materials/material_parameters.h"
#include "lattice/lattice.h"

namespace lappet {

// The tissue of an eighth of a cell, as a box, in coordinates of the cell from -1 to 1.
struct TissueSample {
  double volume = 0.0;                               // of the cell's
  Vec3 center = Vec3::Zero(), edges = Vec3::Ones();  // a whole eighth has edges of 1
};

inline constexpr double kFullVariance = 1.0 / 3.0;  // of a coordinate in [-1, 1]

// Fills the samples that hold tissue, by the lattice's fine voxels, and returns how many there are.
std::size_t tissue_samples(const Lattice& lattice, std::size_t cell, std::array<TissueSample, 8>& found);

// The whole tissue of a cell as one share; none where it fills the cell, or where no voxel of it is left.
std::optional<MaterialShare> share_of_fill(const Lattice& lattice, std::size_t cell, std::uint8_t material);

// Where tissue lies that has these moments: the volume, the sum of volume * coordinate and of volume * coordinate^2.
MaterialShare share_of_moments(std::size_t cell, std::uint8_t material, double part, double volume, const Vec3& first,
                               const Vec3& second);

}  // namespace lappet
