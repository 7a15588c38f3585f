// Looks for voxels near a point among the inner voxels of one triangle, which follow the lines of the grid: boxes
// around every eight that follow each other, around every eight of these, and so on. 1.7 bytes a voxel.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "lattice/surface.h"
#include "lattice/voxel_box.h"

namespace lappet {

class VoxelTree {
 public:
  VoxelTree() = default;
  explicit VoxelTree(std::span<const PackedVoxel> voxels) {
    std::vector<Box>& leaves = levels_.emplace_back((voxels.size() + kFan - 1) / kFan);
    for (std::size_t i = 0; i < voxels.size(); ++i)
      if (const Voxel voxel = voxels[i]; voxel[0] >= 0)
        for (std::size_t a = 0; a < 3; ++a) leaves[i / kFan].include(a, voxel[a], voxel[a]);
    while (levels_.back().size() > 1) {
      const std::vector<Box>& below = levels_.back();
      std::vector<Box> above((below.size() + kFan - 1) / kFan);
      for (std::size_t i = 0; i < below.size(); ++i)
        for (std::size_t a = 0; a < 3; ++a) above[i / kFan].include(a, below[i].low[a], below[i].high[a]);
      levels_.push_back(std::move(above));
    }
  }

  static Vec3 center(const Voxel& voxel) { return Vec3(voxel[0] + 0.5, voxel[1] + 0.5, voxel[2] + 0.5); }

  // Rounded down, so that what only touches the distance is still looked at.
  static bool beyond(double squared, double within) { return squared * (1.0 - 1e-12) > within * within; }

  // Calls look(voxel), which returns the distance beyond which nothing matters any longer, for all voxels whose centers
  // lie within that distance of the point, roughly in order of distance. `voxels`: as they were given.
  template <class Look>
  void visit_nearest(std::span<const PackedVoxel> voxels, const Vec3& point, double within, const Look& look) const {
    visit(levels_.size(), 0, voxels, point, within, look);
  }

 private:
  static constexpr std::size_t kFan = 8;
  struct Box {
    std::array<std::uint16_t, 3> low{0xFFFF, 0xFFFF, 0xFFFF}, high{0, 0, 0};  // empty
    template <class Number>
    void include(std::size_t axis, Number from, Number to) {
      low[axis] = std::min(low[axis], std::uint16_t(from));
      high[axis] = std::max(high[axis], std::uint16_t(to));
    }
    double squared_distance(const Vec3& point) const {
      double sum = 0.0;
      for (std::size_t a = 0; a < 3; ++a) {
        const double at = point[a] - 0.5;
        const double out = std::max({0.0, low[a] - at, at - high[a]});
        sum += out * out;
      }
      return sum;
    }
  };

  // Looks at the members of box `index` of level `level - 1`; at all of them for the level above the top.
  template <class Look>
  void visit(std::size_t level, std::size_t index, std::span<const PackedVoxel> voxels, const Vec3& point,
             double& within, const Look& look) const {
    if (level == 0) {
      for (const Voxel voxel : voxels.subspan(kFan * index, std::min(kFan, voxels.size() - kFan * index)))
        if (voxel[0] >= 0 && !beyond((center(voxel) - point).squaredNorm(), within)) within = look(voxel);
      return;
    }
    const std::vector<Box>& boxes = levels_[level - 1];
    const std::size_t first = kFan * index, count = std::min(kFan, boxes.size() - first);
    std::array<std::pair<double, std::size_t>, kFan> order;
    for (std::size_t i = 0; i < count; ++i) order[i] = {boxes[first + i].squared_distance(point), first + i};
    std::sort(order.begin(), order.begin() + count);
    for (std::size_t i = 0; i < count && !beyond(order[i].first, within); ++i)
      visit(level - 1, order[i].second, voxels, point, within, look);
  }

  std::vector<std::vector<Box>> levels_;  // from the leaves up
};

}  // namespace lappet
