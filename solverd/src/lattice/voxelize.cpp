#include "lattice/voxelize.h"

#include <array>
#include <limits>
#include <string>

#include "lattice/fine_voxels_builder.h"
#include "lattice/memory_estimate.h"
#include "lattice/quantize.h"
#include "lattice/refused.h"
#include "lattice/surface_components.h"

namespace lappet {
namespace {

[[noreturn]] void refuse_open(const VoxelBox& box, const LatticeSettings& settings, std::size_t axis,
                              std::size_t line) {
  const std::size_t u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2, width = box.voxels(v);
  const double voxel = settings.spacing / settings.fine_ratio;
  const auto coordinate = [&](std::size_t a, std::size_t i) {
    return settings.origin[a] + box.low[a] * settings.spacing + (double(i) + 0.5) * voxel;
  };
  const std::array<const char*, 3> name{"x", "y", "z"};
  refuse("The tissue surface is not closed: it has a hole or a flipped triangle on the line " + std::string(name[u]) +
         " = " + shown(coordinate(u, line / width)) + " mm, " + name[v] + " = " + shown(coordinate(v, line % width)) +
         " mm; close it.");
}

}  // namespace

FineVoxels::FineVoxels(const Surface& surface, const LatticeSettings& settings, const Interrupt& interrupt) {
  check_input(surface, settings);
  const SurfaceMeasure size = measure(surface);
  check_memory(size, settings);
  if (size.volume <= 0.0)
    refuse("The tissue surface encloses " + shown(size.volume) +
           " mm^3; its triangles must form a closed surface that faces outwards.");
  Quantized quantized = quantize(surface, settings);
  box_ = quantized.box;

  Builder builder{*this, interrupt};
  std::vector<std::int64_t> first = count_crossings(quantized.points, surface.triangles, box_, interrupt);
  if (first.back() >= std::numeric_limits<std::uint32_t>::max())
    throw RefusedError(ErrorCode::kMemoryBudget, "The surface crosses the fine grid " + shown(double(first.back())) +
                                                     " times; use a larger spacing or a smaller fine ratio.");
  builder.crossings = find_crossings(quantized.points, surface.triangles, box_, std::move(first), interrupt);
  inner_.assign(builder.crossings.all.size(), PackedVoxel());
  builder.mark_touched();
  for (const std::size_t axis : {std::size_t{2}, std::size_t{1}, std::size_t{0}}) {
    interrupt.check();
    const CenterLines lines(builder.crossings, axis, box_);
    interrupt.check();
    if (axis == 2) {
      builder.mark_whole(lines);
      builder.number_cells();
    }
    std::size_t open = 0;
    if (!builder.sweep(lines, axis, open)) refuse_open(box_, settings, axis, open);
  }
  builder.measure_reaches(quantized.points, surface.triangles);
  inner_first_ = std::move(builder.crossings.first);
  builder.crossings.all = {};
  interrupt.check();
  builder.make_copies();
  interrupt.check();

  SurfaceComponents components = find_components(surface);
  neighbors_ = std::move(components.neighbors);
  component_ = std::move(components.component);
  component_count_ = components.count;
}

Index FineVoxels::copy_of(const Voxel& voxel) const {
  if (!box_.contains(voxel)) return -1;
  const Voxel at = box_.cell_of(voxel);
  const Index cell = occupied_at(at[0], at[1], at[2]);
  if (cell < 0) return -1;
  const Index block = block_[cell];
  if (block < 0) return first_copy(cell);
  const std::size_t b = bit(box_.place_in(at, voxel));
  if (!get(inside_, block, b)) return -1;
  const std::int64_t labels = label_first_[block];
  return first_copy(cell) + (labels < 0 ? 0 : labels_[labels + b]);
}

bool FineVoxels::cut_above(const Voxel& voxel, int axis) const {
  if (!box_.contains(voxel)) return false;
  const Voxel at = box_.cell_of(voxel);
  const Index cell = occupied_at(at[0], at[1], at[2]);
  if (cell < 0 || is_whole(cell)) return false;
  return get(cut_[axis], block_[cell], bit(box_.place_in(at, voxel)));
}

bool FineVoxels::connected_above(const Voxel& voxel, int axis) const {
  if (!box_.contains(voxel)) return false;
  const Voxel at = box_.cell_of(voxel);
  Voxel local = box_.place_in(at, voxel);
  if (local[axis] + 1 == box_.ratio) {  // over to the next cell
    Voxel next = voxel;
    ++next[axis];
    return inside(voxel) && inside(next) && !cut_above(voxel, axis);
  }
  const Index cell = occupied_at(at[0], at[1], at[2]);
  if (cell < 0) return false;
  const Index block = block_[cell];
  if (block < 0) return true;
  const std::size_t lower = bit(local);
  ++local[axis];
  return get(inside_, block, lower) && get(inside_, block, bit(local)) && !get(cut_[axis], block, lower);
}

std::size_t FineVoxels::bytes() const {
  const auto size = [](const auto& v) { return v.capacity() * sizeof(v[0]); };
  return size(occupied_) + size(position_) + size(block_) + size(inside_) + size(cut_[0]) + size(cut_[1]) +
         size(cut_[2]) + size(copy_first_) + size(copy_voxels_) + size(label_first_) + size(labels_) +
         size(lattice_cell_) + size(reach_first_) + size(reach_) + size(inner_first_) + size(inner_) +
         size(neighbors_) + size(component_);
}

}  // namespace lappet
