// A closed, outward-oriented triangle surface at rest (mm).
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "math/index.h"

namespace lappet {

using Vec3 = Eigen::Vector3d;

struct Surface {
  std::vector<Vec3> points;
  std::vector<std::array<Index, 3>> triangles;
};

}  // namespace lappet
