#include "force/materials/cell_fill.h"

#include <array>
#include <span>

#include "lattice/tissue_samples.h"

namespace lappet {

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
  if (!(volume > 0.0) || lattice.cell_fill[cell] == 1.0F) return {};
  return share_of_moments(cell, material, 1.0, volume, first, second);
}

}  // namespace lappet
