// The clusters of nodes over which a residual is compared with the forces that are there.
//
// One norm over the whole tissue would let a floppy flap hide in a large or taut patch: the more tissue lies around it,
// the larger the residual that it may keep. A cluster is what of a fragment lies in a cube of some cells, so what a
// place has to reach depends on that place alone, however large the patch around it is.
//
// Of a residual counts what exceeds what the rounding of the displacements leaves of one: tissue that has come far
// knows its place to so many digits only, and no search can do better.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "force/materials/material_parameters.h"
#include "lattice/lattice.h"

namespace lappet {

struct ResidualNorms {
  double residual = 0.0, force_scale = 0.0;  // 2-norms over all free nodes, mN
  // What of the residual is not rounding / force scale, the larger of the whole's and any cluster's.
  double relative = 0.0;
};

class ResidualClusters {
 public:
  ResidualClusters() = default;
  // fragment_of_node: empty where all hang together.
  ResidualClusters(const Lattice& lattice, const CellMaterials& materials,
                   std::span<const std::int32_t> fragment_of_node);

  // gradient, displacements u: 3 per node; scale: the elastic force magnitudes at each node. Nodes that are not free do
  // not count.
  template <class Real>
  ResidualNorms norms(std::span<const double> gradient, std::span<const double> scale,
                      std::span<const std::uint8_t> free, std::span<const Real> u) const;
  std::size_t bytes() const;

 private:
  std::vector<std::int32_t> nodes_;  // cluster after cluster
  std::vector<std::size_t> first_;   // where each begins, and the end
  std::vector<double> force_floor_;  // least force at a node of each, mN
  std::vector<double> stiffness_;    // least oedometric modulus times spacing in each, mN/mm
};

}  // namespace lappet
