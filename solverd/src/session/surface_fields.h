// Strain and stress on the surface: cell measures averaged to the nodes by volume, then interpolated at the vertices.
#pragma once
#include <algorithm>
#include <span>
#include <vector>

#include "force/elastic.h"
#include "math/parallel.h"
#include "session/program.h"

namespace lappet {

// Fills strain, stress and tension of `output`, one value per surface vertex.
template <class Real>
void write_surface_fields(const Elastic<Real>& elastic, std::span<const Real> u, FrameOutput& output) {
  const Lattice& lattice = elastic.lattice();
  // Nodes that a vertex takes something from, and the cells around them: most of the tissue is neither.
  std::vector<std::int32_t> number(lattice.node_rest.size(), -1);
  std::size_t count = 0;
  for (const auto& point : lattice.surface_points)
    for (std::size_t k = 0; k < 8; ++k)
      if (point.weights[k] != 0.0) {
        auto& n = number[static_cast<std::size_t>(lattice.cell_nodes[static_cast<std::size_t>(point.cell)][k])];
        if (n < 0) n = static_cast<std::int32_t>(count++);
      }
  std::vector<std::int32_t> cells;
  for (std::size_t c = 0; c < lattice.cell_nodes.size(); ++c)
    if (std::ranges::any_of(lattice.cell_nodes[c],
                            [&](std::int32_t n) { return number[static_cast<std::size_t>(n)] >= 0; }))
      cells.push_back(static_cast<std::int32_t>(c));
  std::vector<CellMeasures> measures(cells.size());
  for_each_index(cells.size(), [&](std::size_t i) { measures[i] = elastic.measures(cells[i], u); });
  std::vector<std::array<double, 4>> nodes(count, {0, 0, 0, 0});  // sums and volume
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const CellMeasures& cell = measures[i];
    const double volume = static_cast<double>(lattice.cell_fill[static_cast<std::size_t>(cells[i])]);
    for (const std::int32_t node : lattice.cell_nodes[static_cast<std::size_t>(cells[i])]) {
      const std::int32_t n = number[static_cast<std::size_t>(node)];
      if (n < 0) continue;
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
      if (point.weights[k] == 0.0) continue;
      const std::int32_t node = lattice.cell_nodes[static_cast<std::size_t>(point.cell)][k];
      const auto& sums = nodes[static_cast<std::size_t>(number[static_cast<std::size_t>(node)])];
      for (int i = 0; i < 3; ++i) value[i] += point.weights[k] * sums[static_cast<std::size_t>(i)] / sums[3];
    }
    output.strain.push_back(static_cast<float>(value[0]));
    output.stress.push_back(static_cast<float>(value[1]));
    output.tension.push_back(static_cast<float>(value[2]));
  }
}

}  // namespace lappet
