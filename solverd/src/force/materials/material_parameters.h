// What a material is made of, in the units of the procedure (mm, kPa). Its model is one of
// material_models.h.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "force/materials/material_models.h"

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
  double muscle_stress = 0.0;                                  // kPa, maximal isometric stress; 0: no muscle
  // In-vivo stretch along and across the fiber direction; the third is that of a free surface (prestretch.h).
  std::array<double, 2> prestretch{1.0, 1.0};

  bool has_fibers() const { return fiber_k1 > 0.0; }
  bool has_muscle() const { return muscle_stress > 0.0; }
  bool has_prestretch() const { return prestretch[0] != 1.0 || prestretch[1] != 1.0; }

  double mu() const { return youngs_modulus / (2.0 * (1.0 + poissons_ratio)); }
  double lambda() const {
    return youngs_modulus * poissons_ratio / ((1.0 + poissons_ratio) * (1.0 - 2.0 * poissons_ratio));
  }
};

// The materials of a lattice's cells.
struct CellMaterials {
  std::vector<MaterialParameters> table;
  std::vector<std::uint8_t> of_cell{};  // index into table per cell; empty: table[0] everywhere
  // The outward normal of the skin above each cell: the plane in which fibers run and prestretch acts. Empty: z.
  std::vector<Eigen::Vector3f> normal_of_cell{};

  const MaterialParameters& of(std::size_t cell) const { return table[of_cell.empty() ? 0 : of_cell[cell]]; }
};

}  // namespace lappet
