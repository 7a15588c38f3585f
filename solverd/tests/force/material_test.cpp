#include "force/materials/material.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <random>
#include <vector>

#include "force/materials/material_models.h"
#include "math/svd3.h"

namespace lappet {
namespace {

using Matrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using Vector = Eigen::Vector3d;

template <class List>
struct TypesOf;
template <class... Models>
struct TypesOf<MaterialModelList<Models...>> {
  using Type = ::testing::Types<Models...>;
};

template <class Model>
class Materials : public ::testing::Test {};
using Models = TypesOf<MaterialModels>::Type;
TYPED_TEST_SUITE(Materials, Models);

constexpr int kIndex[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
constexpr double kMu = 3.0, kLambda = 11.0;
constexpr Moduli<double> kModuli{kMu, kLambda, 0.4};
constexpr Moduli<double> kNearlyIncompressible{17.0, 1700.0, 0.4};  // Poisson's ratio 0.495

// The order that svd3 gives: descending magnitudes, only the last of any sign. Random, inverted, flattened (one or two
// values near or at zero), and with two or three equal values.
std::vector<Vector> stretches() {
  std::vector<Vector> all{{1, 1, 1},          {1.3, 1.3, 1.3},      {0.6, 0.6, 0.6},     {1.4, 1.4, 0.8},
                          {1.4, 0.8, 0.8},    {1.2, 0.7, -0.7},     {1, 1, 0},           {1, 1, -1},
                          {0.9, 0.9, 1e-5},   {0.9, 0.9, -1e-5},    {1.3, 2e-3, 1e-3},   {1.3, 2e-3, -1e-3},
                          {0.02, 0.02, 0.02}, {0.02, 0.015, -0.01}, {3.0, 2.0, 1.0},     {2.0, 1.0, 0.1 + 1e-4},
                          {2.0, 1.0, 0.0999}, {1.1, 1.1 - 1e-9, 1}, {1, 1e-2, 1e-2 / 3}, {4.0, 0.5, 0.5}};
  std::mt19937 random(5);
  std::uniform_real_distribution<double> stretch(0.4, 1.9);
  for (int k = 0; k < 300; ++k) {
    Vector s(stretch(random), stretch(random), stretch(random));
    std::sort(s.data(), s.data() + 3, std::greater<>());
    if (k % 3 == 0) s[2] *= -0.3;
    if (k % 7 == 0) s[2] *= 1e-3;
    all.push_back(s);
  }
  return all;
}

template <class Model>
double energy(const Vector& v, const Moduli<double>& m) {
  const double s[3] = {v[0], v[1], v[2]};
  return Model::energy(s, m);
}
template <class Model>
Vector p_hat(const Vector& v, const Moduli<double>& m) {
  const double s[3] = {v[0], v[1], v[2]};
  double p[3];
  Model::p_hat(s, m, p);
  return {p[0], p[1], p[2]};
}
template <class Model>
TangentHat<double> tangent(const Vector& v, const Moduli<double>& m) {
  const double s[3] = {v[0], v[1], v[2]};
  TangentHat<double> t;
  Model::dpdf_hat(s, m, t);
  return t;
}
Matrix apply(const TangentHat<double>& t, const Matrix& d) {
  Matrix out;
  for (int i = 0; i < 3; ++i)
    out(i, i) =
        t.hessian[kIndex[i][0]] * d(0, 0) + t.hessian[kIndex[i][1]] * d(1, 1) + t.hessian[kIndex[i][2]] * d(2, 2);
  for (int k = 0; k < 3; ++k) {
    const int i = kTangentPairs[k][0], j = kTangentPairs[k][1];
    const double even = t.stretch[k] * 0.5 * (d(i, j) + d(j, i)), odd = t.rotation[k] * 0.5 * (d(i, j) - d(j, i));
    out(i, j) = even + odd;
    out(j, i) = even - odd;
  }
  return out;
}
double largest(const TangentHat<double>& t) {
  double size = 0;
  for (const double x : t.hessian) size = std::max(size, std::abs(x));
  for (int k = 0; k < 3; ++k) size = std::max({size, std::abs(t.stretch[k]), std::abs(t.rotation[k])});
  return size;
}
template <class Model>
Matrix piola(const Matrix& f, const Moduli<double>& m) {
  double in[9], u[9], s[3], v[9];
  Eigen::Map<Matrix>{in} = f;
  svd3(in, u, s, v);
  const Vector p = p_hat<Model>({s[0], s[1], s[2]}, m);
  return Eigen::Map<Matrix>(u) * p.asDiagonal() * Eigen::Map<Matrix>(v).transpose();
}
Matrix random_rotation(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
      .normalized()
      .toRotationMatrix();
}

TYPED_TEST(Materials, StressIsTheDerivativeOfTheEnergy) {
  for (const auto& m : {kModuli, kNearlyIncompressible})
    for (const Vector& s : stretches()) {
      const Vector p = p_hat<TypeParam>(s, m);
      for (int i = 0; i < 3; ++i) {
        const Vector step = 1e-6 * Vector::Unit(i);
        const double quotient = (energy<TypeParam>(s + step, m) - energy<TypeParam>(s - step, m)) / 2e-6;
        EXPECT_NEAR(quotient, p[i], 1e-6 * (1 + p.norm()) + 1e-9 * energy<TypeParam>(s, m)) << s.transpose();
      }
    }
}

TYPED_TEST(Materials, HessianIsTheDerivativeOfTheStress) {
  for (const auto& m : {kModuli, kNearlyIncompressible})
    for (const Vector& s : stretches()) {
      const auto t = tangent<TypeParam>(s, m);
      for (int j = 0; j < 3; ++j) {
        const Vector step = 1e-6 * Vector::Unit(j);
        const Vector quotient = (p_hat<TypeParam>(s + step, m) - p_hat<TypeParam>(s - step, m)) / 2e-6;
        for (int i = 0; i < 3; ++i)
          EXPECT_NEAR(quotient[i], t.hessian[kIndex[i][j]], 2e-5 * (1 + largest(t))) << s.transpose();
      }
    }
}

TYPED_TEST(Materials, StretchAndRotationModesAreTheQuotientsWhereThoseAreDefined) {
  for (const auto& m : {kModuli, kNearlyIncompressible})
    for (const Vector& s : stretches()) {
      const auto t = tangent<TypeParam>(s, m);
      const Vector p = p_hat<TypeParam>(s, m);
      for (int k = 0; k < 3; ++k) {
        const int i = kTangentPairs[k][0], j = kTangentPairs[k][1];
        if (std::abs(s[i] - s[j]) > 1e-3) {
          EXPECT_NEAR(t.stretch[k], (p[i] - p[j]) / (s[i] - s[j]), 1e-9 * (1 + largest(t))) << s.transpose();
        }
        if (std::abs(s[i] + s[j]) > 1e-3) {
          EXPECT_NEAR(t.rotation[k], (p[i] + p[j]) / (s[i] + s[j]), 1e-9 * (1 + largest(t))) << s.transpose();
        }
      }
    }
}

// Equal singular values included, where the quotients of the modes are 0/0 and only their closed forms remain.
TYPED_TEST(Materials, TangentInTheFrameOfTheSvdIsTheDerivativeOfThePiolaStressInF) {
  std::mt19937 random(11);
  for (const Vector& s : stretches()) {
    if (s[1] + s[2] < 1e-3) continue;  // no unique rotation
    const auto t = tangent<TypeParam>(s, kModuli);
    const Matrix u = random_rotation(random), v = random_rotation(random), d = Matrix::Random();
    const double step = 1e-6 * std::min(1.0, s[1] + s[2]);
    const Matrix f = u * s.asDiagonal() * v.transpose();
    const Matrix quotient =
        (piola<TypeParam>(f + step * d, kModuli) - piola<TypeParam>(f - step * d, kModuli)) / (2 * step);
    const Matrix expected = u * apply(t, u.transpose() * d * v) * v.transpose();
    EXPECT_LE((quotient - expected).norm(), 3e-5 * (1 + largest(t))) << s.transpose();
  }
}

// P = 2 mu epsilon + lambda tr epsilon I for F = I + epsilon; the error falls with the square of the strain.
TYPED_TEST(Materials, SmallStrainsGiveTheLinearElasticityOfLame) {
  for (const double mooney : {0.0, 0.4, 3.0}) {
    const Moduli<double> m{kMu, kLambda, mooney};
    EXPECT_NEAR(energy<TypeParam>({1, 1, 1}, m), 0.0, 1e-14);
    EXPECT_LE(p_hat<TypeParam>({1, 1, 1}, m).norm(), 1e-14);
    const auto t = tangent<TypeParam>({1, 1, 1}, m);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) EXPECT_NEAR(t.hessian[kIndex[i][j]], i == j ? 2 * kMu + kLambda : kLambda, 1e-12);
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(t.stretch[k], 2 * kMu, 1e-12);
      EXPECT_NEAR(t.rotation[k], 0.0, 1e-12);
    }
    Matrix strain;
    strain << 0.3, -0.5, 0.2, -0.5, 0.7, 0.9, 0.2, 0.9, -0.4;
    const Matrix linear = 2 * kMu * strain + kLambda * strain.trace() * Matrix::Identity();
    for (const double size : {1e-3, 1e-4}) {
      const Matrix p = piola<TypeParam>(Matrix::Identity() + size * strain, m);
      EXPECT_LE((p / size - linear).norm(), 8 * size * linear.norm());
    }
  }
}

TYPED_TEST(Materials, StressTurnsWithTheBodyAndIsTheSameFromEveryRestDirection) {
  std::mt19937 random(3);
  for (int k = 0; k < 20; ++k) {
    const Matrix f = Matrix::Identity() + 0.3 * Matrix::Random(), r = random_rotation(random);
    const Matrix p = piola<TypeParam>(f, kModuli);
    EXPECT_LE((piola<TypeParam>(r * f, kModuli) - r * p).norm(), 1e-11 * p.norm());
    EXPECT_LE((piola<TypeParam>(f * r, kModuli) - p * r).norm(), 1e-11 * p.norm());
  }
}

TYPED_TEST(Materials, FlatteningACellAndTurningItInsideOutCostsEverMoreEnergy) {
  for (const auto& m : {kModuli, kNearlyIncompressible}) {
    double last = energy<TypeParam>({1, 1, 1}, m);
    for (double s = 0.98; s > -2.0; s -= 0.02) {
      const double next = energy<TypeParam>({1, 1, s}, m);
      EXPECT_TRUE(std::isfinite(next));
      EXPECT_GT(next, last) << s;
      last = next;
    }
  }
}

TYPED_TEST(Materials, TangentMadeDefiniteHasNoEigenvalueBelowTheFloor) {
  const double floor = 1e-4 * kMu;
  int indefinite = 0, kept = 0;
  for (const Vector& s : stretches())
    for (const auto how : {PsdProjection::kClamp, PsdProjection::kAbsolute}) {
      const auto exact = tangent<TypeParam>(s, kModuli);
      auto t = exact;
      make_definite(t, floor, how);
      Eigen::Matrix<double, 9, 9> k, before;
      for (int c = 0; c < 9; ++c) {
        Matrix d = Matrix::Zero();
        d(c / 3, c % 3) = 1;
        k.col(c) = apply(t, d).template reshaped<Eigen::RowMajor>();
        before.col(c) = apply(exact, d).template reshaped<Eigen::RowMajor>();
      }
      EXPECT_LE((k - k.transpose()).norm(), 1e-12 * k.norm());
      const double lowest = Eigen::SelfAdjointEigenSolver<decltype(k)>(k).eigenvalues()[0];
      const double lowest_before = Eigen::SelfAdjointEigenSolver<decltype(k)>(before).eigenvalues()[0];
      EXPECT_GE(lowest, floor - 1e-12 * k.norm()) << s.transpose();
      if (lowest_before > floor) {
        ++kept;
        EXPECT_LE((k - before).norm(), 1e-12 * k.norm()) << s.transpose();
      } else {
        ++indefinite;
      }
    }
  EXPECT_GT(indefinite, 20);
  EXPECT_GT(kept, 20);
}

// The cancellation next to rest counts against the size of the terms that cancel.
TYPED_TEST(Materials, FloatAgreesWithDouble) {
  for (const Vector& wide : stretches()) {
    const float s[3] = {float(wide[0]), float(wide[1]), float(wide[2])};
    const Vector exact = Eigen::Vector3f(s[0], s[1], s[2]).cast<double>();
    const Moduli<float> m{float(kMu), float(kLambda), 0.4f};
    const Moduli<double> same{kMu, kLambda, double(0.4f)};
    float p[3];
    TypeParam::p_hat(s, m, p);
    const Vector p_exact = p_hat<TypeParam>(exact, same);
    TangentHat<float> t;
    TypeParam::dpdf_hat(s, m, t);
    const auto t_exact = tangent<TypeParam>(exact, same);
    const double scale = largest(t_exact);  // p is at most about this times sigma
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(double(p[i]), p_exact[i], 4e-6 * scale * exact[0]) << exact.transpose();
    for (int i = 0; i < 6; ++i)
      EXPECT_NEAR(double(t.hessian[i]), t_exact.hessian[i], 4e-6 * scale) << exact.transpose();
    if (s[1] + s[2] < 1e-3f) continue;  // rotations of the corotated model divide by that sum
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(double(t.stretch[k]), t_exact.stretch[k], 4e-6 * scale) << exact.transpose();
      EXPECT_NEAR(double(t.rotation[k]), t_exact.rotation[k], 4e-6 * scale) << exact.transpose();
    }
  }
}

// J >= kSmallJ on one side and below on the other: value, slope and curvature meet.
TEST(NeoHookean, LogarithmIsContinuedTwiceDifferentiably) {
  const double e = 1e-9;
  double above[3], below[3];
  NeoHookean::logarithm(NeoHookean::kSmallJ + e, above[0], above[1], above[2]);
  NeoHookean::logarithm(NeoHookean::kSmallJ - e, below[0], below[1], below[2]);
  EXPECT_NEAR(above[0], below[0], 1e-7);
  EXPECT_NEAR(above[1], below[1], 1e-6);
  EXPECT_NEAR(above[2], below[2], 1e-5);
  EXPECT_NEAR(above[0], std::log(NeoHookean::kSmallJ), 1e-7);
}

TEST(MooneyRivlin, PowersOfJAreContinuedTwiceDifferentiably) {
  const double e = 1e-9, j = MooneyRivlin::kSmallJ;
  const MooneyRivlin::PowersOfJ<double> above(j + e), below(j - e);
  EXPECT_NEAR(above.a, std::pow(j, -2.0 / 3), 1e-7);
  EXPECT_NEAR(above.b, std::pow(j, -4.0 / 3), 1e-7);
  EXPECT_NEAR(above.a, below.a, 1e-7);
  EXPECT_NEAR(above.da, below.da, 1e-6);
  EXPECT_NEAR(above.dda, below.dda, 1e-5);
  EXPECT_NEAR(above.b, below.b, 1e-6);
  EXPECT_NEAR(above.db, below.db, 1e-5);
  EXPECT_NEAR(above.ddb, below.ddb, 1e-4);
}

TEST(MaterialModels, AreFoundByTheNamesThatProceduresGiveThem) {
  const auto laplacian = [](const char* name) {
    double found = 0.0;
    MaterialModels::with(MaterialModels::index(name), [&]<class Model>() {
      found = Model::kLaplacian;
      EXPECT_STREQ(Model::kName, name);
    });
    return found;
  };
  EXPECT_EQ(laplacian("corotated"), 2.0);
  for (const char* name : {"neoHookean", "stableNeoHookean", "mooneyRivlin"}) EXPECT_EQ(laplacian(name), 1.0);
  for (const char* name : {"corotated", "stableNeoHookean"}) EXPECT_TRUE(MaterialModels::inverts(name)) << name;
  for (const char* name : {"neoHookean", "mooneyRivlin", "ogden"}) EXPECT_FALSE(MaterialModels::inverts(name)) << name;
  EXPECT_EQ(MaterialModels::index("ogden"), -1);
}

}  // namespace
}  // namespace lappet
