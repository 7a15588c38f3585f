// How far two primitives may go along straight ways before they come near each other: conservative advancement. Along
// the direction of their closest points they are apart by the whole distance, and how that falls is known for each pair
// of their points, so they may go on until little of it is left; there the next direction is found. Whatever slides
// along or goes away is told in one step. It takes nothing but distances, so rounding does not let a contact pass. No
// step is shorter than that of additive continuous collision detection (Li, Kaufman, Jiang 2021, "Codimensional
// Incremental Potential Contact", alg. 1), which bounds how the distance falls by all of the motion.
#pragma once
#include <array>

#include "lattice/surface.h"

namespace lappet {

// Of the distance at the start, what is left all the way at least.
inline constexpr double kDistanceKept = 0.2;
// The way ends nearer than this many times what is to be kept.
inline constexpr double kWayEnds = 1.1;

// The share of the way, `most` at most. at, way: of the point and the corners of the triangle; enough: a distance in mm
// that is never too little.
double point_triangle_way(const std::array<Vec3, 4>& at, const std::array<Vec3, 4>& way, double most, double enough);
// Of the ends of one segment and of the other.
double segments_way(const std::array<Vec3, 4>& at, const std::array<Vec3, 4>& way, double most, double enough);

}  // namespace lappet
