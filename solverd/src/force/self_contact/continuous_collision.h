// How far two primitives may go along straight ways before they come near each other: additive continuous collision
// detection (Li, Kaufman, Jiang 2021, "Codimensional Incremental Potential Contact", alg. 1). From a distance d the
// primitives may move by d in all against each other; steps of a little less are added up until what is left of the
// distance at the start would fall below a share. It takes nothing but distances, so rounding does not let a contact
// pass.
#pragma once
#include <array>

#include "lattice/surface.h"

namespace lappet {

// Of the distance at the start, what is left where the way ends early at least; on the way, no less than half of it.
inline constexpr double kDistanceKept = 0.2;

// The share of the way, `most` at most. at, way: of the point and the corners of the triangle.
double point_triangle_way(std::array<Vec3, 4> at, std::array<Vec3, 4> way, double most);
// Of the ends of one segment and of the other.
double segments_way(std::array<Vec3, 4> at, std::array<Vec3, 4> way, double most);

}  // namespace lappet
