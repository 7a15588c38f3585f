// The box around a surface, and how far from the origin a coordinate may be.
#pragma once
#include <Eigen/Geometry>

#include "lattice/surface.h"

namespace lappet {

// Of every coordinate that a session is given, mm: a hundred kilometers, far beyond any tissue, while squares, cubes
// and their products are still numbers.
inline constexpr double kMaxCoordinate = 1e8;

using Box3 = Eigen::AlignedBox3d;

inline Box3 box_around(const Surface& surface) {
  Box3 box;
  for (const Vec3& point : surface.points) box.extend(point);
  return box;
}

}  // namespace lappet
