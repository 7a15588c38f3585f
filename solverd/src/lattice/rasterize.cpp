// Which cells the surface touches or the tissue fills, and the bit masks of their voxels.
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>

#include "lattice/fine_voxels_builder.h"

namespace lappet {

namespace {

// What stands for a cell before it has a number.
constexpr std::int32_t kEmpty = -1, kTouched = -2, kWhole = -3;

}  // namespace

void FineVoxels::Builder::mark_touched() {
  out.occupied_.assign(out.box_.cell_count(), kEmpty);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, crossings.all.size(), 65536), [&](const auto& range) {
    interrupt.check();
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      Voxel voxel = crossings.all[i].lower;
      for (int end = 0; end < 2; ++end, ++voxel[crossings.all[i].axis])
        if (out.box_.contains(voxel))
          std::atomic_ref(place(out.box_.cell_of(voxel))).store(kTouched, std::memory_order_relaxed);
    }
  });
}

void FineVoxels::Builder::mark_whole(const CenterLines& z_lines) {
  const std::int32_t r = out.box_.ratio;
  tbb::parallel_for(tbb::blocked_range<std::int32_t>(0, out.box_.cells[0], 8), [&](const auto& range) {
    interrupt.check();
    for (std::int32_t x = range.begin(); x != range.end(); ++x)
      for (std::int32_t y = 0; y < out.box_.cells[1]; ++y) {
        const std::size_t line = std::int64_t{x} * r * out.box_.voxels(1) + std::int64_t{y} * r;
        z_lines.walk(
            line,
            [&](std::int32_t from, std::int32_t to, int winding) {
              if (winding < 0) return;
              for (std::int32_t z = (from + r - 1) / r; z * r < to; ++z)
                if (place({x, y, z}) == kEmpty) place({x, y, z}) = kWhole;
            },
            kIgnoreSegment);
      }
  });
}

void FineVoxels::Builder::number_cells() {
  std::int32_t blocks = 0;
  const std::size_t occupied =
      std::ranges::count_if(out.occupied_, [](std::int32_t number) { return number != kEmpty; });
  out.block_.reserve(occupied);
  out.position_.reserve(occupied);
  for (std::int32_t x = 0; x < out.box_.cells[0]; ++x)
    for (std::int32_t y = 0; y < out.box_.cells[1]; ++y)
      for (std::int32_t z = 0; z < out.box_.cells[2]; ++z) {
        std::int32_t& number = place({x, y, z});
        if (number == kEmpty) continue;
        out.block_.push_back(number == kTouched ? blocks++ : -1);
        number = to_index(out.position_.size());
        out.position_.push_back(PackedVoxel({x, y, z}));
      }
  const std::size_t r = out.box_.ratio;
  out.words_ = (r * r * r + 63) / 64;
  out.inside_.assign(blocks * out.words_, 0);
  for (auto& cut : out.cut_) cut.assign(blocks * out.words_, 0);
  out.label_first_.assign(blocks, -1);
}

void FineVoxels::Builder::set(std::vector<std::uint64_t>& masks, const Voxel& voxel) {
  const Voxel cell = out.box_.cell_of(voxel);
  const Index block = out.block_[place(cell)];
  const std::size_t bit = out.bit(out.box_.place_in(cell, voxel));
  std::atomic_ref(masks[block * out.words_ + bit / 64])
      .fetch_or(std::uint64_t{1} << (bit % 64), std::memory_order_relaxed);
}

void FineVoxels::Builder::set_run(const Voxel& start, std::int32_t to) {
  const std::int32_t r = out.box_.ratio;
  for (Voxel voxel = start; voxel[2] < to;) {
    const std::int32_t end = std::min(to, (voxel[2] / r + 1) * r);
    const std::int32_t number = place(out.box_.cell_of(voxel));
    if (number < 0 || out.is_whole(number))
      voxel[2] = end;
    else
      for (; voxel[2] < end; ++voxel[2]) set(out.inside_, voxel);
  }
}

void FineVoxels::Builder::set_inner_voxels(Voxel voxel, std::size_t axis, std::span<const std::uint32_t> list,
                                           int before, int after) {
  // The first wall left behind bounds the tissue of the lower voxel, the last one entered that of the upper.
  if (before > 0)
    for (const std::uint32_t i : list)
      if (crossings.all[i].winding < 0) {
        out.inner_[i] = PackedVoxel(voxel);
        break;
      }
  if (after > 0)
    for (std::size_t k = list.size(); k-- > 0;)
      if (crossings.all[list[k]].winding > 0) {
        ++voxel[axis];
        out.inner_[list[k]] = PackedVoxel(voxel);
        break;
      }
}

bool FineVoxels::Builder::sweep(const CenterLines& lines, std::size_t axis, std::size_t& open_line) {
  const std::size_t u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
  const std::size_t width = out.box_.voxels(v);
  const std::int32_t length = out.box_.voxels(axis);
  std::atomic<std::size_t> open = lines.count();
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, lines.count(), 1024), [&](const auto& range) {
    interrupt.check();
    for (std::size_t line = range.begin(); line != range.end(); ++line) {
      Voxel voxel;
      voxel[u] = std::int32_t(line / width);
      voxel[v] = std::int32_t(line % width);
      const auto run = [&](std::int32_t from, std::int32_t to, int winding) {
        if (axis != 2 || winding < 0) return;
        voxel[2] = from;
        set_run(voxel, to);
      };
      const auto segment = [&](Index lower, std::span<const std::uint32_t> list, int before, int after) {
        voxel[axis] = lower;
        if (lower >= 0 && lower + 1 < length) set(out.cut_[axis], voxel);
        set_inner_voxels(voxel, axis, list, before, after);
      };
      if (lines.walk(line, run, segment) != 0) {
        std::size_t seen = open.load();
        while (line < seen && !open.compare_exchange_weak(seen, line)) {
        }
      }
    }
  });
  open_line = open.load();
  return open_line == lines.count();
}

}  // namespace lappet
