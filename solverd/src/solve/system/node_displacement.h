// One node's three of the numbers that a field of displacements has.
#pragma once
#include <cstddef>
#include <span>

#include "lattice/surface.h"

namespace lappet {

template <class Real>
Vec3 node_displacement(std::span<const Real> u, std::size_t node) {
  return {static_cast<double>(u[3 * node]), static_cast<double>(u[3 * node + 1]), static_cast<double>(u[3 * node + 2])};
}

}  // namespace lappet
