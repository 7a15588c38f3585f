// Embeds rest points on the surface in cells of the lattice.
//
// The side at a wound is decided by the surface and the voxels alone: from the triangle the point lies on, the search
// grows over shared edges until it meets a triangle that is crossed by a line of voxel centers nearby; the inside voxel
// next to that crossing lies on the point's side. From there a walk over connected voxels finds the cell that holds the
// point.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "lattice/lattice.h"
#include "lattice/voxel_tree.h"
#include "lattice/voxelize.h"

namespace lappet {

class Embedder {
 public:
  // Keeps references: both must outlive it. Not to be shared between threads.
  Embedder(const Lattice& lattice, const Surface& surface);

  // `triangles`: those the point lies on or is a corner of.
  EmbeddedPoint embed(const Vec3& point, std::span<const Index> triangles);
  // A point on the surface or inside the tissue; `triangle`: the nearest to it, or one of the face nearest to it.
  EmbeddedPoint embed_near(const Vec3& point, Index triangle);

 private:
  Voxel inner_voxel(const Vec3& point, std::span<const Index> triangles);
  const VoxelTree& tree_of(Index triangle);
  Voxel nearest_of_all(const Vec3& point) const;
  Index walk_to_cell(const Vec3& point, const Voxel& start);
  double distance_to_surface(const Vec3& point, Index triangle);
  // In voxels, relative to the box.
  Vec3 surface_point(Index index) const;
  std::array<Vec3, 3> corners_of(Index triangle) const;

  const Lattice& lattice_;
  const Surface& surface_;
  const FineVoxels& fine_;
  double voxels_per_mm_;
  bool none_dropped_;                // every inside voxel has a cell
  std::vector<std::uint32_t> seen_;  // per triangle: the search that met it last
  std::uint32_t search_ = 0;
  std::vector<std::pair<double, Index>> front_;  // of a search: how far the point is at least, triangle
  std::unordered_map<Index, VoxelTree> trees_;   // of triangles with many voxels
};

// Every surface vertex, in order.
std::vector<EmbeddedPoint> embed_surface(const Lattice& lattice, const Surface& surface,
                                         const Interrupt& interrupt = {});

}  // namespace lappet
