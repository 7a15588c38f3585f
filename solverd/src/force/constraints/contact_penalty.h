// Contact penalties: what pushes the tissue at the last evaluated state, for the tangent. Each pushes a point inside a
// cell along a direction.
#pragma once
#include <array>
#include <cstdint>

#include "lattice/surface.h"

namespace lappet {

// In the tangent: stiffness/2 (direction . sum_k weights_k du_k)^2 over the cell's nodes.
struct ContactPenalty {
  Index cell;
  std::array<double, 8> weights;
  Vec3 direction;
  double stiffness;  // mN/mm
};

}  // namespace lappet
