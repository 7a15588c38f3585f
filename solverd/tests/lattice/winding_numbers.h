// Winding numbers of all voxels along the lines of one axis, box order with z fastest. All three axes must agree.
#pragma once
#include <cstdint>
#include <vector>

#include "lattice/center_lines.h"
#include "lattice/crossings.h"
#include "lattice/quantize.h"

namespace lappet::test {

inline std::vector<std::int8_t> winding_numbers(const Surface& surface, const LatticeSettings& settings,
                                                std::size_t axis) {
  const Quantized quantized = quantize(surface, settings);
  const VoxelBox& box = quantized.box;
  const Crossings crossings = find_crossings(quantized.points, surface.triangles, box,
                                             count_crossings(quantized.points, surface.triangles, box));
  const std::size_t u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
  const std::size_t x = box.voxels(0), y = box.voxels(1), z = box.voxels(2), width = box.voxels(v);
  const CenterLines lines(crossings, axis, box);
  std::vector<std::int8_t> result(x * y * z);
  for (std::size_t line = 0; line < lines.count(); ++line)
    lines.walk(
        line,
        [&](std::int32_t from, std::int32_t to, int winding) {
          std::array<std::size_t, 3> at{};
          at[u] = line / width;
          at[v] = line % width;
          for (at[axis] = from; at[axis] < std::size_t(to); ++at[axis])
            result[(at[0] * y + at[1]) * z + at[2]] = std::int8_t(winding);
        },
        kIgnoreSegment);
  return result;
}

}  // namespace lappet::test
