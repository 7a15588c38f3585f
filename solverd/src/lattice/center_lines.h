// The lines of voxel centers along one axis, each with its crossings from low to high.
#pragma once
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lattice/crossings.h"
#include "lattice/voxel_box.h"

namespace lappet {

// The crossings of one axis, line by line from low to high.
class CenterLines {
 public:
  CenterLines(const Crossings& crossings, std::size_t axis, const VoxelBox& box)
      : crossings_(crossings.all), axis_(axis), u_(axis == 0 ? 1 : 0), v_(axis == 2 ? 1 : 2) {
    width_ = box.voxels(v_);
    first_.assign(box.voxels(u_) * width_ + 1, 0);
    for (const Crossing& c : crossings_)
      if (c.axis == axis_) ++first_[line_of(c) + 1];
    for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
    order_.resize(first_.back());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::size_t i = 0; i < crossings_.size(); ++i)
      if (crossings_[i].axis == axis_) order_[next[line_of(crossings_[i])]++] = std::uint32_t(i);
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

  // Calls run(first, last + 1, winding) along a line for the voxels between crossings where the winding is not zero,
  // and segment(lower, crossings, winding before, winding after) for every crossed segment. Returns the winding at the
  // end: 0 for a closed surface.
  template <class Run, class Segment>
  int walk(std::size_t line, const Run& run, const Segment& segment) const {
    const auto list = on(line);
    int winding = 0;
    std::int32_t from = 0;
    for (std::size_t i = 0; i < list.size();) {
      const Index lower = crossings_[list[i]].lower[axis_];
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
  std::size_t line_of(const Crossing& c) const { return c.lower[u_] * width_ + c.lower[v_]; }
  const std::vector<Crossing>& crossings_;
  std::size_t axis_, u_, v_;
  std::int64_t width_ = 0;
  std::vector<std::uint32_t> first_, order_;
};

// For a walk that needs the runs only.
inline constexpr auto kIgnoreSegment = [](std::int32_t, std::span<const std::uint32_t>, int, int) {};

}  // namespace lappet
