#include "force/materials/cell_fill.h"

#include <span>

#include "lattice/voxelize.h"

namespace lappet {

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
    int count = 0;
    Vec3 first = Vec3::Zero(), second = Vec3::Zero();
  } moments[kSamples];
  for (std::int32_t i = 0; i < r * r * r; ++i) {
    const Voxel local{i / (r * r), i / r % r, i % r};
    if (fine.lattice_cell({at[0] * r + local[0], at[1] * r + local[1], at[2] * r + local[2]}) != to_index(cell))
      continue;
    std::size_t eighth = 0;
    Vec3 x;
    for (std::size_t a = 0; a < 3; ++a) {
      eighth = 2 * eighth + (2 * local[a] + 1 < r ? 0 : 1);
      x[a] = (2.0 * local[a] + 1.0) / r - 1.0;
    }
    ++moments[eighth].count;
    moments[eighth].first += x;
    moments[eighth].second += x.cwiseAbs2();
  }
  std::size_t count = 0;
  for (const Moments& m : moments) {
    if (m.count == 0) continue;
    const Vec3 center = m.first / m.count;
    const Vec3 variance = m.second / m.count - center.cwiseAbs2() + Vec3::Constant(kFullVariance / (r * r));
    found[count++] = {double(m.count) / (r * r * r), center, (12.0 * variance).cwiseMax(0.0).cwiseSqrt()};
  }
  return count;
}

MaterialShare share_of_moments(std::size_t cell, std::uint8_t material, double part, double volume, const Vec3& first,
                               const Vec3& second) {
  const Vec3 center = first / volume;
  const Vec3 variance = (second / volume - center.cwiseAbs2()).cwiseMax(0.0) / kFullVariance;
  return {to_index(cell), material, float(part), center.cast<float>(),
          variance.cwiseSqrt().cwiseMin(1.0).cast<float>()};
}

std::optional<MaterialShare> share_of_fill(const Lattice& lattice, std::size_t cell, std::uint8_t material) {
  std::array<TissueSample, 8> found;
  const std::size_t count = tissue_samples(lattice, cell, found);
  double volume = 0.0;
  Vec3 first = Vec3::Zero(), second = Vec3::Zero();
  for (const TissueSample& sample : std::span(found).first(count)) {
    volume += sample.volume;
    first += sample.volume * sample.center;
    second += sample.volume * (sample.center.cwiseAbs2() + sample.edges.cwiseAbs2() / 12.0);
  }
  if (!(volume > 0.0) || volume > 1.0 - 1e-9) return {};
  return share_of_moments(cell, material, 1.0, volume, first, second);
}

}  // namespace lappet
