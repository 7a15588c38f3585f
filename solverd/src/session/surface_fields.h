// Strain and stress on the surface: cell measures averaged to the nodes by volume, then interpolated at the vertices.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "force/elastic/elastic.h"
#include "math/parallel.h"
#include "session/program.h"

namespace lappet {

// Fills strain, stress and tension of `output`, one value per surface vertex. u: the displacements last evaluated. Only
// the cells around nodes that a vertex is embedded in are looked at.
template <class Real>
void write_surface_fields(const Elastic<Real>& elastic, std::span<const Real> u, FrameFields& output) {
  const Lattice& lattice = elastic.lattice();
  const auto nodes_of = [&](std::int32_t cell) -> const auto& {
    return lattice.cell_nodes[static_cast<std::size_t>(cell)];
  };
  std::vector<std::uint8_t> wanted(lattice.node_rest.size(), 0);
  for (const auto& point : lattice.surface_points)
    for (const std::int32_t n : nodes_of(point.cell)) wanted[static_cast<std::size_t>(n)] = 1;
  std::vector<std::int32_t> cells;
  for (std::size_t c = 0; c < lattice.cell_nodes.size(); ++c)
    if (std::ranges::any_of(lattice.cell_nodes[c], [&](std::int32_t n) { return wanted[static_cast<std::size_t>(n)]; }))
      cells.push_back(static_cast<std::int32_t>(c));

  std::vector<CellMeasures> measures(cells.size());
  for_each_index(cells.size(), [&](std::size_t k) { measures[k] = elastic.measures(cells[k], u); });
  struct Sums {
    float stretch = 0, von_mises = 0, tension = 0, volume = 0;
  };
  std::vector<Sums> nodes(lattice.node_rest.size());
  for (std::size_t k = 0; k < cells.size(); ++k) {
    const float volume = lattice.cell_fill[static_cast<std::size_t>(cells[k])];
    const Sums own{volume * static_cast<float>(measures[k].stretch - 1.0),
                   volume * static_cast<float>(measures[k].von_mises), volume * static_cast<float>(measures[k].tension),
                   volume};
    for (const std::int32_t n : nodes_of(cells[k])) {
      Sums& sums = nodes[static_cast<std::size_t>(n)];
      sums.stretch += own.stretch;
      sums.von_mises += own.von_mises;
      sums.tension += own.tension;
      sums.volume += own.volume;
    }
  }
  const std::size_t points = lattice.surface_points.size();
  output.strain.resize(points);
  output.stress.resize(points);
  output.tension.resize(points);
  for_each_index(points, [&](std::size_t p) {
    const auto& point = lattice.surface_points[p];
    double strain = 0, stress = 0, tension = 0;
    for (std::size_t k = 0; k < 8; ++k) {
      const Sums& sums = nodes[static_cast<std::size_t>(nodes_of(point.cell)[k])];
      const double share = point.weights[k] / static_cast<double>(sums.volume);
      strain += share * static_cast<double>(sums.stretch);
      stress += share * static_cast<double>(sums.von_mises);
      tension += share * static_cast<double>(sums.tension);
    }
    output.strain[p] = static_cast<float>(strain);
    output.stress[p] = static_cast<float>(stress);
    output.tension[p] = static_cast<float>(tension);
  });
}

}  // namespace lappet
