// Fills a FineVoxels stage by stage: which cells there are and what their masks hold (rasterize.cpp), how far
// the tissue of the voxels along the surface reaches (voxel_reach.cpp), then the connected components of each cell's
// voxels (label_copies.cpp).
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lattice/center_lines.h"
#include "lattice/crossings.h"
#include "lattice/voxelize.h"

namespace lappet {

struct FineVoxels::Builder {
  FineVoxels& out;
  const Interrupt& interrupt;
  Crossings crossings = {};

  // Marks the cells at both ends of every crossed segment.
  void mark_touched();
  // A cell that nothing touches is like its first voxel throughout.
  void mark_whole(const CenterLines& z_lines);
  void number_cells();
  // Walks the lines of one axis: cut links, inner voxels, and (for z) the inside voxels. Returns false where the
  // surface is open, with the first line that shows it.
  bool sweep(const CenterLines& lines, std::size_t axis, std::size_t& open_line);
  // How far the tissue of the voxels along the surface reaches (voxel_reach.cpp).
  void measure_reaches(std::span<const StepPoint> points, std::span<const std::array<Index, 3>> triangles);
  void make_copies();

  // --- steps of these
  std::int32_t& place(const Voxel& cell) { return out.occupied_[out.box_.cell_index(cell[0], cell[1], cell[2])]; }
  void set(std::vector<std::uint64_t>& masks, const Voxel& voxel);
  // Sets the bits of a run of inside voxels along z in the cells that have masks.
  void set_run(const Voxel& start, std::int32_t to);
  // Stores the inside voxels at the ends of a crossed segment for the triangles that bound them. list: its crossings,
  // from low to high; before, after: the winding numbers.
  void set_inner_voxels(Voxel lower, std::size_t axis, std::span<const std::uint32_t> list, int before, int after);

  // Whether the inside voxels of a cell of at most 64 voxels are one component at most: it grows from the first voxel,
  // from all that it has reached at once. upper_end: per axis, the voxels that have no neighbor above in the cell.
  bool is_connected(Index block, const std::array<std::uint64_t, 3>& upper_end) const;
  // Per axis, the voxels of a cell that have no neighbor above in it.
  std::array<std::uint64_t, 3> upper_ends() const;
  std::int32_t inside_voxels(Index block) const;
  // Labels the components of the inside voxels of one cell; returns how many there are.
  struct Labels {
    std::vector<std::uint16_t> of_voxel;
    std::vector<std::uint32_t> stack;
    std::vector<Index> sizes;  // per component
  };
  std::int32_t label(Index block, Labels& labels) const;
};

}  // namespace lappet
