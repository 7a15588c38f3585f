#include "lattice/voxel_tree.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <set>

namespace lappet {
namespace {

// Voxels along the lines of a slanted plane, some of them absent.
std::vector<PackedVoxel> slanted(int rows, int columns) {
  std::vector<PackedVoxel> voxels;
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j)
      voxels.push_back((i * columns + j) % 11 == 4 ? PackedVoxel() : PackedVoxel(Voxel{i, j, 2 + (2 * i + j) / 5}));
  return voxels;
}

TEST(VoxelTree, MeetsTheNearestVoxelsWhereverThePointLies) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> draw(-10.0, 60.0);
  for (const auto& voxels : {slanted(1, 1), slanted(1, 9), slanted(7, 31), slanted(45, 40)}) {
    const VoxelTree tree(voxels);
    for (int trial = 0; trial < 200; ++trial) {
      const Vec3 point(draw(random), draw(random), draw(random));
      double nearest = std::numeric_limits<double>::infinity();
      for (const Voxel voxel : voxels)
        if (voxel[0] >= 0) nearest = std::min(nearest, (VoxelTree::center(voxel) - point).norm());
      double found = std::numeric_limits<double>::infinity();
      tree.visit_nearest(voxels, point, found, [&](const Voxel& voxel) {
        EXPECT_GE(voxel[0], 0);
        return found = std::min(found, (VoxelTree::center(voxel) - point).norm());
      });
      EXPECT_EQ(found, nearest);
    }
  }
}

TEST(VoxelTree, MeetsAllVoxelsWithinADistanceAndNoneBeyond) {
  const auto voxels = slanted(30, 30);
  const VoxelTree tree(voxels);
  const Vec3 point(12.3, 14.1, 9.0);
  constexpr double kWithin = 6.5;
  std::set<Voxel> expected, met;
  for (const Voxel voxel : voxels)
    if (voxel[0] >= 0 && (VoxelTree::center(voxel) - point).norm() <= kWithin) expected.insert(voxel);
  tree.visit_nearest(voxels, point, kWithin, [&](const Voxel& voxel) {
    met.insert(voxel);
    return kWithin;
  });
  EXPECT_EQ(met, expected);
  EXPECT_GT(met.size(), 50u);
}

}  // namespace
}  // namespace lappet
