// Homogeneous states of the isotropic models against closed forms.
//
// Derivations. With p_i = mu s_i + q J/s_i (neo-Hookean models; q = dPsi/dJ), a free face of stretch t has q = -mu
// t^2/J, so the others have p_i = mu (s_i - t^2/s_i); the stable model's q is linear in J, which gives t itself. For
// Mooney-Rivlin at constant volume: Mooney 1940, Rivlin 1948 (Treloar, "The Physics of Rubber Elasticity", ch. 11;
// Ogden, "Non-Linear Elastic Deformations", 7.2). Simple shear: Cauchy stress -p I + 2 mu10 b - 2 mu01 b^-1.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "force/materials/material_models.h"
#include "force/materials/material_parameters.h"
#include "math/svd3.h"

namespace lappet {
namespace {

using Matrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

MaterialParameters skin() { return {.youngs_modulus = 50.0, .poissons_ratio = 0.45}; }
Moduli<double> moduli(const MaterialParameters& m) { return {m.mu(), m.lambda(), m.mooney_ratio}; }

struct State {
  double free, p[3];
};

// The state with stretches (along, across or the free one, free) whose free faces carry no stress.
template <class Model>
State uniaxial_or_equibiaxial(double along, bool equibiaxial, const Moduli<double>& m) {
  State state;
  double low = 0.05, high = 3.0;  // the stress grows with the free stretch
  for (int k = 0; k < 200; ++k) {
    state.free = 0.5 * (low + high);
    const double s[3] = {along, equibiaxial ? along : state.free, state.free};
    Model::p_hat(s, m, state.p);
    (state.p[2] > 0 ? high : low) = state.free;
  }
  return state;
}

template <class Model>
Matrix piola(const Matrix& f, const Moduli<double>& m) {
  double in[9], u[9], s[3], v[9], p[3];
  Eigen::Map<Matrix>{in} = f;
  svd3(in, u, s, v);
  Model::p_hat(s, m, p);
  return Eigen::Map<Matrix>(u) * Eigen::Vector3d(p[0], p[1], p[2]).asDiagonal() * Eigen::Map<Matrix>(v).transpose();
}
Matrix sheared(double amount) {
  Matrix f = Matrix::Identity();
  f(0, 1) = amount;
  return f;
}

constexpr double kStretches[] = {0.7, 0.9, 1.1, 1.3, 1.8};

TEST(MaterialStates, CorotatedUniaxialStressIsYoungsModulusTimesTheElongation) {
  const auto skin_ = skin();
  for (const double l : kStretches) {
    const auto state = uniaxial_or_equibiaxial<Corotated>(l, false, moduli(skin_));
    EXPECT_NEAR(state.free, 1 - 0.45 * (l - 1), 1e-12);
    EXPECT_NEAR(state.p[0], 50 * (l - 1), 1e-10);
    const auto both = uniaxial_or_equibiaxial<Corotated>(l, true, moduli(skin_));
    if (1 - 2 * 0.45 / 0.55 * (l - 1) < 0.05) continue;
    EXPECT_NEAR(both.p[0], 50 / (1 - 0.45) * (l - 1), 1e-10);
  }
}

TEST(MaterialStates, NeoHookeanStressFollowsFromTheFreeStretch) {
  const auto m = moduli(skin());
  for (const double l : kStretches) {
    const auto one = uniaxial_or_equibiaxial<NeoHookean>(l, false, m);
    const double t = one.free;
    EXPECT_NEAR(m.mu * (t * t - 1) + m.lambda * std::log(l * t * t), 0.0, 1e-10);
    EXPECT_NEAR(one.p[0], m.mu * (l - t * t / l), 1e-10);
    const auto two = uniaxial_or_equibiaxial<NeoHookean>(l, true, m);
    EXPECT_NEAR(m.mu * (two.free * two.free - 1) + m.lambda * std::log(l * l * two.free), 0.0, 1e-10);
    EXPECT_NEAR(two.p[0], m.mu * (l - two.free * two.free / l), 1e-10);
  }
}

TEST(MaterialStates, StableNeoHookeanStressHasAClosedForm) {
  const auto m = moduli(skin());
  const double bulk = m.lambda + m.mu;
  for (const double l : kStretches) {
    const double j = 1 + m.mu * (1 - 1 / l) / bulk;
    const auto one = uniaxial_or_equibiaxial<StableNeoHookean>(l, false, m);
    EXPECT_NEAR(one.free, std::sqrt(j / l), 1e-12);
    EXPECT_NEAR(one.p[0], m.mu * (l - j / (l * l)), 1e-10);
    const double t = (bulk + m.mu) / (bulk * l * l + m.mu / (l * l));
    const auto two = uniaxial_or_equibiaxial<StableNeoHookean>(l, true, m);
    EXPECT_NEAR(two.free, t, 1e-12);
    EXPECT_NEAR(two.p[0], m.mu * (l - t * t / l), 1e-10);
  }
}

TEST(MaterialStates, MooneyRivlinReachesTheIncompressibleFormulas) {
  for (const double ratio : {0.0, 0.25, 1.0}) {
    const double mu = 17.0, m10 = 0.5 * mu / (1 + ratio), m01 = ratio * m10;
    for (const double l : kStretches) {
      double last[2] = {1e9, 1e9};
      for (const double lambda : {1e3 * mu, 1e4 * mu, 1e6 * mu}) {
        const Moduli<double> m{mu, lambda, ratio};
        const double errors[2] = {std::abs(uniaxial_or_equibiaxial<MooneyRivlin>(l, false, m).p[0] -
                                           2 * (l - std::pow(l, -2)) * (m10 + m01 / l)),
                                  std::abs(uniaxial_or_equibiaxial<MooneyRivlin>(l, true, m).p[0] -
                                           2 * (l - std::pow(l, -5)) * (m10 + m01 * l * l))};
        for (int k = 0; k < 2; ++k) {
          EXPECT_LE(errors[k], 60 * mu * mu / lambda) << l << " " << lambda;
          EXPECT_LT(errors[k], last[k]);
          last[k] = errors[k];
        }
      }
    }
  }
}

TEST(MaterialStates, MooneyRivlinWithoutItsSecondTermIsTheIsochoricNeoHookeanMaterial) {
  // Cauchy stress of mu/2 (I1bar - 3) + kappa/2 (ln J)^2: mu J^{-5/3} dev b + kappa ln J / J I.
  const auto m = moduli(skin());
  Matrix f;
  f << 1.2, 0.3, -0.1, 0.05, 0.8, 0.2, 0.1, -0.2, 1.4;
  const double j = f.determinant(), kappa = m.lambda + 2.0 / 3 * m.mu;
  const Matrix b = f * f.transpose();
  const Matrix expected = m.mu * std::pow(j, -5.0 / 3) * (b - b.trace() / 3 * Matrix::Identity()) +
                          kappa * std::log(j) / j * Matrix::Identity();
  EXPECT_LE((piola<MooneyRivlin>(f, m) * f.transpose() / j - expected).norm(), 1e-11 * expected.norm());
}

TEST(MaterialStates, NeoHookeanModelsShearWithTheirModulusAtAnyAmount) {
  const auto m = moduli(skin());
  for (const double g : {0.1, 0.5, 1.5}) {
    const Matrix f = sheared(g);
    Matrix cauchy = Matrix::Zero();  // mu (b - I): J = 1 under simple shear
    cauchy << m.mu * g * g, m.mu * g, 0, m.mu * g, 0, 0, 0, 0, 0;
    EXPECT_LE((piola<NeoHookean>(f, m) * f.transpose() - cauchy).norm(), 1e-11 * m.lambda);
    EXPECT_LE((piola<StableNeoHookean>(f, m) * f.transpose() - cauchy).norm(), 1e-11 * m.lambda);
  }
}

TEST(MaterialStates, MooneyRivlinShearsWithItsModulusAndBothNormalStressDifferences) {
  auto parameters = skin();
  parameters.mooney_ratio = 0.5;
  const auto m = moduli(parameters);
  const double m10 = 0.5 * m.mu / 1.5, m01 = 0.5 * m10;
  for (const double g : {0.1, 0.5, 1.5}) {
    const Matrix f = sheared(g), cauchy = piola<MooneyRivlin>(f, m) * f.transpose();
    EXPECT_NEAR(cauchy(0, 1), m.mu * g, 1e-11 * m.lambda);
    EXPECT_NEAR(cauchy(0, 0) - cauchy(1, 1), m.mu * g * g, 1e-11 * m.lambda);
    EXPECT_NEAR(cauchy(1, 1) - cauchy(2, 2), -2 * m01 * g * g, 1e-11 * m.lambda);
    EXPECT_NEAR(cauchy.trace(), 0.0, 1e-11 * m.lambda);
  }
}

TEST(MaterialStates, CorotatedShearIsThatOfTheRotationByHalfTheShear) {
  const auto m = moduli(skin());
  for (const double g : {0.1, 0.5, 1.5}) {
    const double size = std::sqrt(1 + g * g / 4);
    Matrix r = Matrix::Identity();
    r(0, 0) = r(1, 1) = 1 / size;
    r(0, 1) = g / 2 / size;
    r(1, 0) = -r(0, 1);
    const Matrix expected = 2 * m.mu * (sheared(g) - r) + m.lambda * (2 * size - 2) * r;
    EXPECT_LE((piola<Corotated>(sheared(g), m) - expected).norm(), 1e-11 * m.lambda);
  }
}

}  // namespace
}  // namespace lappet
