#include "math/svd3.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "math/symmetric_eigen3.h"

namespace lappet {
namespace {

template <class Number>
using Matrix = Eigen::Matrix<Number, 3, 3, Eigen::RowMajor>;

template <class Number>
void expect_decomposition(const Matrix<Number>& f, double tolerance) {
  Number in[9], u[9], sigma[3], v[9];
  Eigen::Map<Matrix<Number>>{in} = f;
  svd3(in, u, sigma, v);
  const Eigen::Matrix3d uu = Eigen::Map<Matrix<Number>>(u).template cast<double>(),
                        vv = Eigen::Map<Matrix<Number>>(v).template cast<double>();
  const Eigen::Vector3d s(sigma[0], sigma[1], sigma[2]);
  const double size = std::max(f.template cast<double>().norm(), 1e-30);
  EXPECT_LE((uu * s.asDiagonal() * vv.transpose() - f.template cast<double>()).norm(), tolerance * size) << f;
  EXPECT_LE((uu.transpose() * uu - Eigen::Matrix3d::Identity()).norm(), 4 * tolerance);
  EXPECT_LE((vv.transpose() * vv - Eigen::Matrix3d::Identity()).norm(), 4 * tolerance);
  EXPECT_GT(uu.determinant(), 0.5);
  EXPECT_GT(vv.determinant(), 0.5);
  EXPECT_GE(s[0] * (1 + tolerance), s[1]);
  EXPECT_GE(s[1] + tolerance * size, std::abs(s[2]));
  Eigen::Vector3d expected = Eigen::JacobiSVD<Eigen::Matrix3d>(f.template cast<double>()).singularValues();
  if (f.template cast<double>().determinant() < 0) expected[2] = -expected[2];
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(std::abs(s[i]), std::abs(expected[i]), tolerance * size);
}

template <class Number>
void expect_all(double tolerance) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const auto matrix = [&] {
    Matrix<Number> m;
    for (int i = 0; i < 9; ++i) m.data()[i] = Number(normal(random));
    return m;
  };
  for (int k = 0; k < 2000; ++k) {
    const Matrix<Number> m = matrix();
    expect_decomposition<Number>(m, tolerance);                                              // random, half inverted
    expect_decomposition<Number>(Matrix<Number>::Identity() + Number(1e-3) * m, tolerance);  // near rest
    Matrix<Number> flat = m;
    flat.row(2) = flat.row(1) * Number(1 + 1e-5 * k);
    expect_decomposition<Number>(flat, tolerance);                                 // nearly singular
    expect_decomposition<Number>(Matrix<Number>(m.col(0) * m.row(1)), tolerance);  // rank one
    const Eigen::Quaternion<Number> q(Eigen::Vector4d::Random().cast<Number>());
    expect_decomposition<Number>(Number(0.3 + k % 5) * Matrix<Number>(q.normalized().toRotationMatrix()), tolerance);
  }
  expect_decomposition<Number>(Matrix<Number>::Zero(), tolerance);
  expect_decomposition<Number>(Matrix<Number>(-Matrix<Number>::Identity()), tolerance);
}

TEST(Svd3, RebuildsEveryKindOfMatrixInFloat) { expect_all<float>(3e-6); }
TEST(Svd3, RebuildsEveryKindOfMatrixInDouble) { expect_all<double>(1e-14); }

TEST(SymmetricEigen3, DefinitePartHasTheClampedEigenvalues) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 1000; ++k) {
    double a[6];
    for (double& value : a) value = normal(random);
    Eigen::Matrix3d m;
    m << a[0], a[1], a[2], a[1], a[3], a[4], a[2], a[4], a[5];
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(m);
    for (const bool absolute : {false, true}) {
      double b[6];
      std::copy(a, a + 6, b);
      make_definite3(b, 1e-3, absolute);
      Eigen::Matrix3d result;
      result << b[0], b[1], b[2], b[1], b[3], b[4], b[2], b[4], b[5];
      Eigen::Vector3d values = solver.eigenvalues();
      for (double& value : values) value = std::max(absolute ? std::abs(value) : value, 1e-3);
      const Eigen::Matrix3d expected = solver.eigenvectors() * values.asDiagonal() * solver.eigenvectors().transpose();
      EXPECT_LE((result - expected).norm(), 1e-12);
    }
  }
}

}  // namespace
}  // namespace lappet
