#include "force/prestretch.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "lattice/refused.h"

namespace lappet {
namespace {

using Matrix = Eigen::Matrix3d;
using Vector = Eigen::Vector3d;

MaterialParameters skin(double along, double across) {
  MaterialParameters m;
  m.fibre_direction = Vector(1, 2, -0.5).normalized();
  m.prestretch = {along, across};
  return m;
}

TEST(Prestretch, StretchesAlongTheFibresAcrossThemInThePlaneAndKeepsTheVolume) {
  const auto m = skin(1.3, 1.1);
  const Vector d = m.fibre_direction, normal(0.3, 0.1, 2.0);
  const Vector across = normal.cross(d).normalized(), third = d.cross(across);
  const Matrix a = prestretch_matrix(m, normal);
  EXPECT_LE((a - a.transpose()).norm(), 1e-15);
  EXPECT_NEAR(a.determinant(), 1.0, 1e-14);
  EXPECT_LE((a * d - 1.3 * d).norm(), 1e-14);
  EXPECT_LE((a * across - 1.1 * across).norm(), 1e-14);
  EXPECT_LE((a * third - third / 1.43).norm(), 1e-14);
}

TEST(Prestretch, OfOneAndOneIsTheIdentity) {
  EXPECT_LE((prestretch_matrix(skin(1.0, 1.0), Vector::UnitZ()) - Matrix::Identity()).norm(), 1e-15);
}

TEST(Prestretch, DependsNeitherOnTheSignNorOnTheLengthOfNormalAndDirection) {
  auto m = skin(1.3, 0.9);
  const Vector normal(0.3, 0.1, 2.0);
  const Matrix a = prestretch_matrix(m, normal);
  EXPECT_LE((prestretch_matrix(m, -1e-3 * normal) - a).norm(), 1e-14);
  m.fibre_direction *= -2.0;
  EXPECT_LE((prestretch_matrix(m, normal) - a).norm(), 1e-14);
}

// A sheet in the xy plane with fibres along x.
TEST(Prestretch, OfAFlatSheetIsDiagonal) {
  auto m = skin(1.25, 0.8);
  m.fibre_direction = Vector::UnitX();
  EXPECT_LE((prestretch_matrix(m, Vector::UnitZ()) - Matrix(Vector(1.25, 0.8, 1.0).asDiagonal())).norm(), 1e-15);
}

TEST(Prestretch, IsRefusedWhereAcrossIsUndefinedOrAStretchIsNotPositive) {
  const auto m = skin(1.3, 0.9);
  EXPECT_THROW(prestretch_matrix(m, 3.0 * m.fibre_direction), RefusedError);
  EXPECT_THROW(prestretch_matrix(m, Vector::Zero()), RefusedError);
  EXPECT_THROW(prestretch_matrix(skin(0.0, 1.0), Vector::UnitZ()), RefusedError);
  EXPECT_THROW(prestretch_matrix(skin(1.0, -1.0), Vector::UnitZ()), RefusedError);
}

}  // namespace
}  // namespace lappet
