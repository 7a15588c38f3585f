// Whether a state is one that a solve may start from: cells of a tissue are neither turned over nor flat, but for a few
// at tips and sutures.
#pragma once
#include <Eigen/LU>
#include <span>

#include "lattice/lattice.h"

namespace lappet {

// u: displacements, 3 per node, mm. Looks at J in the middle of each cell.
template <class Real>
bool fit_to_start(const Lattice& lattice, std::span<const Real> u) {
  constexpr double kFlat = 0.05;   // J
  constexpr double kShare = 0.05;  // of the cells
  std::size_t unfit = 0;
  for (const auto& nodes : lattice.cell_nodes) {
    Eigen::Matrix3d f = Eigen::Matrix3d::Zero();
    for (int k = 0; k < 8; ++k) {
      const auto n = 3 * static_cast<std::size_t>(nodes[static_cast<std::size_t>(k)]);
      const Vec3 moved(static_cast<double>(u[n]), static_cast<double>(u[n + 1]), static_cast<double>(u[n + 2]));
      const Vec3 gradient(k & 4 ? 0.25 : -0.25, k & 2 ? 0.25 : -0.25, k & 1 ? 0.25 : -0.25);
      f += moved * gradient.transpose();
    }
    const double j = (Eigen::Matrix3d::Identity() + f / lattice.settings.spacing).determinant();
    unfit += !(j > kFlat);
  }
  return static_cast<double>(unfit) <= kShare * static_cast<double>(lattice.cell_nodes.size());
}

}  // namespace lappet
