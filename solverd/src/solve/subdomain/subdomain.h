// A subdomain of a system as a system of its own: nodes that move, and the cells around them. The other nodes of those
// cells stay where they are, unless a retractor carries them.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "solve/system/system.h"

namespace lappet {

template <class Real>
struct Subdomain {
  // moving: per node of the whole; u: of the whole. Keeps no reference to it.
  Subdomain(const System<Real>& whole, std::span<const std::uint8_t> moving, std::span<const Real> whole_u);
  Subdomain(const Subdomain&) = delete;
  Subdomain& operator=(const Subdomain&) = delete;

  void write_back(std::span<Real> whole_u) const;

  Lattice lattice;
  std::vector<std::int32_t> cells, nodes;  // their indices in the whole
  std::vector<std::uint8_t> moves;         // per node: it moves, and is free
  std::vector<Real> u;
  std::unique_ptr<System<Real>> system;
};

extern template struct Subdomain<float>;
extern template struct Subdomain<double>;

}  // namespace lappet
