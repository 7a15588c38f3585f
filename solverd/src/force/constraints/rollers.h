// Rollers: faces that slide in their plane, as those in a plane of symmetry do. Each row demands that what it holds
// does not move along a direction, sum_k weights_k u_k . normal = 0: the four nodes of a face on a lattice plane, one
// each; elsewhere the surface points of the face in a cell, through the roots of the same form that holds a fixed face
// (force/constraints/attachments.h).
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lattice/lattice.h"

namespace lappet {

struct RollerRow {
  Index cell;
  Index roller;
  Vec3 normal;  // unit
  std::array<double, 8> weights;
};

// Per triangle: the roller that it rolls on, or -1. normals: of each roller; zero: that of each face of it.
std::vector<RollerRow> roller_rows(const Lattice& lattice, const Surface& surface, std::span<const Index> roller,
                                   std::span<const Vec3> normals, const Interrupt& interrupt = {});

}  // namespace lappet
