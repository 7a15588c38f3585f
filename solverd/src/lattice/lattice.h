// The non-manifold lattice (GRIDiron §5, Algorithm 2): cubic cells of edge h that hold the tissue, one copy of a
// cell per connected fragment of tissue in it.
//
// Corner c of a cell at integer position p is the grid point p + (c>>2 & 1, c>>1 & 1, c & 1); its rest position is
// origin + h * that. Everything is decided on integers: two fine voxels are connected unless the segment between
// their centers crosses the surface, whatever the width of the cut.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "lattice/interrupt.h"
#include "lattice/rest_positions.h"
#include "lattice/surface.h"

namespace lappet {

struct LatticeSettings {
  double spacing = 1.0;                              // h, mm
  int fine_ratio = 4;                                // r: fine voxels per cell edge
  Vec3 origin = Vec3::Zero();                        // a grid point; the same for every epoch of a session
  double fill_floor = 0.1;                           // smallest volume fraction a cell carries
  std::size_t memory_budget = std::size_t{8} << 30;  // bytes; building refuses (throws) before exceeding it
};

// A point embedded in one fragment of one cell with trilinear weights (they may leave [0, 1] by a voxel at thin edges).
struct EmbeddedPoint {
  Index cell = -1;
  std::array<double, 8> weights{};
};

class FineVoxels;  // the rasterization behind a lattice, see voxelize.h

struct Lattice {
  LatticeSettings settings;
  std::vector<std::array<Index, 8>> cell_nodes;
  // Volume fraction, at least fill_floor; 1 where the tissue fills the cell. More where the surface lies beyond its
  // last voxels, by half a voxel at most, and no other cell begins there.
  std::vector<float> cell_fill;
  RestPositions node_rest;  // mm

  std::int64_t fine_voxels = 0;     // inside voxels
  std::int64_t dropped_voxels = 0;  // specks at sharp tips that the voxels do not hold together; the tissue around
                                    // carries their points
  std::int32_t grid_cells = 0;      // cells all of whose nodes have no duplicate (paper 5.4)
  std::int32_t mesh_cells = 0;
  std::int32_t fragments = 0;  // connected components of the whole tissue

  std::shared_ptr<const FineVoxels> fine;     // kept for embedding and for state transfer
  std::vector<EmbeddedPoint> surface_points;  // one per surface vertex, side decided by fine-voxel connectivity

  std::size_t cells() const { return cell_nodes.size(); }
  // The grid point of a cell's corner 0.
  const GridPoint& cell_position(std::size_t cell) const { return node_rest.grid_point(cell_nodes[cell][0]); }
  std::vector<GridPoint> cell_positions() const;
  double volume() const;  // mm^3 of tissue in the cells
  std::size_t bytes() const;
};

// Builds the lattice of a closed surface, and embeds its vertices. Throws RefusedError (see refused.h) naming the
// cause: no inside voxel (too thin for the spacing), memory budget, points that are not finite.
Lattice build_lattice(const Surface& surface, const LatticeSettings& settings, const Interrupt& interrupt = {});

// Of a rest point in a cell; they leave [0, 1] outside it.
std::array<double, 8> trilinear_weights(const Lattice& lattice, Index cell, const Vec3& point);

// Embeds a rest point inside the tissue or on its surface; `triangle`: the nearest of the surface the lattice was built
// from, which decides the side at a wound.
EmbeddedPoint embed_on_triangle(const Lattice& lattice, const Surface& surface, const Vec3& point, Index triangle);

// Carries a nodal field (positions) from the lattice of the previous epoch to a new one by rest position: a new cell
// inherits from the old cell whose fragment contains it (fine voxels decide). Where several old cells reach one new
// node the result is their mean. Returns one position per new node.
std::vector<Vec3> transfer_positions(const Lattice& from, std::span<const Vec3> positions, const Lattice& to,
                                     const Interrupt& interrupt = {});

}  // namespace lappet
