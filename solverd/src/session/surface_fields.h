// Strain and stress on the surface: cell measures averaged to the nodes by volume, then interpolated at the vertices.
#pragma once
#include <span>

#include "force/elastic.h"
#include "math/parallel.h"
#include "session/program.h"

namespace lappet {

// Fills strain, stress and tension of `output`, one value per surface vertex.
template <class Real>
void write_surface_fields(const Elastic<Real>& elastic, std::span<const Real> u, FrameOutput& output) {
  const Lattice& lattice = elastic.lattice();
  std::vector<std::array<double, 4>> nodes(lattice.node_rest.size(), {0, 0, 0, 0});  // sums and volume
  std::vector<CellMeasures> cells(lattice.cell_nodes.size());
  for_each_index(cells.size(), [&](std::size_t c) { cells[c] = elastic.measures(static_cast<std::int32_t>(c), u); });
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const CellMeasures& cell = cells[c];
    const double volume = static_cast<double>(lattice.cell_fill[c]);
    for (const std::int32_t n : lattice.cell_nodes[c]) {
      auto& sums = nodes[static_cast<std::size_t>(n)];
      sums[0] += volume * (cell.stretch - 1.0);
      sums[1] += volume * cell.von_mises;
      sums[2] += volume * cell.tension;
      sums[3] += volume;
    }
  }
  for (const auto& point : lattice.surface_points) {
    double value[3] = {0, 0, 0};
    for (std::size_t k = 0; k < 8; ++k) {
      const auto& sums = nodes[static_cast<std::size_t>(lattice.cell_nodes[static_cast<std::size_t>(point.cell)][k])];
      for (int i = 0; i < 3; ++i) value[i] += point.weights[k] * sums[static_cast<std::size_t>(i)] / sums[3];
    }
    output.strain.push_back(static_cast<float>(value[0]));
    output.stress.push_back(static_cast<float>(value[1]));
    output.tension.push_back(static_cast<float>(value[2]));
  }
}

}  // namespace lappet
