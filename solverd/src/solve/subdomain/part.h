// A part of a system as a system of its own: nodes that move, and the cells around them. The other nodes of those cells
// stay where they are, unless a retractor carries them.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "solve/system/system.h"

namespace lappet {

template <class Real>
struct Part {
  // moving: per node of the whole; u: of the whole. Keeps no reference to it.
  Part(const System<Real>& whole, std::span<const std::uint8_t> moving, std::span<const Real> whole_u);
  Part(const Part&) = delete;
  Part& operator=(const Part&) = delete;

  void put_back(std::span<Real> whole_u) const;

  Lattice lattice;
  std::vector<std::int32_t> cells, nodes;  // their indices in the whole
  std::vector<std::uint8_t> moves;         // per node: it moves, and is free
  std::vector<Real> u;
  std::unique_ptr<System<Real>> system;
};

extern template struct Part<float>;
extern template struct Part<double>;

}  // namespace lappet
