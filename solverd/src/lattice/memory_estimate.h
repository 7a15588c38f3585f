// How large a lattice will be, known from the surface alone before anything is allocated.
#pragma once
#include <cstddef>

#include "lattice/lattice.h"
#include "lattice/surface.h"

namespace lappet {

struct SurfaceMeasure {
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  // mm
  Vec3 projected_area = Vec3::Zero();            // sum over triangles of |area seen along x, y, z|, mm^2
  double volume = 0.0;                           // signed: positive where triangles face outwards, mm^3
};

SurfaceMeasure measure(const Surface& surface);

// Bytes at the peak of building the lattice: the map of the box, the crossings of the surface with the lines of voxel
// centers, masks of the cells that the surface touches, and what a cell and its nodes need.
double estimate_bytes(const SurfaceMeasure& measure, double spacing, int fine_ratio);

// Throws RefusedError(kMemoryBudget) where the estimate exceeds settings.memory_budget; the sentence names the size and
// the spacing or ratio that would fit.
void check_memory(const SurfaceMeasure& measure, const LatticeSettings& settings);

}  // namespace lappet
