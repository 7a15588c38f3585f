#include "lattice/voxelize.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstdio>
#include <limits>
#include <string>

#include "lattice/center_lines.h"
#include "lattice/crossings.h"
#include "lattice/memory_estimate.h"
#include "lattice/quantize.h"
#include "lattice/refused.h"
#include "lattice/surface_components.h"

namespace lappet {
namespace {

constexpr std::uint16_t kNoLabel = 0xFFFF;

std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%g", value);
  return text.data();
}

[[noreturn]] void refuse(const std::string& sentence) { throw RefusedError(ErrorCode::kInvalidInput, sentence); }

}  // namespace

// Fills a FineVoxels stage by stage.
struct FineVoxels::Builder {
  FineVoxels& out;
  Crossings crossings;

  std::int32_t& place(const Voxel& cell) {
    return out.occupied_[static_cast<std::size_t>(out.box_.cell_index(cell[0], cell[1], cell[2]))];
  }
  Voxel cell_of(const Voxel& voxel) const {
    return {voxel[0] / out.box_.ratio, voxel[1] / out.box_.ratio, voxel[2] / out.box_.ratio};
  }

  static constexpr std::int32_t kEmpty = -1, kTouched = -2, kWhole = -3;

  // Marks the cells at both ends of every crossed segment.
  void mark_touched() {
    out.occupied_.assign(static_cast<std::size_t>(out.box_.cell_count()), kEmpty);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, crossings.all.size(), 65536), [&](const auto& range) {
      for (std::size_t i = range.begin(); i != range.end(); ++i) {
        Voxel voxel = crossings.all[i].lower;
        for (int end = 0; end < 2; ++end, ++voxel[crossings.all[i].axis])
          if (out.box_.contains(voxel))
            std::atomic_ref(place(cell_of(voxel))).store(kTouched, std::memory_order_relaxed);
      }
    });
  }

  // A cell that nothing touches is like its first voxel throughout.
  void mark_whole(const CenterLines& z_lines) {
    const std::int32_t r = out.box_.ratio;
    tbb::parallel_for(tbb::blocked_range<std::int32_t>(0, out.box_.cells[0], 8), [&](const auto& range) {
      for (std::int32_t x = range.begin(); x != range.end(); ++x)
        for (std::int32_t y = 0; y < out.box_.cells[1]; ++y) {
          const auto line = static_cast<std::size_t>(std::int64_t{x} * r * out.box_.voxels(1) + std::int64_t{y} * r);
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

  void number_cells() {
    std::int32_t blocks = 0;
    const auto occupied = static_cast<std::size_t>(
        std::ranges::count_if(out.occupied_, [](std::int32_t number) { return number != kEmpty; }));
    out.block_.reserve(occupied);
    out.position_.reserve(occupied);
    for (std::int32_t x = 0; x < out.box_.cells[0]; ++x)
      for (std::int32_t y = 0; y < out.box_.cells[1]; ++y)
        for (std::int32_t z = 0; z < out.box_.cells[2]; ++z) {
          std::int32_t& number = place({x, y, z});
          if (number == kEmpty) continue;
          out.block_.push_back(number == kTouched ? blocks++ : -1);
          number = static_cast<std::int32_t>(out.position_.size());
          out.position_.push_back(PackedVoxel({x, y, z}));
        }
    const auto r = static_cast<std::size_t>(out.box_.ratio);
    out.words_ = (r * r * r + 63) / 64;
    out.inside_.assign(static_cast<std::size_t>(blocks) * out.words_, 0);
    for (auto& cut : out.cut_) cut.assign(static_cast<std::size_t>(blocks) * out.words_, 0);
    out.label_first_.assign(static_cast<std::size_t>(blocks), -1);
  }

  void set(std::vector<std::uint64_t>& masks, const Voxel& voxel) {
    const Voxel cell = cell_of(voxel);
    const std::int32_t block = out.block_[static_cast<std::size_t>(place(cell))];
    const std::int32_t r = out.box_.ratio;
    const std::size_t bit = out.bit({voxel[0] - cell[0] * r, voxel[1] - cell[1] * r, voxel[2] - cell[2] * r});
    std::atomic_ref(masks[static_cast<std::size_t>(block) * out.words_ + bit / 64])
        .fetch_or(std::uint64_t{1} << (bit % 64), std::memory_order_relaxed);
  }

  // Sets the bits of a run of inside voxels along z in the cells that have masks.
  void set_run(const Voxel& start, std::int32_t to) {
    const std::int32_t r = out.box_.ratio;
    for (Voxel voxel = start; voxel[2] < to;) {
      const std::int32_t end = std::min(to, (voxel[2] / r + 1) * r);
      const std::int32_t number = place(cell_of(voxel));
      if (number < 0 || out.is_whole(number))
        voxel[2] = end;
      else
        for (; voxel[2] < end; ++voxel[2]) set(out.inside_, voxel);
    }
  }

  // Walks the lines of one axis: cut links, inner voxels, and (for z) the inside voxels. Returns false if a line says
  // that the surface is open there.
  bool sweep(const CenterLines& lines, std::size_t axis, std::size_t& open_line) {
    const std::size_t u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
    const std::int32_t width = out.box_.voxels(static_cast<int>(v)), length = out.box_.voxels(static_cast<int>(axis));
    std::atomic<std::size_t> open = lines.count();
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, lines.count(), 1024), [&](const auto& range) {
      for (std::size_t line = range.begin(); line != range.end(); ++line) {
        Voxel voxel;
        voxel[u] = static_cast<std::int32_t>(line / static_cast<std::size_t>(width));
        voxel[v] = static_cast<std::int32_t>(line % static_cast<std::size_t>(width));
        const auto run = [&](std::int32_t from, std::int32_t to, int winding) {
          if (axis != 2 || winding < 0) return;
          voxel[2] = from;
          set_run(voxel, to);
        };
        const auto segment = [&](std::int32_t lower, std::span<const std::uint32_t> list, int before, int after) {
          voxel[axis] = lower;
          if (lower >= 0 && lower + 1 < length) set(out.cut_[axis], voxel);
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

  // Whether the inside voxels of a cell of at most 64 voxels are one component at most: it grows from the first voxel,
  // from all that it has reached at once. upper_end: per axis, the voxels that have no neighbor above in the cell.
  bool is_connected(std::int32_t block, const std::array<std::uint64_t, 3>& upper_end) const {
    const auto r = static_cast<unsigned>(out.box_.ratio);
    const std::array<unsigned, 3> stride{r * r, r, 1};
    const auto word = static_cast<std::size_t>(block);
    const std::uint64_t inside = out.inside_[word];
    std::array<std::uint64_t, 3> open;  // the lower ends of links
    for (std::size_t a = 0; a < 3; ++a) open[a] = inside & (inside >> stride[a]) & ~upper_end[a] & ~out.cut_[a][word];
    std::uint64_t reached = inside & (~inside + 1), before = 0;
    while (reached != before) {
      before = reached;
      for (std::size_t a = 0; a < 3; ++a)
        reached |= ((reached & open[a]) << stride[a]) | ((reached >> stride[a]) & open[a]);
    }
    return reached == inside;
  }

  std::int32_t inside_voxels(std::int32_t block) const {
    std::int32_t count = 0;
    for (std::size_t w = 0; w < out.words_; ++w)
      count += std::popcount(out.inside_[static_cast<std::size_t>(block) * out.words_ + w]);
    return count;
  }

  // Labels the components of the inside voxels of one cell; returns how many there are.
  std::int32_t label(std::int32_t block, std::vector<std::uint16_t>& labels, std::vector<std::uint32_t>& stack,
                     std::vector<std::int32_t>& sizes) const {
    const auto r = static_cast<std::size_t>(out.box_.ratio);
    const std::array<std::size_t, 3> stride{r * r, r, 1};
    labels.assign(r * r * r, kNoLabel);
    sizes.clear();
    for (std::size_t seed = 0; seed < r * r * r; ++seed) {
      if (labels[seed] != kNoLabel || !out.get(out.inside_, block, seed)) continue;
      const auto name = static_cast<std::uint16_t>(sizes.size());
      sizes.push_back(0);
      labels[seed] = name;
      stack.push_back(static_cast<std::uint32_t>(seed));
      while (!stack.empty()) {
        const std::size_t at = stack.back();
        stack.pop_back();
        ++sizes.back();
        for (std::size_t a = 0; a < 3; ++a) {
          const std::size_t along = at / stride[a] % r;
          const auto visit = [&](std::size_t next, std::size_t lower) {
            if (labels[next] != kNoLabel || !out.get(out.inside_, block, next) || out.get(out.cut_[a], block, lower))
              return;
            labels[next] = name;
            stack.push_back(static_cast<std::uint32_t>(next));
          };
          if (along + 1 < r) visit(at + stride[a], at);
          if (along > 0) visit(at - stride[a], at - stride[a]);
        }
      }
    }
    return static_cast<std::int32_t>(sizes.size());
  }

  void make_copies() {
    struct Scratch {
      std::vector<std::uint16_t> labels;
      std::vector<std::uint32_t> stack;
      std::vector<std::int32_t> sizes;
    };
    tbb::enumerable_thread_specific<Scratch> scratch;
    const std::size_t cells = out.position_.size();
    const std::int32_t r = out.box_.ratio;
    std::vector<std::int32_t> count(cells, 1);
    const auto each_touched = [&](const auto& body) {
      tbb::parallel_for(tbb::blocked_range<std::size_t>(0, cells, 256), [&](const auto& range) {
        Scratch& local = scratch.local();
        for (std::size_t c = range.begin(); c != range.end(); ++c)
          if (out.block_[c] >= 0) body(c, out.block_[c], local);
      });
    };
    std::array<std::uint64_t, 3> upper_end{};
    if (out.words_ == 1)
      for (std::int32_t x = 0; x < r; ++x)
        for (std::int32_t y = 0; y < r; ++y)
          for (std::int32_t z = 0; z < r; ++z)
            for (std::size_t a = 0; a < 3; ++a)
              if (const Voxel at{x, y, z}; at[a] + 1 == r) upper_end[a] |= std::uint64_t{1} << out.bit(at);
    each_touched([&](std::size_t c, std::int32_t block, Scratch& local) {
      if (out.words_ == 1 && is_connected(block, upper_end))
        count[c] = inside_voxels(block) > 0;
      else
        count[c] = label(block, local.labels, local.stack, local.sizes);
    });
    out.copy_first_.assign(cells + 1, 0);
    std::int64_t labeled = 0;
    for (std::size_t c = 0; c < cells; ++c) {
      out.copy_first_[c + 1] = out.copy_first_[c] + count[c];
      if (out.block_[c] >= 0 && count[c] > 1)
        out.label_first_[static_cast<std::size_t>(out.block_[c])] = std::int64_t{r} * r * r * labeled++;
    }
    out.copy_voxels_.assign(static_cast<std::size_t>(out.copy_first_.back()), r * r * r);
    out.labels_.resize(static_cast<std::size_t>(std::int64_t{r} * r * r * labeled));
    each_touched([&](std::size_t c, std::int32_t block, Scratch& local) {
      const auto sizes = out.copy_voxels_.begin() + out.copy_first_[c];
      if (count[c] == 1) *sizes = inside_voxels(block);
      if (count[c] <= 1) return;
      label(block, local.labels, local.stack, local.sizes);
      std::copy(local.sizes.begin(), local.sizes.end(), sizes);
      std::copy(local.labels.begin(), local.labels.end(),
                out.labels_.begin() + out.label_first_[static_cast<std::size_t>(block)]);
    });
  }
};

FineVoxels::FineVoxels(const Surface& surface, const LatticeSettings& settings) {
  check_input(surface, settings);
  const SurfaceMeasure size = measure(surface);
  check_memory(size, settings);
  if (size.volume <= 0.0)
    refuse("The tissue surface encloses " + number(size.volume) +
           " mm^3; its triangles must form a closed surface that faces outwards.");
  Quantized quantized = quantize(surface, settings);
  box_ = quantized.box;

  Builder builder{*this, {}};
  std::vector<std::int64_t> first = count_crossings(quantized.points, surface.triangles, box_);
  if (first.back() >= std::numeric_limits<std::uint32_t>::max())
    throw RefusedError(ErrorCode::kMemoryBudget, "The surface crosses the fine grid " + number(double(first.back())) +
                                                     " times; use a larger spacing or a smaller fine ratio.");
  builder.crossings = find_crossings(quantized.points, surface.triangles, box_, std::move(first));
  inner_.assign(builder.crossings.all.size(), PackedVoxel());
  builder.mark_touched();
  for (const std::size_t axis : {std::size_t{2}, std::size_t{1}, std::size_t{0}}) {
    const CenterLines lines(builder.crossings, axis, box_);
    if (axis == 2) {
      builder.mark_whole(lines);
      builder.number_cells();
    }
    std::size_t open = 0;
    if (!builder.sweep(lines, axis, open)) {
      const std::size_t u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
      const auto width = static_cast<std::size_t>(box_.voxels(static_cast<int>(v)));
      const double voxel = settings.spacing / settings.fine_ratio;
      const auto coordinate = [&](std::size_t a, std::size_t i) {
        return settings.origin[static_cast<Eigen::Index>(a)] + box_.low[a] * settings.spacing +
               (static_cast<double>(i) + 0.5) * voxel;
      };
      const std::array<const char*, 3> name{"x", "y", "z"};
      refuse("The tissue surface is not closed: it has a hole or a flipped triangle on the line " +
             std::string(name[u]) + " = " + number(coordinate(u, open / width)) + " mm, " + name[v] + " = " +
             number(coordinate(v, open % width)) + " mm; close it.");
    }
  }
  inner_first_ = std::move(builder.crossings.first);
  builder.crossings.all = {};
  builder.make_copies();

  SurfaceComponents components = find_components(surface);
  neighbors_ = std::move(components.neighbors);
  component_ = std::move(components.component);
  component_count_ = components.count;
}

std::int32_t FineVoxels::copy_of(const Voxel& voxel) const {
  if (!box_.contains(voxel)) return -1;
  const std::int32_t r = box_.ratio;
  const Voxel at{voxel[0] / r, voxel[1] / r, voxel[2] / r};
  const std::int32_t cell = occupied_at(at[0], at[1], at[2]);
  if (cell < 0) return -1;
  const std::int32_t block = block_[static_cast<std::size_t>(cell)];
  if (block < 0) return first_copy(cell);
  const std::size_t b = bit({voxel[0] - at[0] * r, voxel[1] - at[1] * r, voxel[2] - at[2] * r});
  if (!get(inside_, block, b)) return -1;
  const std::int64_t labels = label_first_[static_cast<std::size_t>(block)];
  return first_copy(cell) + (labels < 0 ? 0 : labels_[static_cast<std::size_t>(labels) + b]);
}

bool FineVoxels::cut_above(const Voxel& voxel, int axis) const {
  if (!box_.contains(voxel)) return false;
  const std::int32_t r = box_.ratio;
  const Voxel at{voxel[0] / r, voxel[1] / r, voxel[2] / r};
  const std::int32_t cell = occupied_at(at[0], at[1], at[2]);
  if (cell < 0 || is_whole(cell)) return false;
  return get(cut_[static_cast<std::size_t>(axis)], block_[static_cast<std::size_t>(cell)],
             bit({voxel[0] - at[0] * r, voxel[1] - at[1] * r, voxel[2] - at[2] * r}));
}

bool FineVoxels::connected_above(const Voxel& voxel, int axis) const {
  if (!box_.contains(voxel)) return false;
  const auto a = static_cast<std::size_t>(axis);
  const std::int32_t r = box_.ratio;
  const Voxel at{voxel[0] / r, voxel[1] / r, voxel[2] / r};
  Voxel local{voxel[0] - at[0] * r, voxel[1] - at[1] * r, voxel[2] - at[2] * r};
  if (local[a] + 1 == r) {  // over to the next cell
    Voxel next = voxel;
    ++next[a];
    return inside(voxel) && inside(next) && !cut_above(voxel, axis);
  }
  const std::int32_t cell = occupied_at(at[0], at[1], at[2]);
  if (cell < 0) return false;
  const std::int32_t block = block_[static_cast<std::size_t>(cell)];
  if (block < 0) return true;
  const std::size_t lower = bit(local);
  ++local[a];
  return get(inside_, block, lower) && get(inside_, block, bit(local)) && !get(cut_[a], block, lower);
}

std::vector<std::int8_t> FineVoxels::winding_numbers(const Surface& surface, const LatticeSettings& settings,
                                                     int axis) {
  check_input(surface, settings);
  const Quantized quantized = quantize(surface, settings);
  const VoxelBox& box = quantized.box;
  const Crossings crossings = find_crossings(quantized.points, surface.triangles, box,
                                             count_crossings(quantized.points, surface.triangles, box));
  const auto a = static_cast<std::size_t>(axis);
  const std::size_t u = a == 0 ? 1 : 0, v = a == 2 ? 1 : 2;
  const CenterLines lines(crossings, a, box);
  std::vector<std::int8_t> result(static_cast<std::size_t>(box.voxels(0)) * static_cast<std::size_t>(box.voxels(1)) *
                                  static_cast<std::size_t>(box.voxels(2)));
  const auto width = static_cast<std::size_t>(box.voxels(static_cast<int>(v)));
  for (std::size_t line = 0; line < lines.count(); ++line)
    lines.walk(
        line,
        [&](std::int32_t from, std::int32_t to, int winding) {
          std::array<std::size_t, 3> at{};
          at[u] = line / width;
          at[v] = line % width;
          for (at[a] = static_cast<std::size_t>(from); at[a] < static_cast<std::size_t>(to); ++at[a])
            result[(at[0] * static_cast<std::size_t>(box.voxels(1)) + at[1]) * static_cast<std::size_t>(box.voxels(2)) +
                   at[2]] = static_cast<std::int8_t>(winding);
        },
        kIgnoreSegment);
  return result;
}

std::size_t FineVoxels::bytes() const {
  const auto size = [](const auto& v) { return v.capacity() * sizeof(v[0]); };
  return size(occupied_) + size(position_) + size(block_) + size(inside_) + size(cut_[0]) + size(cut_[1]) +
         size(cut_[2]) + size(copy_first_) + size(copy_voxels_) + size(label_first_) + size(labels_) +
         size(lattice_cell_) + size(inner_first_) + size(inner_) + size(neighbors_) + size(component_);
}

}  // namespace lappet
