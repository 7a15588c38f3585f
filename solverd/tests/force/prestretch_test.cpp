#include "force/materials/prestretch.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "lattice/refused.h"
#include "material_formulas.h"

namespace lappet {
namespace {

using Matrix = Eigen::Matrix3d;
using Vector = Eigen::Vector3d;

MaterialParameters skin(double along, double across) {
  MaterialParameters m;
  m.fiber_direction = Vector(1, 2, -0.5).normalized();
  m.prestretch = {along, across};
  return m;
}

TEST(Prestretch, StretchesAlongTheFibersAcrossThemInThePlaneAndByTheThirdUpright) {
  const auto m = skin(1.3, 1.1);
  const Vector d = m.fiber_direction, normal(0.3, 0.1, 2.0);
  const Vector across = normal.cross(d).normalized(), third = d.cross(across);
  const Matrix a = prestretch_matrix(m, normal, 0.7);
  EXPECT_LE((a - a.transpose()).norm(), 1e-15);
  EXPECT_LE((a * d - 1.3 * d).norm(), 1e-14);
  EXPECT_LE((a * across - 1.1 * across).norm(), 1e-14);
  EXPECT_LE((a * third - 0.7 * third).norm(), 1e-14);
}

TEST(Prestretch, OfOneAndOneIsTheIdentity) {
  EXPECT_LE((prestretch_matrix(skin(1.0, 1.0), Vector::UnitZ(), 1.0) - Matrix::Identity()).norm(), 1e-15);
}

TEST(Prestretch, DependsNeitherOnTheSignNorOnTheLengthOfNormalAndDirection) {
  auto m = skin(1.3, 0.9);
  const Vector normal(0.3, 0.1, 2.0);
  const Matrix a = prestretch_matrix(m, normal, 0.9);
  EXPECT_LE((prestretch_matrix(m, -1e-3 * normal, 0.9) - a).norm(), 1e-14);
  m.fiber_direction *= -2.0;
  EXPECT_LE((prestretch_matrix(m, normal, 0.9) - a).norm(), 1e-14);
}

// A sheet in the xy plane with fibers along x.
TEST(Prestretch, OfAFlatSheetIsDiagonal) {
  auto m = skin(1.25, 0.8);
  m.fiber_direction = Vector::UnitX();
  EXPECT_LE((prestretch_matrix(m, Vector::UnitZ(), 1.0) - Matrix(Vector(1.25, 0.8, 1.0).asDiagonal())).norm(), 1e-15);
}

TEST(Prestretch, IsRefusedWhereAcrossIsUndefinedOrAStretchIsNotPositive) {
  const auto m = skin(1.3, 0.9);
  EXPECT_THROW(prestretch_matrix(m, 3.0 * m.fiber_direction, 1.0), RefusedError);
  EXPECT_THROW(prestretch_matrix(m, Vector::Zero(), 1.0), RefusedError);
  EXPECT_THROW(prestretch_matrix(skin(0.0, 1.0), Vector::UnitZ(), 1.0), RefusedError);
  EXPECT_THROW(prestretch_matrix(skin(1.0, -1.0), Vector::UnitZ(), 1.0), RefusedError);
}

TEST(Prestretch, TheThirdStretchLeavesTheSkinsSurfaceFreeForEveryModelWithFibersToo) {
  for (const std::string_view model : MaterialModels::kNames)
    for (const double k1 : {0.0, 40.0}) {
      auto m = skin(1.3, 1.1);
      m.model = model;
      m.mooney_ratio = 0.5;
      m.fiber_k1 = k1;
      m.fiber_k2 = 2.0;
      m.fiber_dispersion = 0.2;
      const Vector normal = m.fiber_direction.cross(Vector(0.2, -0.3, 1));
      const double third = free_prestretch(m);
      const Matrix p = full_piola(m, prestretch_matrix(m, normal, third));
      EXPECT_LE((p * normal.normalized()).norm(), 1e-10 * m.youngs_modulus) << model << k1;
      EXPECT_GT((p * m.fiber_direction).norm(), 5.0) << model << k1;
    }
}

TEST(Prestretch, TheThirdStretchKeepsTheVolumeOfNearlyIncompressibleTissue) {
  auto m = skin(1.4, 1.2);
  m.poissons_ratio = 0.4999;
  EXPECT_NEAR(free_prestretch(m), 1 / (1.4 * 1.2), 1e-4);
  EXPECT_EQ(free_prestretch(skin(1.0, 1.0)), 1.0);
}

TEST(Prestretch, IsRefusedWhereCorotatedTissueWouldTurnInsideOut) {
  auto m = skin(2.0, 2.0);
  m.poissons_ratio = 0.49;
  EXPECT_NO_THROW(free_prestretch(m));
  m.model = "corotated";
  EXPECT_THROW(free_prestretch(m), RefusedError);
}

}  // namespace
}  // namespace lappet
