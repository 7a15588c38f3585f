#include "solve/subdomain/subdomain.h"

#include <algorithm>

namespace lappet {

namespace {

// The cells around the nodes that move.
std::vector<std::int32_t> cells_around(std::span<const std::uint8_t> moving, const Lattice& whole) {
  std::vector<std::int32_t> cells;
  for (std::size_t c = 0; c < whole.cell_nodes.size(); ++c)
    if (std::ranges::any_of(whole.cell_nodes[c], [&](std::int32_t n) { return moving[static_cast<std::size_t>(n)]; }))
      cells.push_back(static_cast<std::int32_t>(c));
  return cells;
}

// Their corners, in the order of the whole.
std::vector<std::int32_t> corners_of(std::span<const std::int32_t> cells, const Lattice& whole) {
  std::vector<std::uint8_t> is_corner(whole.node_rest.size(), 0);
  for (const std::int32_t cell : cells)
    for (const std::int32_t n : whole.cell_nodes[static_cast<std::size_t>(cell)])
      is_corner[static_cast<std::size_t>(n)] = 1;
  std::vector<std::int32_t> nodes;
  for (std::size_t n = 0; n < is_corner.size(); ++n)
    if (is_corner[n]) nodes.push_back(static_cast<std::int32_t>(n));
  return nodes;
}

Lattice lattice_of(std::span<const std::int32_t> cells, std::span<const std::int32_t> nodes, const Lattice& whole) {
  Lattice lattice;
  lattice.settings = whole.settings;
  lattice.node_rest = RestPositions(whole.settings.origin, whole.settings.spacing);
  std::vector<std::int32_t> place(whole.node_rest.size(), -1);
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    place[static_cast<std::size_t>(nodes[n])] = static_cast<std::int32_t>(n);
    lattice.node_rest.push_back(whole.node_rest.grid_point(static_cast<std::size_t>(nodes[n])));
  }
  for (const std::int32_t cell : cells) {
    auto corners = whole.cell_nodes[static_cast<std::size_t>(cell)];
    for (std::int32_t& n : corners) n = place[static_cast<std::size_t>(n)];
    lattice.cell_nodes.push_back(corners);
    lattice.cell_fill.push_back(whole.cell_fill[static_cast<std::size_t>(cell)]);
  }
  return lattice;
}

}  // namespace

template <class Real>
Subdomain<Real> restrict_to(std::span<const std::uint8_t> moving, const System<Real>& whole, std::span<const Real> u,
                            const Multipliers& multipliers) {
  Subdomain<Real> part;
  part.cells = cells_around(moving, whole.lattice());
  part.nodes = corners_of(part.cells, whole.lattice());
  part.lattice = std::make_unique<const Lattice>(lattice_of(part.cells, part.nodes, whole.lattice()));
  for (const std::int32_t node : part.nodes) {
    const auto n = static_cast<std::size_t>(node);
    part.moves.push_back(moving[n] && whole.is_free(n));
    for (std::size_t i = 3 * n; i < 3 * n + 3; ++i) part.u.push_back(u[i]);
  }
  const typename System<Real>::Place place{part.cells, part.nodes, part.moves};
  part.system = whole.restricted(*part.lattice, place, u);
  part.multipliers = whole.restricted(multipliers, *part.system, place);
  return part;
}

template <class Real>
void Subdomain<Real>::write_back(std::span<Real> whole_u) const {
  for (std::size_t n = 0; n < nodes.size(); ++n)
    for (std::size_t i = 0; i < 3; ++i) whole_u[3 * static_cast<std::size_t>(nodes[n]) + i] = u[3 * n + i];
}

template <class Real>
void Subdomain<Real>::write_back(std::span<Real> whole_u, Multipliers& whole_multipliers) const {
  write_back(whole_u);
  for (const PointConstraint& constraint : system->point_constraints())
    if (constraint.exact) whole_multipliers.of_constraint[constraint.id] = multipliers.of(constraint);
  if (multipliers.of_held_node.empty()) return;
  for (std::size_t n = 0; n < nodes.size(); ++n)
    for (std::size_t i = 0; i < 3; ++i)
      whole_multipliers.of_held_node[3 * static_cast<std::size_t>(nodes[n]) + i] = multipliers.of_held_node[3 * n + i];
}

template struct Subdomain<float>;
template struct Subdomain<double>;
template Subdomain<float> restrict_to<float>(std::span<const std::uint8_t>, const System<float>&,
                                             std::span<const float>, const Multipliers&);
template Subdomain<double> restrict_to<double>(std::span<const std::uint8_t>, const System<double>&,
                                               std::span<const double>, const Multipliers&);

}  // namespace lappet
