// Fine rasterization of a closed surface (GRIDiron §5.2): which voxels hold tissue, which neighbors are cut apart, and
// on which side of every triangle the tissue lies.
//
// Two neighboring inside voxels are connected unless the segment between their centers crosses the surface, so a cut
// of any width separates at any ratio. Voxels are stored as bit masks for the coarse cells that the surface touches,
// and not at all for the others, which are tissue throughout or empty.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "lattice/lattice.h"
#include "lattice/surface.h"
#include "lattice/voxel_box.h"

namespace lappet {

// How far the tissue of an inside voxel reaches beyond a face of it: to where the surface crosses the line to the next
// center, which is exact where the surface is parallel to the face. Where it is not, the lines of two or three axes
// tell of the same surface, and each counts with the square of the cosine between the axis and the surface's normal.
struct VoxelReach {
  std::uint32_t face;  // 6 * voxel in its cell + 2 * axis + 1 for the upper one
  float beyond;        // voxels, -1/2 to 1/2

  std::int32_t voxel() const { return std::int32_t(face / 6); }
  std::int32_t axis() const { return std::int32_t(face % 6 / 2); }
  bool is_upper() const { return face % 2 == 1; }
};

class FineVoxels {
 public:
  // Rasterizes. Throws RefusedError (refused.h): points that are not finite, triangles that name no point, a surface
  // that is open or turned inside out, a lattice over the memory budget (before it is allocated).
  FineVoxels(const Surface& surface, const LatticeSettings& settings, const Interrupt& interrupt = {});

  const VoxelBox& box() const { return box_; }

  // --- occupied coarse cells: those that the surface touches or that are tissue throughout, in grid order (z fastest)
  Index occupied_count() const { return to_index(position_.size()); }
  // Number of the occupied cell at a place of the box, -1 where there is none (or the place is outside the box).
  Index occupied_at(std::int32_t x, std::int32_t y, std::int32_t z) const {
    if (x < 0 || y < 0 || z < 0 || x >= box_.cells[0] || y >= box_.cells[1] || z >= box_.cells[2]) return -1;
    return occupied_[box_.cell_index(x, y, z)];
  }
  Voxel position(Index cell) const { return position_[cell]; }  // in the box, cells
  // No triangle near: all r^3 voxels inside, none cut from its neighbors.
  bool is_whole(Index cell) const { return block_[cell] < 0; }

  // --- voxels. Positions are relative to the box; those outside it are allowed and empty.
  bool inside(const Voxel& voxel) const { return copy_of(voxel) >= 0; }
  // Is the segment from this voxel to its next neighbor along +axis crossed by the surface?
  bool cut_above(const Voxel& voxel, int axis) const;
  // Both inside, face neighbors along +axis, and not cut apart.
  bool connected_above(const Voxel& voxel, int axis) const;

  // --- copies: the connected components of the inside voxels of one coarse cell (Algorithm 2, line 2), numbered by
  // cell
  Index copy_count() const { return copy_first_.back(); }
  Index first_copy(Index cell) const { return copy_first_[cell]; }
  Index copy_of(const Voxel& voxel) const;  // -1: outside
  std::int32_t voxels_of_copy(Index copy) const { return copy_voxels_[copy]; }

  // Lattice cell that a copy became; -1 where it was dropped. Set once, by the construction of the lattice; the numbers
  // of voxels are freed then.
  void set_lattice_cells(std::vector<Index> cell_of_copy) {
    lattice_cell_ = std::move(cell_of_copy);
    copy_voxels_ = {};
  }
  Index lattice_cell(const Voxel& voxel) const {
    const Index copy = copy_of(voxel);
    return copy < 0 ? -1 : lattice_cell_[copy];
  }

  // --- the faces of a coarse cell's inside voxels that the surface lies beyond or short of, in order; at others it
  // lies on the face, or there is none
  std::span<const VoxelReach> reaches(Index cell) const {
    const Index block = block_[cell];
    if (block < 0 || reach_.empty()) return {};
    return std::span(reach_).subspan(reach_first_[block], reach_first_[block + 1] - reach_first_[block]);
  }

  // --- the tissue's side of the surface: for each crossing of a triangle with a line of centers, the inside voxel next
  // to it on the inner side. Voxel {-1, -1, -1}: none (a sheet thinner than a voxel).
  std::span<const PackedVoxel> inner_voxels(Index triangle) const {
    return std::span(inner_).subspan(inner_first_[triangle], inner_first_[triangle + 1] - inner_first_[triangle]);
  }
  Index triangle_count() const { return to_index(inner_first_.size()) - 1; }
  // Triangles across the edges (0,1), (1,2), (2,0); -1 where the edge is not shared by exactly two.
  const std::array<Index, 3>& neighbors(Index triangle) const { return neighbors_[triangle]; }
  // Connected component of the surface (over shared edges) that a triangle belongs to, and how many there are.
  Index component_of(Index triangle) const { return component_[triangle]; }
  Index component_count() const { return component_count_; }

  std::size_t bytes() const;

 private:
  struct Builder;
  std::size_t bit(const Voxel& local) const { return (local[0] * box_.ratio + local[1]) * box_.ratio + local[2]; }
  bool get(const std::vector<std::uint64_t>& masks, Index block, std::size_t bit) const {
    return (masks[block * words_ + bit / 64] >> (bit % 64)) & 1U;
  }

  VoxelBox box_;
  std::size_t words_ = 1;                          // 64-bit words per block: r^3 bits
  std::vector<Index> occupied_;                    // per place of the box
  std::vector<PackedVoxel> position_;              // per occupied cell
  std::vector<Index> block_;                       // per occupied cell: its masks, or -1 for a whole cell
  std::vector<std::uint64_t> inside_;              // per block
  std::array<std::vector<std::uint64_t>, 3> cut_;  // per block; bit of the lower voxel
  std::vector<Index> copy_first_;                  // per occupied cell, and one past the last
  std::vector<Index> copy_voxels_;                 // per copy
  std::vector<std::int64_t> label_first_;          // per block: labels of a cell with several copies, or -1
  std::vector<std::uint16_t> labels_;              // r^3 per such cell
  std::vector<Index> lattice_cell_;                // per copy
  std::vector<std::int64_t> reach_first_;          // per block, and one past the last
  std::vector<VoxelReach> reach_;
  std::vector<std::int64_t> inner_first_;  // per triangle
  std::vector<PackedVoxel> inner_;
  std::vector<std::array<Index, 3>> neighbors_;
  std::vector<Index> component_;
  Index component_count_ = 0;
};

}  // namespace lappet
