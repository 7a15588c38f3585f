// Whether a state is one that a solve may start from: cells of a tissue are neither turned over nor flat, but for a few
// at tips and sutures.
#pragma once
#include <Eigen/LU>
#include <numeric>
#include <span>
#include <vector>

#include "lattice/lattice.h"
#include "math/parallel.h"

namespace lappet {

// u: displacements, 3 per node, mm. Looks at J in the middle of each cell.
template <class Real>
bool is_valid_start(const Lattice& lattice, std::span<const Real> u) {
  constexpr double kFlat = 0.05;   // J
  constexpr double kShare = 0.05;  // of the cells
  const std::size_t cells = lattice.cell_nodes.size();
  std::vector<std::size_t> unfit((cells + kChunk - 1) / kChunk, 0);
  for_each_chunk(cells, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      Eigen::Matrix3d f = Eigen::Matrix3d::Zero();
      for (int k = 0; k < 8; ++k) {
        const auto n = 3 * static_cast<std::size_t>(lattice.cell_nodes[c][static_cast<std::size_t>(k)]);
        const Vec3 moved(static_cast<double>(u[n]), static_cast<double>(u[n + 1]), static_cast<double>(u[n + 2]));
        const Vec3 gradient(k & 4 ? 0.25 : -0.25, k & 2 ? 0.25 : -0.25, k & 1 ? 0.25 : -0.25);
        f += moved * gradient.transpose();
      }
      unfit[chunk] += !((Eigen::Matrix3d::Identity() + f / lattice.settings.spacing).determinant() > kFlat);
    }
  });
  const auto total = std::accumulate(unfit.begin(), unfit.end(), std::size_t{0});
  return static_cast<double>(total) <= kShare * static_cast<double>(cells);
}

}  // namespace lappet
