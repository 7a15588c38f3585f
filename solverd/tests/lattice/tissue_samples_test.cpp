// The tissue of cells, wherever the lattice lies: not only by whole voxels.
#include "lattice/tissue_samples.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <span>

#include "test_surfaces.h"

namespace lappet {
namespace {

// No multiples of a voxel, but for the first.
const Vec3 kShifts[] = {Vec3(0, 0, 0), Vec3(0.1, 0.37, 0.62), Vec3(0.43, 0.055, 0.87), Vec3(0.91, 0.7, 0.31)};

LatticeSettings shifted(double spacing, const Vec3& shift) {
  LatticeSettings settings;
  settings.spacing = spacing;
  settings.origin = -spacing * shift;
  settings.fill_floor = 1e-6;
  return settings;
}

// Volume, center and mean square of the coordinates about it.
struct Whole {
  double volume = 0.0;
  Vec3 first = Vec3::Zero(), second = Vec3::Zero();

  Vec3 center() const { return first / volume; }
  Vec3 variance() const { return second / volume - center().cwiseAbs2(); }
};

Whole tissue_of(const Lattice& lattice) {
  Whole whole;
  const double h = lattice.settings.spacing;
  std::array<TissueSample, 8> found;
  for (std::size_t cell = 0; cell < lattice.cells(); ++cell) {
    const auto& [x, y, z] = lattice.cell_position(cell);
    const Vec3 middle = lattice.settings.origin + h * Vec3(x + 0.5, y + 0.5, z + 0.5);
    for (const TissueSample& sample : std::span(found).first(tissue_samples(lattice, cell, found))) {
      const double volume = h * h * h * sample.volume;
      const Vec3 center = middle + 0.5 * h * sample.center;
      whole.volume += volume;
      whole.first += volume * center;
      whole.second += volume * (center.cwiseAbs2() + (0.5 * h * sample.edges).cwiseAbs2() / 12.0);
    }
  }
  return whole;
}

double volume_by_fill(const Lattice& lattice) {
  double volume = 0.0;
  for (const float fill : lattice.cell_fill) volume += double(fill) * std::pow(lattice.settings.spacing, 3);
  return volume;
}

TEST(TissueSamples, ABoxHasItsVolumeCenterAndThicknessWhereverTheLatticeLies) {
  const Vec3 size(8.3, 6.1, 3.1);
  for (const double spacing : {2.0, 1.25, 1.0})
    for (const Vec3& shift : kShifts) {
      const Lattice lattice = build_lattice(test::box(Vec3::Zero(), size), shifted(spacing, shift));
      const Whole found = tissue_of(lattice);
      EXPECT_NEAR(found.volume / size.prod(), 1.0, 1e-3) << spacing << " " << shift.transpose();
      EXPECT_NEAR(volume_by_fill(lattice) / size.prod(), 1.0, 1e-3) << spacing << " " << shift.transpose();
      EXPECT_LT((found.center() - 0.5 * size).norm(), 1e-3 * spacing) << spacing << " " << shift.transpose();
      for (int axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(std::sqrt(12.0 * found.variance()[axis]) / size[axis], 1.0, 1e-3)
            << spacing << " " << shift.transpose() << " along " << axis;
    }
}

TEST(TissueSamples, ATurnedPlateHasItsVolumeAndThicknessWithin1Percent) {
  const Vec3 size(30, 24, 3);
  for (const auto& [degrees, axis] :
       {std::pair{15.0, Vec3(0, 0, 1)}, {30.0, Vec3(1, 0.3, 0)}, {45.0, Vec3(0, 1, 0)}, {35.0, Vec3(1, 1, 0.4)}}) {
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(degrees * std::numbers::pi / 180.0, axis.normalized()).toRotationMatrix();
    Surface plate = test::box(-0.5 * size, 0.5 * size);
    for (Vec3& point : plate.points) point = turn * point;
    for (const Vec3& shift : kShifts) {
      const Lattice lattice = build_lattice(plate, shifted(1.0, shift));
      const Whole found = tissue_of(lattice);
      EXPECT_NEAR(found.volume / size.prod(), 1.0, 0.01) << degrees << " " << shift.transpose();
      EXPECT_LT(found.center().norm(), 0.02) << degrees << " " << shift.transpose();
      // The trace does not turn.
      EXPECT_NEAR(found.variance().sum(), (size.cwiseAbs2() / 12.0).sum(), 0.01 * size.squaredNorm() / 12.0);
    }
  }
}

TEST(TissueSamples, ACutTakesItsWidthFromTheCellsOnEitherSide) {
  for (const double kerf : {0.01, 0.2, 0.5}) {
    const auto slab = test::cut_slab(12, 8, 4, {{5.5, 0}, {6.3, 8}}, kerf);
    const Lattice lattice = build_lattice(slab.surface, shifted(1.0, Vec3(0.2, 0, 0.1)));
    double volume = 0.0;
    for (const auto& t : slab.surface.triangles) {
      const Vec3 &a = slab.surface.points[t[0]], &b = slab.surface.points[t[1]], &c = slab.surface.points[t[2]];
      volume += a.dot(b.cross(c)) / 6.0;
    }
    EXPECT_NEAR(tissue_of(lattice).volume, volume, 0.03 * kerf * 8 * 4 + 0.1) << kerf;
    EXPECT_EQ(lattice.fragments, 2);
  }
}

TEST(TissueSamples, ACellThatTissueFillsIsWhole) {
  const Lattice lattice = build_lattice(test::box(Vec3::Zero(), Vec3(4, 3, 2)), shifted(0.5, Vec3::Zero()));
  for (const float fill : lattice.cell_fill) EXPECT_EQ(fill, 1.0F);
}

TEST(TissueSamples, TissueBeyondTheLastVoxelBelongsToTheCellBelow) {
  // The box ends 0.1 mm above a plane of the lattice, where a fine voxel of 0.25 mm has its center outside.
  const Lattice lattice = build_lattice(test::box(Vec3::Zero(), Vec3(4, 3, 2.1)), shifted(1.0, Vec3::Zero()));
  EXPECT_EQ(lattice.cells(), 4U * 3 * 2);
  for (std::size_t cell = 0; cell < lattice.cells(); ++cell)
    EXPECT_NEAR(lattice.cell_fill[cell], lattice.cell_position(cell)[2] == 1 ? 1.1 : 1.0, 1e-3);
}

}  // namespace
}  // namespace lappet
