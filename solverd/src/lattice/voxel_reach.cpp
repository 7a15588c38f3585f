// How far the tissue of the voxels along the surface reaches.
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "lattice/fine_voxels_builder.h"

namespace lappet {

namespace {

// Less is what points are rounded by: the surface lies on the face.
constexpr double kMinReach = 4.0 / double(kSteps);

}  // namespace

void FineVoxels::Builder::measure_reaches(std::span<const StepPoint> points,
                                          std::span<const std::array<Index, 3>> triangles) {
  const std::size_t blocks = out.label_first_.size();
  // Calls body(block, reach) for every face of an inside voxel that the surface does not lie on.
  const auto each_reach = [&](const auto& body) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, triangles.size(), 64), [&](const auto& range) {
      interrupt.check();
      for (std::size_t t = range.begin(); t != range.end(); ++t) {
        const auto& [a, b, c] = triangles[t];
        const auto area = area_vector(points[a], points[b], points[c]);
        double squares = 0.0;
        for (const std::int64_t part : area) squares += double(part) * double(part);
        for (std::int64_t i = crossings.first[t]; i < crossings.first[t + 1]; ++i) {
          const Crossing& crossing = crossings.all[i];
          const Voxel inner = out.inner_[i];
          if (inner[0] < 0) continue;
          const double height = double(crossing.fraction) / double(kSteps);
          const bool upper = crossing.winding < 0;
          const auto along = double(area[crossing.axis]);
          const double beyond = along * along / squares * (upper ? height - 0.5 : 0.5 - height);
          if (std::abs(beyond) < kMinReach) continue;
          const Voxel cell = out.box_.cell_of(inner);
          const std::size_t bit = out.bit(out.box_.place_in(cell, inner));
          body(out.block_[place(cell)],
               VoxelReach{std::uint32_t(6 * bit + 2 * crossing.axis + (upper ? 1 : 0)), float(beyond)});
        }
      }
    });
  };
  std::vector<std::int64_t> count(blocks + 1, 0);
  each_reach([&](Index block, const VoxelReach&) {
    std::atomic_ref(count[block + 1]).fetch_add(1, std::memory_order_relaxed);
  });
  for (std::size_t block = 0; block < blocks; ++block) count[block + 1] += count[block];
  out.reach_first_ = count;
  out.reach_.resize(count.back());
  each_reach([&](Index block, const VoxelReach& reach) {
    out.reach_[std::atomic_ref(count[block]).fetch_add(1, std::memory_order_relaxed)] = reach;
  });
  tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t block) {
    std::sort(out.reach_.begin() + out.reach_first_[block], out.reach_.begin() + out.reach_first_[block + 1],
              [](const VoxelReach& a, const VoxelReach& b) { return a.face < b.face; });
  });
}

}  // namespace lappet
