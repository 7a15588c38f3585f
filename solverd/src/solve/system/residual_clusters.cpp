#include "solve/system/residual_clusters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "math/parallel.h"

namespace lappet {

namespace {

constexpr std::int32_t kEdge = 8;  // cells
// A cluster bears as large a residual as a patch of so many clusters with forces like its own.
constexpr double kPatch = 25.0;
// The least force scale, as a stress of this many Young's moduli of the softest material there on every node.
constexpr double kScaleFloor = 1e-2;

// The mean square of the force at a node to which the displacements' rounding amounts, over the square of the
// oedometric modulus times spacing, by the largest displacement around. A rounding is spread evenly over one unit in
// the last place, and the rows of the stiffness of cells with one point each have a 2-norm of 1.015 lambda h: the
// products of (-1, 2, -1), (1, 2, 1), (1, 2, 1) / 16 along the axes, and of those that couple them. Three components.
template <class Real>
double rounding(double displacement) {
  const double unit = double(std::numeric_limits<Real>::epsilon()) * displacement;
  return 3.0 * unit * unit / 12.0;
}

}  // namespace

ResidualClusters::ResidualClusters(const Lattice& lattice, const CellMaterials& materials,
                                   std::span<const std::int32_t> fragment_of_node) {
  const std::size_t nodes = lattice.node_rest.size();
  const auto place = [&](std::int32_t n) {
    const GridPoint& at = lattice.node_rest.grid_point(static_cast<std::size_t>(n));
    const auto tile = [](std::int32_t i) { return (i >= 0 ? i : i - kEdge + 1) / kEdge; };
    return std::array<std::int32_t, 4>{fragment_of_node.empty() ? 0 : fragment_of_node[static_cast<std::size_t>(n)],
                                       tile(at[0]), tile(at[1]), tile(at[2])};
  };
  std::vector<std::array<std::int32_t, 4>> places(nodes);
  for (std::size_t n = 0; n < nodes; ++n) places[n] = place(static_cast<std::int32_t>(n));
  nodes_.resize(nodes);
  std::iota(nodes_.begin(), nodes_.end(), 0);
  std::ranges::stable_sort(nodes_, {}, [&](std::int32_t n) { return places[static_cast<std::size_t>(n)]; });
  std::vector<std::size_t> cluster_of(nodes);
  for (std::size_t i = 0; i < nodes; ++i) {
    const auto n = static_cast<std::size_t>(nodes_[i]);
    if (i == 0 || places[n] != places[static_cast<std::size_t>(nodes_[i - 1])]) first_.push_back(i);
    cluster_of[n] = first_.size() - 1;
  }
  const double h = lattice.settings.spacing;
  force_floor_.assign(first_.size(), std::numeric_limits<double>::infinity());
  stiffness_.assign(first_.size(), std::numeric_limits<double>::infinity());
  first_.push_back(nodes);
  for (std::size_t c = 0; c < lattice.cell_nodes.size(); ++c) {
    const MaterialParameters& material = materials.of(c);
    const double floor = kScaleFloor * material.youngs_modulus * h * h;
    const double stiffness = (material.lambda() + 2.0 * material.mu()) * h;
    for (const std::int32_t n : lattice.cell_nodes[c]) {
      const std::size_t cluster = cluster_of[static_cast<std::size_t>(n)];
      force_floor_[cluster] = std::min(force_floor_[cluster], floor);
      stiffness_[cluster] = std::min(stiffness_[cluster], stiffness);
    }
  }
}

template <class Real>
ResidualNorms ResidualClusters::norms(std::span<const double> gradient, std::span<const double> scale,
                                      std::span<const std::uint8_t> free, std::span<const Real> u) const {
  const std::size_t clusters = force_floor_.size();
  struct Sums {
    double residual = 0.0, scale = 0.0, displacement = 0.0, rounded = 0.0;
    std::size_t count = 0;

    // What of the residual is not rounding.
    double true_residual() const { return rounded >= residual ? 0.0 : std::sqrt(residual - rounded); }
  };
  std::vector<Sums> sums(clusters);
  for_each_row(clusters, [&](std::size_t c) {
    Sums& own = sums[c];
    for (std::size_t k = first_[c]; k < first_[c + 1]; ++k) {
      const auto n = static_cast<std::size_t>(nodes_[k]);
      if (!free[n]) continue;
      const double* g = &gradient[3 * n];
      own.residual += g[0] * g[0] + g[1] * g[1] + g[2] * g[2];
      own.scale += scale[n] * scale[n];
      for (std::size_t i = 3 * n; i < 3 * n + 3; ++i)
        own.displacement = std::max(own.displacement, std::abs(double(u[i])));
      ++own.count;
    }
    own.rounded = static_cast<double>(own.count) * stiffness_[c] * stiffness_[c] * rounding<Real>(own.displacement);
  });
  Sums all;
  ResidualNorms norms;
  double floor = 0.0;
  for (std::size_t c = 0; c < clusters; ++c) {
    const Sums& own = sums[c];
    if (own.count == 0) continue;
    const double count = static_cast<double>(own.count), least = force_floor_[c] * std::sqrt(count);
    norms.relative = std::max(norms.relative, own.true_residual() / std::sqrt(kPatch) / (std::sqrt(own.scale) + least));
    all.residual += own.residual;
    all.rounded += own.rounded;
    all.scale += own.scale;
    all.count += own.count;
    floor += force_floor_[c] * force_floor_[c] * count;
  }
  norms.residual = std::sqrt(all.residual);
  norms.force_scale = std::sqrt(all.scale) + std::sqrt(floor);
  if (const double whole = all.true_residual() / norms.force_scale; all.count > 0 && !(whole <= norms.relative))
    norms.relative = whole;  // also where it is not a number
  return norms;
}

template ResidualNorms ResidualClusters::norms(std::span<const double>, std::span<const double>,
                                               std::span<const std::uint8_t>, std::span<const float>) const;
template ResidualNorms ResidualClusters::norms(std::span<const double>, std::span<const double>,
                                               std::span<const std::uint8_t>, std::span<const double>) const;

std::size_t ResidualClusters::bytes() const {
  return nodes_.size() * sizeof(std::int32_t) + first_.size() * sizeof(std::size_t) +
         (force_floor_.size() + stiffness_.size()) * sizeof(double);
}

}  // namespace lappet
