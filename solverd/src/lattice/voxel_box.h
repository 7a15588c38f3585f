// The box of coarse cells and fine voxels around a tissue, and its integer coordinates.
//
// Notation: h cell edge, r voxels per cell edge, voxel centre i at (i + 1/2) h/r from the box corner. Points are
// rounded to kSteps steps per voxel, so that every predicate downstream is exact in integers.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

namespace lappet {

inline constexpr int kStepBits = 14;
inline constexpr std::int64_t kSteps = std::int64_t{1} << kStepBits;  // integer steps per voxel edge
// Coordinates stay below 2^30 steps: edge functions then fit 64 bits, plane functions 128.
inline constexpr std::int64_t kMostVoxelsPerAxis = (std::int64_t{1} << 30) / kSteps;

using Voxel = std::array<std::int32_t, 3>;      // relative to the box
using StepPoint = std::array<std::int64_t, 3>;  // steps, relative to the box

struct VoxelBox {
  std::array<std::int32_t, 3> low{};    // grid coordinates of the first cell (may be negative)
  std::array<std::int32_t, 3> cells{};  // extent, cells
  std::int32_t ratio = 1;

  std::int32_t voxels(int axis) const { return cells[axis] * ratio; }
  std::int64_t cell_count() const { return std::int64_t{cells[0]} * cells[1] * cells[2]; }
  // z runs fastest.
  std::int64_t cell_index(std::int32_t x, std::int32_t y, std::int32_t z) const {
    return (std::int64_t{x} * cells[1] + y) * cells[2] + z;
  }
  bool contains(const Voxel& voxel) const {
    for (std::size_t a = 0; a < 3; ++a)
      if (voxel[a] < 0 || voxel[a] >= voxels(static_cast<int>(a))) return false;
    return true;
  }
};

}  // namespace lappet
