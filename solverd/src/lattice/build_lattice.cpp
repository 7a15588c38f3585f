// Surface -> voxels -> copies and links -> cells and nodes -> embedded surface.
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>

#include "lattice/embedding.h"
#include "lattice/lattice.h"
#include "lattice/memory_estimate.h"
#include "lattice/nonmanifold.h"
#include "lattice/refused.h"
#include "lattice/tissue_samples.h"
#include "lattice/voxelize.h"

namespace lappet {
namespace {

// Voxels that hold less than half or more than twice the tissue's volume do not represent it.
void check_volume(const Surface& surface, const LatticeSettings& settings, std::int64_t voxels) {
  const double edge = settings.spacing / settings.fine_ratio;
  const double wanted = measure(surface).volume, got = double(voxels) * edge * edge * edge;
  if (voxels > 0 && got > 0.5 * wanted && got < 2.0 * wanted) return;
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(),
                "The tissue is too thin for this lattice: its volume is %.4g mm^3, but the voxels of %.4g mm (spacing "
                "%.4g mm, fine ratio %d) hold %.4g mm^3; use a smaller spacing or thicker tissue.",
                wanted, edge, settings.spacing, settings.fine_ratio, got);
  throw RefusedError(ErrorCode::kInvalidInput, text.data());
}

}  // namespace

std::vector<GridPoint> Lattice::cell_positions() const {
  std::vector<GridPoint> positions(cells());
  for (std::size_t c = 0; c < positions.size(); ++c) positions[c] = cell_position(c);
  return positions;
}

double Lattice::volume() const {
  double cells = 0.0;
  for (const float fill : cell_fill) cells += double(fill);
  return cells * std::pow(settings.spacing, 3);
}

std::size_t Lattice::bytes() const {
  return cells() * (sizeof(cell_nodes[0]) + sizeof(cell_fill[0])) + node_rest.size() * sizeof(GridPoint) +
         surface_points.size() * sizeof(EmbeddedPoint) + (fine ? fine->bytes() : 0);
}

Lattice build_lattice(const Surface& surface, const LatticeSettings& settings, const Interrupt& interrupt) {
  Lattice lattice;
  lattice.settings = settings;
  auto fine = std::make_shared<FineVoxels>(surface, settings, interrupt);
  const auto links = find_links(*fine, interrupt);
  Fragments fragments = find_fragments(*fine, links);
  interrupt.check();
  lattice.dropped_voxels = drop_specks(*fine, fragments);
  interrupt.check();
  build_cells(*fine, links, fragments, lattice, interrupt);
  check_volume(surface, settings, lattice.fine_voxels);
  lattice.fine = std::move(fine);
  measure_fill(lattice, interrupt);
  lattice.surface_points = embed_surface(lattice, surface, interrupt);
  return lattice;
}

}  // namespace lappet
