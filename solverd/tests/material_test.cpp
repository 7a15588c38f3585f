#include "force/material.h"

#include <gtest/gtest.h>

#include <random>

namespace lappet {
namespace {

template <class Model>
class Materials : public ::testing::Test {};
using Models = ::testing::Types<Corotated, NeoHookean>;
TYPED_TEST_SUITE(Materials, Models);

// Stretches with 0.4 < sigma, the last one inverted in a third of the cases.
template <class Body>
void for_stretches(const Body& body) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> stretch(0.4, 1.9);
  for (int k = 0; k < 300; ++k) {
    double s[3] = {stretch(random), stretch(random), stretch(random)};
    std::sort(s, s + 3, std::greater<>());
    if (k % 3 == 0) s[2] *= -0.3;
    body(s);
  }
}

TYPED_TEST(Materials, StressIsTheDerivativeOfTheEnergy) {
  for_stretches([](double(&s)[3]) {
    double p[3];
    TypeParam::p_hat(s, Moduli<double>{3.0, 11.0, 0.0}, p);
    for (int i = 0; i < 3; ++i) {
      const double step = 1e-6, kept = s[i];
      s[i] = kept + step;
      const double above = TypeParam::energy(s, Moduli<double>{3.0, 11.0, 0.0});
      s[i] = kept - step;
      const double below = TypeParam::energy(s, Moduli<double>{3.0, 11.0, 0.0});
      s[i] = kept;
      EXPECT_NEAR((above - below) / (2 * step), p[i], 1e-6 * (1 + std::abs(p[i])));
    }
  });
}

TYPED_TEST(Materials, TangentIsTheDerivativeOfTheStress) {
  for_stretches([](double(&s)[3]) {
    TangentHat<double> t;
    TypeParam::dpdf_hat(s, Moduli<double>{3.0, 11.0, 0.0}, t);
    const int index[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    double p[3];
    TypeParam::p_hat(s, Moduli<double>{3.0, 11.0, 0.0}, p);
    for (int j = 0; j < 3; ++j) {
      const double step = 1e-6, kept = s[j];
      double above[3], below[3];
      s[j] = kept + step;
      TypeParam::p_hat(s, Moduli<double>{3.0, 11.0, 0.0}, above);
      s[j] = kept - step;
      TypeParam::p_hat(s, Moduli<double>{3.0, 11.0, 0.0}, below);
      s[j] = kept;
      for (int i = 0; i < 3; ++i)
        EXPECT_NEAR((above[i] - below[i]) / (2 * step), t.hessian[index[i][j]],
                    1e-5 * (1 + std::abs(t.hessian[index[i][j]])));
    }
    const int pairs[3][2] = {{0, 1}, {0, 2}, {1, 2}};
    for (int k = 0; k < 3; ++k) {
      const int i = pairs[k][0], j = pairs[k][1];
      if (std::abs(s[i] - s[j]) > 1e-3) {
        EXPECT_NEAR(t.stretch[k], (p[i] - p[j]) / (s[i] - s[j]), 1e-7 * (1 + std::abs(t.stretch[k])));
      }
      EXPECT_NEAR(t.rotation[k], (p[i] + p[j]) / (s[i] + s[j]), 1e-7 * (1 + std::abs(t.rotation[k])));
    }
  });
}

TYPED_TEST(Materials, RestIsWithoutStressAndHasTheLinearModuli) {
  const double mu = 3.0, lambda = 11.0, rest[3] = {1, 1, 1};
  double p[3];
  TypeParam::p_hat(rest, Moduli<double>{mu, lambda, 0.0}, p);
  for (const double value : p) EXPECT_NEAR(value, 0.0, 1e-14);
  EXPECT_NEAR(TypeParam::energy(rest, Moduli<double>{mu, lambda, 0.0}), 0.0, 1e-14);
  TangentHat<double> t;
  TypeParam::dpdf_hat(rest, Moduli<double>{mu, lambda, 0.0}, t);
  EXPECT_NEAR(t.hessian[0], 2 * mu + lambda, 1e-12);
  EXPECT_NEAR(t.hessian[1], lambda, 1e-12);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(t.stretch[k], 2 * mu, 1e-12);
    EXPECT_NEAR(t.rotation[k], 0.0, 1e-12);
  }
}

// Neo-Hookean, J >= kSmallJ on one side and below on the other: value, slope and curvature meet.
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

}  // namespace
}  // namespace lappet
