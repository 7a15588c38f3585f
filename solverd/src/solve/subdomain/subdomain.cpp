#include "solve/subdomain/subdomain.h"

#include <algorithm>

namespace lappet {

template <class Real>
Subdomain<Real>::Subdomain(const System<Real>& whole, std::span<const std::uint8_t> moving,
                           std::span<const Real> whole_u) {
  const Lattice& all = whole.lattice();
  lattice.settings = all.settings;
  lattice.node_rest = RestPositions(all.settings.origin, all.settings.spacing);
  std::vector<std::uint8_t> held(all.node_rest.size(), 0);
  for (std::size_t c = 0; c < all.cell_nodes.size(); ++c) {
    const auto& corners = all.cell_nodes[c];
    if (std::ranges::none_of(corners, [&](std::int32_t n) { return moving[static_cast<std::size_t>(n)] != 0; }))
      continue;
    cells.push_back(static_cast<std::int32_t>(c));
    lattice.cell_fill.push_back(all.cell_fill[c]);
    for (const std::int32_t n : corners) held[static_cast<std::size_t>(n)] = 1;
  }
  std::vector<std::int32_t> place(all.node_rest.size(), -1);
  for (std::size_t n = 0; n < held.size(); ++n) {
    if (!held[n]) continue;
    place[n] = static_cast<std::int32_t>(nodes.size());
    nodes.push_back(static_cast<std::int32_t>(n));
    moves.push_back(moving[n] && whole.is_free(n));
    lattice.node_rest.push_back(all.node_rest.grid_point(n));
    for (std::size_t i = 3 * n; i < 3 * n + 3; ++i) u.push_back(whole_u[i]);
  }
  for (const std::int32_t cell : cells) {
    auto corners = all.cell_nodes[static_cast<std::size_t>(cell)];
    for (std::int32_t& n : corners) n = place[static_cast<std::size_t>(n)];
    lattice.cell_nodes.push_back(corners);
  }
  system = System<Real>::restrict_to(whole, lattice, cells, nodes, moves, whole_u);
}

template <class Real>
void Subdomain<Real>::write_back(std::span<Real> whole_u) const {
  for (std::size_t n = 0; n < nodes.size(); ++n)
    for (std::size_t i = 0; i < 3; ++i) whole_u[3 * static_cast<std::size_t>(nodes[n]) + i] = u[3 * n + i];
}

template struct Subdomain<float>;
template struct Subdomain<double>;

}  // namespace lappet
