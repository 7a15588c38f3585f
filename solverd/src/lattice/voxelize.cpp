#include "lattice/voxelize.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

#include "lattice/crossings.h"
#include "lattice/memory_estimate.h"
#include "lattice/refused.h"
#include "lattice/surface_parts.h"

namespace lappet {
namespace {

constexpr std::uint16_t kNoLabel = 0xFFFF;
constexpr int kLargestRatio = 32;  // r^3 labels fit 16 bits

std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%g", value);
  return text.data();
}

[[noreturn]] void refuse(const std::string& sentence) { throw RefusedError(ErrorCode::kInvalidInput, sentence); }

void check_input(const Surface& surface, const LatticeSettings& settings) {
  if (!(std::isfinite(settings.spacing) && settings.spacing > 0.0))
    refuse("The lattice spacing is " + number(settings.spacing) + " mm; give a positive number.");
  if (settings.fine_ratio < 1 || settings.fine_ratio > kLargestRatio)
    refuse("The fine ratio is " + std::to_string(settings.fine_ratio) + "; give 1 to " + std::to_string(kLargestRatio) +
           " voxels per cell edge (4 to 10 are usual).");
  if (!(std::isfinite(settings.fill_floor) && settings.fill_floor > 0.0 && settings.fill_floor <= 1.0))
    refuse("The least fill of a cell is " + number(settings.fill_floor) + "; give a fraction above 0 and at most 1.");
  if (!settings.origin.allFinite()) refuse("The lattice origin is not finite; give three numbers in mm.");
  if (surface.points.empty() || surface.triangles.empty()) refuse("The tissue surface is empty; give a closed mesh.");
  for (std::size_t i = 0; i < surface.points.size(); ++i)
    if (!surface.points[i].allFinite())
      refuse("Point " + std::to_string(i) + " of the tissue surface is not finite (" + number(surface.points[i].x()) +
             ", " + number(surface.points[i].y()) + ", " + number(surface.points[i].z()) + "); remove or repair it.");
  const auto count = static_cast<std::int64_t>(surface.points.size());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    for (const std::int32_t p : surface.triangles[t])
      if (p < 0 || p >= count)
        refuse("Triangle " + std::to_string(t) + " of the tissue surface names point " + std::to_string(p) +
               ", but there are " + std::to_string(count) + " points.");
}

// The points in steps relative to the box that holds them.
struct Quantized {
  VoxelBox box;
  std::vector<StepPoint> points;
};

Quantized quantize(const Surface& surface, const LatticeSettings& settings) {
  Quantized result;
  const std::int64_t cell = settings.fine_ratio * kSteps;
  result.points.resize(surface.points.size());
  StepPoint low, high;
  low.fill(std::numeric_limits<std::int64_t>::max());
  high.fill(std::numeric_limits<std::int64_t>::min());
  for (std::size_t i = 0; i < surface.points.size(); ++i)
    for (std::size_t a = 0; a < 3; ++a) {
      const auto axis = static_cast<Eigen::Index>(a);
      const double steps =
          (surface.points[i][axis] - settings.origin[axis]) / settings.spacing * static_cast<double>(cell);
      if (std::abs(steps) > 1e15)
        refuse("Point " + std::to_string(i) + " of the tissue surface lies " +
               number(surface.points[i][axis] - settings.origin[axis]) +
               " mm from the lattice origin, too far for this spacing; move the origin to the tissue.");
      result.points[i][a] = std::llround(steps);
      low[a] = std::min(low[a], result.points[i][a]);
      high[a] = std::max(high[a], result.points[i][a]);
    }
  result.box.ratio = settings.fine_ratio;
  StepPoint shift;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto first = static_cast<std::int64_t>(std::floor(static_cast<double>(low[a]) / static_cast<double>(cell)));
    const auto last = static_cast<std::int64_t>(std::ceil(static_cast<double>(high[a]) / static_cast<double>(cell)));
    if (std::max(std::abs(first), std::abs(last)) > std::numeric_limits<std::int32_t>::max() / kLargestRatio)
      refuse("The tissue lies too far from the lattice origin for a spacing of " + number(settings.spacing) +
             " mm; move the origin to the tissue.");
    result.box.low[a] = static_cast<std::int32_t>(first);
    result.box.cells[a] = static_cast<std::int32_t>(std::max<std::int64_t>(1, last - first));
    shift[a] = first * cell;
  }
  for (StepPoint& p : result.points)
    for (std::size_t a = 0; a < 3; ++a) p[a] -= shift[a];
  return result;
}

// The crossings of one axis, line by line from low to high.
class Lines {
 public:
  Lines(const Crossings& crossings, std::size_t axis, const VoxelBox& box)
      : crossings_(crossings.all), axis_(axis), u_(axis == 0 ? 1 : 0), v_(axis == 2 ? 1 : 2) {
    width_ = box.voxels(static_cast<int>(v_));
    first_.assign(static_cast<std::size_t>(std::int64_t{box.voxels(static_cast<int>(u_))} * width_) + 1, 0);
    for (const Crossing& c : crossings_)
      if (c.axis == axis_) ++first_[line_of(c) + 1];
    for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
    order_.resize(first_.back());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::size_t i = 0; i < crossings_.size(); ++i)
      if (crossings_[i].axis == axis_) order_[next[line_of(crossings_[i])]++] = static_cast<std::uint32_t>(i);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count(), 4096), [&](const auto& range) {
      for (std::size_t line = range.begin(); line != range.end(); ++line) {
        // Crossings at one place: entering ones last, so that coincident walls leave the tissue before they enter it.
        std::sort(order_.begin() + first_[line], order_.begin() + first_[line + 1],
                  [&](std::uint32_t i, std::uint32_t j) {
                    const Crossing &a = crossings_[i], &b = crossings_[j];
                    if (a.lower[axis_] != b.lower[axis_]) return a.lower[axis_] < b.lower[axis_];
                    if (a.fraction != b.fraction) return a.fraction < b.fraction;
                    return a.winding != b.winding ? a.winding < b.winding : i < j;
                  });
      }
    });
  }

  std::size_t count() const { return first_.size() - 1; }
  std::span<const std::uint32_t> on(std::size_t line) const {
    return {order_.data() + first_[line], first_[line + 1] - first_[line]};
  }
  std::span<const std::uint32_t> on(std::int32_t u, std::int32_t v) const {
    return on(static_cast<std::size_t>(std::int64_t{u} * width_ + v));
  }

  // Calls run(first, last + 1, winding) along a line for the voxels between crossings where the winding is not zero,
  // and segment(lower, crossings, winding before, winding after) for every crossed segment. Returns the winding at the
  // end: 0 for a closed surface.
  template <class Run, class Segment>
  int walk(std::size_t line, const Run& run, const Segment& segment) const {
    const auto list = on(line);
    int winding = 0;
    std::int32_t from = 0;
    for (std::size_t i = 0; i < list.size();) {
      const std::int32_t lower = crossings_[list[i]].lower[axis_];
      std::size_t j = i;
      int after = winding;
      for (; j < list.size() && crossings_[list[j]].lower[axis_] == lower; ++j) after += crossings_[list[j]].winding;
      if (winding != 0 && from <= lower) run(from, lower + 1, winding);
      segment(lower, list.subspan(i, j - i), winding, after);
      winding = after;
      from = lower + 1;
      i = j;
    }
    return winding;
  }

 private:
  std::size_t line_of(const Crossing& c) const {
    return static_cast<std::size_t>(std::int64_t{c.lower[u_]} * width_ + c.lower[v_]);
  }
  const std::vector<Crossing>& crossings_;
  std::size_t axis_, u_, v_;
  std::int64_t width_ = 0;
  std::vector<std::uint32_t> first_, order_;
};

constexpr auto kIgnoreSegment = [](std::int32_t, std::span<const std::uint32_t>, int, int) {};

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
  void mark_whole(const Lines& z_lines) {
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
    for (std::int32_t x = 0; x < out.box_.cells[0]; ++x)
      for (std::int32_t y = 0; y < out.box_.cells[1]; ++y)
        for (std::int32_t z = 0; z < out.box_.cells[2]; ++z) {
          std::int32_t& number = place({x, y, z});
          if (number == kEmpty) continue;
          out.block_.push_back(number == kTouched ? blocks++ : -1);
          number = static_cast<std::int32_t>(out.position_.size());
          out.position_.push_back({x, y, z});
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
  bool sweep(const Lines& lines, std::size_t axis, std::size_t& open_line) {
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
                out.inner_[i] = voxel;
                break;
              }
          if (after > 0)
            for (std::size_t k = list.size(); k-- > 0;)
              if (crossings.all[list[k]].winding > 0) {
                ++voxel[axis];
                out.inner_[list[k]] = voxel;
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
    each_touched([&](std::size_t c, std::int32_t block, Scratch& local) {
      count[c] = label(block, local.labels, local.stack, local.sizes);
    });
    out.copy_first_.assign(cells + 1, 0);
    std::int64_t labelled = 0;
    for (std::size_t c = 0; c < cells; ++c) {
      out.copy_first_[c + 1] = out.copy_first_[c] + count[c];
      if (out.block_[c] >= 0 && count[c] > 1)
        out.label_first_[static_cast<std::size_t>(out.block_[c])] = std::int64_t{r} * r * r * labelled++;
    }
    out.copy_voxels_.assign(static_cast<std::size_t>(out.copy_first_.back()), r * r * r);
    out.labels_.resize(static_cast<std::size_t>(std::int64_t{r} * r * r * labelled));
    each_touched([&](std::size_t c, std::int32_t block, Scratch& local) {
      label(block, local.labels, local.stack, local.sizes);
      std::copy(local.sizes.begin(), local.sizes.end(), out.copy_voxels_.begin() + out.copy_first_[c]);
      const std::int64_t first = out.label_first_[static_cast<std::size_t>(block)];
      if (first >= 0) std::copy(local.labels.begin(), local.labels.end(), out.labels_.begin() + first);
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
  inner_.assign(builder.crossings.all.size(), Voxel{-1, -1, -1});
  builder.mark_touched();
  for (const std::size_t axis : {std::size_t{2}, std::size_t{1}, std::size_t{0}}) {
    const Lines lines(builder.crossings, axis, box_);
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
  lattice_cell_.assign(static_cast<std::size_t>(copy_count()), -1);

  SurfaceParts parts = find_parts(surface);
  neighbours_ = std::move(parts.neighbours);
  part_ = std::move(parts.part);
  part_count_ = parts.count;
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
  Voxel next = voxel;
  ++next[static_cast<std::size_t>(axis)];
  return inside(voxel) && inside(next) && !cut_above(voxel, axis);
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
  const Lines lines(crossings, a, box);
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
         size(lattice_cell_) + size(inner_first_) + size(inner_) + size(neighbours_) + size(part_);
}

}  // namespace lappet
