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
  std::unique_ptr<const Lattice> lattice;  // the system refers to it
  std::vector<std::int32_t> cells, nodes;  // their indices in the whole
  std::vector<std::uint8_t> moves;         // per node: it moves, and is free
  std::vector<Real> u;
  Multipliers multipliers;
  std::unique_ptr<System<Real>> system;

  void write_back(std::span<Real> whole_u) const;
  // With the multipliers of held nodes and point constraints; contact keeps those of the whole.
  void write_back(std::span<Real> whole_u, Multipliers& whole_multipliers) const;
};

// moving: per node of the whole, whether it moves; u, multipliers: of the whole. The result refers to none of them.
template <class Real>
Subdomain<Real> restrict_to(std::span<const std::uint8_t> moving, const System<Real>& whole, std::span<const Real> u,
                            const Multipliers& multipliers);

extern template struct Subdomain<float>;
extern template struct Subdomain<double>;

}  // namespace lappet
