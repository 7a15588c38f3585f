// What a material is made of, in the units of the procedure (mm, kPa). Its model is one of
// material_models.h.
#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "force/materials/material_models.h"
#include "math/index.h"

namespace lappet {

struct MaterialParameters {
  std::string model{kDefaultMaterialModel};
  double youngs_modulus = 50.0;  // kPa
  double poissons_ratio = 0.45;
  double density = 1100.0;    // kg/m^3
  double mooney_ratio = 0.0;  // mu01 / mu10, where the model has a second modulus
  // Fibers (Gasser, Ogden, Holzapfel 2006) and active muscle along one direction, added on any isotropic model.
  Eigen::Vector3d fiber_direction = Eigen::Vector3d::UnitX();  // rest, unit
  double fiber_k1 = 0.0;                                       // kPa; 0: no fibers
  double fiber_k2 = 0.0, fiber_dispersion = 0.0;               // kappa in [0, 1/3]
  double fiber_slack = 1.0;                                    // stretch from which the fibers bear load, at least 1
  // Degrees, 0 to 90: half of the fibers and of the muscle run at it to the direction, to either side, in the skin's
  // plane. 0: one family.
  double fiber_angle = 0.0;
  double muscle_stress = 0.0;  // kPa, maximal isometric stress; 0: no muscle
  // In-vivo stretch along and across the fiber direction; the third is that of a free surface (prestretch.h).
  std::array<double, 2> prestretch{1.0, 1.0};

  bool has_fibers() const { return fiber_k1 > 0.0; }
  bool has_muscle() const { return muscle_stress > 0.0; }
  bool has_families() const { return fiber_angle > 0.0 && (has_fibers() || has_muscle()); }
  bool has_prestretch() const { return prestretch[0] != 1.0 || prestretch[1] != 1.0; }

  double mu() const { return youngs_modulus / (2.0 * (1.0 + poissons_ratio)); }
  double lambda() const {
    return youngs_modulus * poissons_ratio / ((1.0 + poissons_ratio) * (1.0 - 2.0 * poissons_ratio));
  }
};

// The part of a cell's tissue that is of one material, or of one of its two families of fibers.
struct MaterialShare {
  Index cell;
  std::uint8_t material;  // index into the table
  float volume;           // of the cell's tissue; those of a cell add up to 1
  // Where its quadrature points lie: the cell's, in [-1, 1], times scale plus center, the centroid of the part and its
  // extent over the cell's.
  Eigen::Vector3f center, scale;
  std::int8_t family = 0;  // 1 and -1: whose fibers are turned by the material's angle, and against it
};

// The materials of a lattice's cells.
struct CellMaterials {
  std::vector<MaterialParameters> table;
  std::vector<std::uint8_t> of_cell{};  // index into table per cell, of the largest share; empty: table[0] everywhere
  // The outward normal of the skin above each cell: the plane in which fibers run and prestretch acts. Empty: z.
  std::vector<Eigen::Vector3f> normal_of_cell{};
  // The direction in each cell, in that plane, in place of its material's. Empty, or 0 in a cell: the material's.
  std::vector<Eigen::Vector3f> direction_of_cell{};
  // In-vivo stretch in each cell, in place of that of a material that has one. Empty: the material's.
  std::vector<Eigen::Vector2f> stretch_of_cell{};
  // By cell, of a cell the largest first: all of each cell that holds several materials or two families of fibers, and
  // of one that the tissue does not fill. Empty where nothing differs from cell to cell.
  std::vector<MaterialShare> shares{};

  const MaterialParameters& of(std::size_t cell) const { return table[of_cell.empty() ? 0 : of_cell[cell]]; }
  std::span<const MaterialShare> shares_of(std::size_t cell) const {
    const auto found = std::ranges::equal_range(shares, to_index(cell), {}, &MaterialShare::cell);
    return {found.begin(), found.end()};
  }
  double density(std::size_t cell) const {
    const auto parts = shares_of(cell);
    double sum = parts.empty() ? of(cell).density : 0.0;
    for (const auto& part : parts) sum += double(part.volume) * table[part.material].density;
    return sum;
  }
};

}  // namespace lappet
