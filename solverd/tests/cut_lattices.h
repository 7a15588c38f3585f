// Lattices of slabs with random cuts, longest in x, y or z, for tests that must hold on every lattice.
#pragma once
#include <ostream>
#include <random>
#include <string>
#include <vector>

#include "force/elastic/block_layout.h"
#include "force/kernels/cell_corners.h"
#include "lattice/lattice.h"
#include "test_surfaces.h"

namespace lappet::test {

struct CutLattice {
  int axis;       // the longest one
  unsigned seed;  // of the cuts
};
inline void PrintTo(const CutLattice& cut, std::ostream* out) { *out << "axis " << cut.axis << ", seed " << cut.seed; }
inline std::string name(const CutLattice& cut) {
  return std::string(1, "xyz"[cut.axis]) + "Seed" + std::to_string(cut.seed);
}

inline const std::vector<CutLattice> kCutLattices = {{0, 1}, {0, 2}, {1, 3}, {1, 4}, {2, 5}, {2, 6}};

// A slab of 21 x 9 x 5, or its like along another axis, with two incisions of no width that end inside and one that
// separates its end; the incisions' walls are jagged.
inline Lattice make_lattice(const CutLattice& cut) {
  std::mt19937 random(cut.seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const double length = 21.0, depth = 9.0, height = 5.0, kerf = 1e-3;
  // Incisions from the side at y = 0: notches of the outline, a hair wide.
  std::vector<Eigen::Vector2d> outline{{0.0, 0.0}};
  for (const double middle : {5.0, 11.0}) {
    std::vector<Eigen::Vector2d> line;
    const int steps = 2 + int(3 * unit(random));
    double x = middle + 2 * unit(random) - 1;
    for (int k = 0; k <= steps; ++k) {
      line.emplace_back(x, (depth - 2.3) * k / steps);
      x += 1.6 * unit(random) - 0.8;
    }
    for (std::size_t k = 0; k + 1 < line.size(); ++k) outline.emplace_back(line[k].x() - kerf, line[k].y());
    outline.push_back(line.back());
    for (std::size_t k = line.size() - 1; k-- > 0;) outline.emplace_back(line[k].x() + kerf, line[k].y());
  }
  std::vector<Eigen::Vector2d> through;
  double x = 16.0 + unit(random);
  for (int k = 0; k <= 3; ++k) {
    through.emplace_back(x, depth * k / 3.0);
    x += 1.6 * unit(random) - 0.8;
  }
  for (const auto& p : through) outline.emplace_back(p.x() - kerf, p.y());
  outline.emplace_back(0.0, depth);
  std::vector<Eigen::Vector2d> end;
  for (auto p = through.rbegin(); p != through.rend(); ++p) end.emplace_back(p->x() + kerf, p->y());
  end.emplace_back(length, 0.0);
  end.emplace_back(length, depth);
  Surface surface = prism(outline, 0.0, height);
  append(surface, prism(end, 0.0, height));
  for (Vec3& p : surface.points) {
    Vec3 turned;  // cyclic: orientation stays
    for (int i = 0; i < 3; ++i) turned[(i + cut.axis) % 3] = p[i];
    p = turned;
  }
  LatticeSettings settings;
  settings.spacing = 1.0;
  settings.fine_ratio = 4;
  return build_lattice(surface, settings);
}

// Node n (of 27) of a lane's block.
inline std::int32_t node_of(const BlockLayout& layout, std::size_t group, std::size_t n, std::size_t lane) {
  const std::size_t w = layout.lanes, start = static_cast<std::size_t>(layout.node_start[group]);
  const bool grid = static_cast<std::size_t>(layout.node_start[group + 1]) - start == 9 * w;
  return grid ? layout.nodes[start + n / 3 * w + lane] + to_index(n % 3) : layout.nodes[start + n * w + lane];
}

}  // namespace lappet::test
