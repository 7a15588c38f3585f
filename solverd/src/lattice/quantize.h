// A surface checked, and its points rounded to the integer steps that every later decision is made on.
#pragma once
#include <vector>

#include "lattice/lattice.h"
#include "lattice/surface.h"
#include "lattice/voxel_box.h"

namespace lappet {

// Throws RefusedError(kInvalidInput) for settings that make no sense, an empty surface, points that are not finite and
// triangles that name no point.
void check_input(const Surface& surface, const LatticeSettings& settings);

// The points in steps relative to the box that holds them.
struct Quantized {
  VoxelBox box;
  std::vector<StepPoint> points;
};

// Throws RefusedError(kInvalidInput) where the surface lies too far from the origin for integers of this spacing.
Quantized quantize(const Surface& surface, const LatticeSettings& settings);

}  // namespace lappet
