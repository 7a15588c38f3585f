// The box of coarse cells and fine voxels around a tissue, and its integer coordinates.
//
// Notation: h cell edge, r voxels per cell edge, voxel center i at (i + 1/2) h/r from the box corner. Points are
// rounded to kSteps steps per voxel, so that every predicate downstream is exact in integers.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "math/index.h"

namespace lappet {

inline constexpr int kStepBits = 14;
inline constexpr std::int64_t kSteps = std::int64_t{1} << kStepBits;  // integer steps per voxel edge
// Coordinates stay below 2^30 steps: edge functions then fit 64 bits, plane functions 128.
inline constexpr std::int64_t kMaxVoxelsPerAxis = (std::int64_t{1} << 30) / kSteps;

using Voxel = std::array<std::int32_t, 3>;  // relative to the box

// A voxel of a box, or none, {-1, -1, -1}, in half the memory: a box has fewer than 2^16 voxels along an axis.
class PackedVoxel {
 public:
  PackedVoxel() = default;
  explicit PackedVoxel(const Voxel& voxel)
      : at_{std::uint16_t(voxel[0]), std::uint16_t(voxel[1]), std::uint16_t(voxel[2])} {}
  operator Voxel() const {
    if ((at_[0] & at_[1] & at_[2]) == kNone) return {-1, -1, -1};
    return {at_[0], at_[1], at_[2]};
  }

 private:
  static constexpr std::uint16_t kNone = 0xFFFF;
  std::uint16_t at_[3]{kNone, kNone, kNone};
};

using StepPoint = std::array<std::int64_t, 3>;  // steps, relative to the box

struct VoxelBox {
  std::array<std::int32_t, 3> low{};    // grid coordinates of the first cell (may be negative)
  std::array<std::int32_t, 3> cells{};  // extent, cells
  std::int32_t ratio = 1;

  std::int32_t voxels(std::size_t axis) const { return cells[axis] * ratio; }
  std::int64_t cell_count() const { return std::int64_t{cells[0]} * cells[1] * cells[2]; }
  // z runs fastest.
  std::int64_t cell_index(std::int32_t x, std::int32_t y, std::int32_t z) const {
    return (std::int64_t{x} * cells[1] + y) * cells[2] + z;
  }
  // The cell that a voxel lies in, and its place there.
  Voxel cell_of(const Voxel& voxel) const { return {voxel[0] / ratio, voxel[1] / ratio, voxel[2] / ratio}; }
  Voxel place_in(const Voxel& cell, const Voxel& voxel) const {
    return {voxel[0] - cell[0] * ratio, voxel[1] - cell[1] * ratio, voxel[2] - cell[2] * ratio};
  }
  // The voxel that holds a point, given in voxels; of a point far outside the box one outside it.
  template <class Point>
  Voxel voxel_at(const Point& point) const {
    Voxel voxel;
    for (std::size_t a = 0; a < 3; ++a)
      voxel[a] = std::int32_t(std::clamp(std::floor(double(point[a])), -2.0, voxels(a) + 1.0));
    return voxel;
  }
  bool contains(const Voxel& voxel) const {
    for (std::size_t a = 0; a < 3; ++a)
      if (voxel[a] < 0 || voxel[a] >= voxels(a)) return false;
    return true;
  }
};

}  // namespace lappet
