// Two families of fibers: half of each cell has the one, half the other.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "box.h"
#include "force/elastic/elastic.h"
#include "force/materials/cell_materials.h"
#include "force/materials/prestretch.h"
#include "lattice/lattice.h"
#include "material_formulas.h"

namespace lappet {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
const Vec3 kSize(6.0, 4.5, 3.0);

MaterialParameters skin(double angle) {
  MaterialParameters m;
  m.poissons_ratio = 0.4;
  m.fiber_direction = Vec3(1, 0.3, 0).normalized();
  m.fiber_k1 = 40.0;
  m.fiber_k2 = 0.8;
  m.fiber_dispersion = 0.1;
  m.fiber_slack = 1.03;
  m.fiber_angle = angle;
  return m;
}

MaterialParameters turned(MaterialParameters m, double degrees) {
  m.fiber_direction = Eigen::AngleAxisd(degrees * kDegree, Vec3::UnitZ()) * m.fiber_direction;
  m.fiber_angle = 0.0;
  return m;
}

Eigen::Matrix3d deformation() {
  Eigen::Matrix3d f;
  f << 1.25, 0.1, 0.02, -0.05, 1.1, 0.04, 0.03, -0.02, 0.8;
  return f;
}

// The upper side of the block: the skin, in whose plane the families lie.
Surface upper_side(const Surface& box) {
  Surface skin = box;
  std::erase_if(skin.triangles, [&](const auto& t) {
    return std::ranges::any_of(t, [&](Index p) { return box.points[p][2] < kSize[2]; });
  });
  return skin;
}

// A block under one deformation gradient: its energy, the force on its end x = 6, and what is measured in a cell.
struct Deformed {
  double energy = 0.0;
  Vec3 force = Vec3::Zero();
  CellMeasures measures{};
};

Deformed deform(const MaterialParameters& material, int quadrature, double activation = 0.0) {
  LatticeSettings settings;
  settings.spacing = 1.5;
  const Surface surface = box_surface(Vec3::Zero(), kSize);
  const Lattice lattice = build_lattice(surface, settings);
  Elastic<double> elastic(lattice, assign_materials(lattice, {material}, upper_side(surface), {}), quadrature);
  elastic.set_activation(std::vector<double>{activation});
  const std::size_t size = 3 * lattice.node_rest.size();
  std::vector<double> u(size), gradient(size), scale(size / 3);
  for (std::size_t n = 0; n < size / 3; ++n) {
    const Vec3 moved = (deformation() - Eigen::Matrix3d::Identity()) * lattice.node_rest[n];
    for (int i = 0; i < 3; ++i) u[3 * n + i] = moved[i];
  }
  Deformed found;
  found.energy = elastic.evaluate(u, gradient, scale).energy;
  for (std::size_t n = 0; n < size / 3; ++n)
    if (lattice.node_rest[n][0] > kSize[0] - 1e-9) found.force += Vec3(&gradient[3 * n]);
  found.measures = elastic.measures(0, u);
  return found;
}

TEST(FiberFamilies, HalfOfTheFibersPullAtTheAngleToEitherSide) {
  for (const int quadrature : {1, 8}) {
    const Deformed both = deform(skin(35.0), quadrature);
    const Deformed left = deform(turned(skin(0.0), 35.0), quadrature);
    const Deformed right = deform(turned(skin(0.0), -35.0), quadrature);
    EXPECT_NEAR(both.energy, 0.5 * (left.energy + right.energy), 1e-9 * both.energy);
    EXPECT_GT(std::abs(left.energy - right.energy), 0.02 * both.energy);
    const Eigen::Matrix3d stress = 0.5 * (full_piola(turned(skin(0.0), 35.0), deformation()) +
                                          full_piola(turned(skin(0.0), -35.0), deformation()));
    const Vec3 force = kSize[1] * kSize[2] * stress.col(0);
    EXPECT_NEAR((both.force - force).norm(), 0.0, 1e-6 * force.norm()) << both.force << "\n" << force;
  }
}

TEST(FiberFamilies, MuscleBelongsToThemToo) {
  MaterialParameters muscle = skin(25.0);
  muscle.fiber_k1 = 0.0;
  muscle.muscle_stress = 90.0;
  const Deformed both = deform(muscle, 1, 0.6);
  muscle.fiber_angle = 0.0;
  const Deformed left = deform(turned(muscle, 25.0), 1, 0.6), right = deform(turned(muscle, -25.0), 1, 0.6);
  EXPECT_NEAR((both.force - 0.5 * (left.force + right.force)).norm(), 0.0, 1e-9 * both.force.norm());
}

TEST(FiberFamilies, AtARightAngleAreOneFamilyAcross) {
  const Deformed both = deform(skin(90.0), 1), one = deform(turned(skin(0.0), 90.0), 1);
  EXPECT_NEAR(both.energy, one.energy, 1e-9 * one.energy);
  EXPECT_NEAR((both.force - one.force).norm(), 0.0, 1e-9 * one.force.norm());
}

TEST(FiberFamilies, TheStressInACellIsThatOfBoth) {
  const Eigen::Matrix3d f = deformation();
  const Eigen::Matrix3d piola =
      0.5 * (full_piola(turned(skin(0.0), 35.0), f) + full_piola(turned(skin(0.0), -35.0), f));
  const Eigen::Matrix3d cauchy = piola * f.transpose() / f.determinant();
  const double tension = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(cauchy).eigenvalues()[2];
  for (const int quadrature : {1, 8})
    EXPECT_NEAR(deform(skin(35.0), quadrature).measures.tension, tension, 1e-6 * tension);
}

TEST(FiberFamilies, ThePrestretchAcrossTheSkinLeavesNothingThatPressesOnIt) {
  MaterialParameters m = skin(35.0);
  m.prestretch = {1.2, 1.1};
  const double third = free_prestretch(m);
  const Eigen::Matrix3d a = prestretch_matrix(m, Vec3::UnitZ(), third);
  const Eigen::Matrix3d stress =
      0.5 * (full_piola(turned(skin(0.0), 35.0), a) + full_piola(turned(skin(0.0), -35.0), a));
  EXPECT_NEAR(stress(2, 2), 0.0, 1e-9 * stress.norm());
  EXPECT_GT(std::abs(third - free_prestretch(turned(m, 0.0))), 1e-4);
}

TEST(FiberFamilies, OnlyTheirCellsAreSplit) {
  LatticeSettings settings;
  settings.spacing = 1.5;
  const Surface surface = box_surface(Vec3::Zero(), kSize);
  const Lattice lattice = build_lattice(surface, settings);
  EXPECT_TRUE(assign_materials(lattice, {skin(0.0)}, surface, {}).shares.empty());
  MaterialParameters plain = skin(35.0);
  plain.fiber_k1 = 0.0;
  EXPECT_TRUE(assign_materials(lattice, {plain}, surface, {}).shares.empty());
  const CellMaterials split = assign_materials(lattice, {skin(35.0)}, surface, {});
  ASSERT_EQ(split.shares.size(), 2 * lattice.cell_nodes.size());
  EXPECT_DOUBLE_EQ(split.density(0), 1100.0);
}

}  // namespace
}  // namespace lappet
