#include "lattice/tissue_samples.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <span>

#include "lattice/voxelize.h"

namespace lappet {

namespace {

// A cell whose tissue differs from a whole one's by less than that is whole: it need not be told apart.
constexpr double kWhole = 1e-3;

// The tissue of a voxel as a box, in voxels from its center.
struct VoxelBounds {
  Vec3 low = Vec3::Constant(-0.5), high = Vec3::Constant(0.5);
};

}  // namespace

std::size_t tissue_samples(const Lattice& lattice, std::size_t cell, std::array<TissueSample, 8>& found) {
  constexpr std::size_t kSamples = 8;
  const FineVoxels& fine = *lattice.fine;
  const std::int32_t r = fine.box().ratio;
  const GridPoint& position = lattice.cell_position(cell);
  Voxel at;
  for (std::size_t a = 0; a < 3; ++a) at[a] = position[a] - fine.box().low[a];
  const Index place = fine.occupied_at(at[0], at[1], at[2]);
  if (r == 1 || place < 0 || fine.is_whole(place)) {
    for (std::size_t k = 0; k < kSamples; ++k)
      found[k] = {1.0 / kSamples, Vec3(k & 4 ? 0.5 : -0.5, k & 2 ? 0.5 : -0.5, k & 1 ? 0.5 : -0.5), Vec3::Ones()};
    return kSamples;
  }
  struct Moments {
    double volume = 0.0;
    Vec3 first = Vec3::Zero(), second = Vec3::Zero();
  } moments[kSamples];
  const std::span<const VoxelReach> reaches = fine.reaches(place);
  auto reach = reaches.begin();
  const double voxel = 2.0 / r;
  for (std::int32_t i = 0; i < r * r * r; ++i) {
    VoxelBounds bounds;
    for (; reach != reaches.end() && reach->voxel() == i; ++reach)
      if (reach->is_upper())
        bounds.high[reach->axis()] += double(reach->beyond);
      else
        bounds.low[reach->axis()] -= double(reach->beyond);
    const Voxel local{i / (r * r), i / r % r, i % r};
    if (fine.lattice_cell({at[0] * r + local[0], at[1] * r + local[1], at[2] * r + local[2]}) != to_index(cell))
      continue;
    std::size_t eighth = 0;
    Vec3 x;
    for (std::size_t a = 0; a < 3; ++a) {
      eighth = 2 * eighth + (2 * local[a] + 1 < r ? 0 : 1);
      x[a] = (2.0 * local[a] + 1.0) / r - 1.0;
    }
    const Vec3 edges = (voxel * (bounds.high - bounds.low)).cwiseMax(0.0);
    x += 0.5 * voxel * (bounds.low + bounds.high);
    const double volume = edges.prod() / 8.0;
    moments[eighth].volume += volume;
    moments[eighth].first += volume * x;
    moments[eighth].second += volume * (x.cwiseAbs2() + edges.cwiseAbs2() / 12.0);
  }
  std::size_t count = 0;
  for (const Moments& m : moments) {
    if (!(m.volume > 0.0)) continue;
    const Vec3 center = m.first / m.volume;
    const Vec3 variance = m.second / m.volume - center.cwiseAbs2();
    found[count++] = {m.volume, center, (12.0 * variance).cwiseMax(0.0).cwiseSqrt()};
  }
  return count;
}

void measure_fill(Lattice& lattice, const Interrupt& interrupt) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, lattice.cells(), 256), [&](const auto& range) {
    interrupt.check();
    std::array<TissueSample, 8> found;
    for (std::size_t cell = range.begin(); cell != range.end(); ++cell) {
      double volume = 0.0;
      for (const TissueSample& sample : std::span(found).first(tissue_samples(lattice, cell, found)))
        volume += sample.volume;
      const bool whole = std::abs(volume - 1.0) < kWhole;
      lattice.cell_fill[cell] = whole ? 1.0F : float(std::max(volume, lattice.settings.fill_floor));
    }
  });
}

}  // namespace lappet
