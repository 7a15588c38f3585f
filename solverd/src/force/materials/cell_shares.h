// What a cell holds of each material where a boundary between materials passes through it.
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "force/materials/cell_fill.h"
#include "force/materials/cell_materials.h"
#include "force/materials/skin_tree.h"
#include "lattice/tissue_samples.h"

namespace lappet {

// Finds the shares of cells. Every eighth of a cell is one sample: the centroid of the tissue in it, by the lattice's
// fine voxels, and the depth below the skin there. A layer's boundary cuts the sample along the way to the skin, so
// that flat layers have their shares exactly, wherever the lattice lies.
class CellShares {
 public:
  // Keeps references to all of them. `regions` are as assign_materials gets them.
  CellShares(const Lattice& lattice, const SkinTree& skin, std::span<const MaterialRegion> regions);

  // Whether a boundary between materials may pass through the cell; `center`: what of the skin is closest to its
  // middle.
  bool may_be_mixed(std::size_t cell, const SkinTree::Closest& center) const;
  // The material at a depth below a triangle of the skin.
  std::uint8_t material(Index triangle, double depth) const;
  // Appends the shares of a cell, the largest first; where it holds one material, one share, and none if it is full of
  // it. `mixed`: whether to look for more than `only`. Returns the material of the largest.
  std::uint8_t append(std::size_t cell, bool mixed, std::uint8_t only, std::vector<MaterialShare>& shares) const;

 private:
  struct Sum;
  void add(const Vec3& middle, const TissueSample& sample, std::vector<Sum>& sums) const;

  const Lattice& lattice_;
  const SkinTree& skin_;
  std::span<const MaterialRegion> regions_;
  std::vector<double> boundaries_;  // depths at which some region begins or ends, below its faces
  Surface border_;                  // edges between skin triangles of different regions, as triangles without area
  std::unique_ptr<SkinTree> border_tree_;
};

}  // namespace lappet
