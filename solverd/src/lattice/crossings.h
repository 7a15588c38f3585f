// Where the surface crosses the lines through voxel centers: exact scan conversion along x, y and z.
//
// All voxel centers are moved by one infinitesimal vector (e_x, e_y, e_z), e_x >> e_y >> e_z > 0 (simulation of
// simplicity, Edelsbrunner and Mücke 1990). No line then meets an edge or a vertex, no center lies on a triangle, and
// the lines of all three axes pass through the same moved centers: so the winding numbers along x, y and z agree
// exactly, and a walk from center to center cannot slip through the surface, not even where walls coincide or pass
// through centers.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lattice/interrupt.h"
#include "lattice/voxel_box.h"

namespace lappet {

struct Crossing {
  Voxel lower;             // the voxel below the crossing, -1 along `axis` where that is outside the box
  std::uint16_t fraction;  // steps above the lower center, rounded down, in [0, kSteps)
  std::int8_t winding;     // change of the winding number along +axis: +1 enters the tissue, -1 leaves it
  std::uint8_t axis;
};

struct Crossings {
  std::vector<std::int64_t> first;  // per triangle, and one past the last: its part of `all`
  std::vector<Crossing> all;
};

// Twice the area vector of a triangle, in steps^2: outward for an outward-oriented surface.
std::array<std::int64_t, 3> area_vector(const StepPoint& a, const StepPoint& b, const StepPoint& c);

// How many crossings each triangle has, as offsets (`Crossings::first`); nothing else is allocated.
std::vector<std::int64_t> count_crossings(std::span<const StepPoint> points,
                                          std::span<const std::array<Index, 3>> triangles, const VoxelBox& box,
                                          const Interrupt& interrupt = {});

// The crossings themselves, given those offsets. The order is by triangle, axis, line: the same for any thread count.
Crossings find_crossings(std::span<const StepPoint> points, std::span<const std::array<Index, 3>> triangles,
                         const VoxelBox& box, std::vector<std::int64_t> first, const Interrupt& interrupt = {});

}  // namespace lappet
