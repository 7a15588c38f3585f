#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "force/fiber_response_samples.h"
#include "force/materials/fiber.h"

namespace lappet {
namespace {

using namespace fiber_samples;

// Table 1 of Blemker, Pinsky, Delp 2005 at an optimal stretch of 1.
double published_curve(double l) {
  if (l <= 0.4 || l >= 1.6) return 0.0;
  if (l <= 0.6) return 9 * (l - 0.4) * (l - 0.4);
  if (l >= 1.4) return 9 * (l - 1.6) * (l - 1.6);
  return 1 - 4 * (1 - l) * (1 - l);
}

TEST(Muscle, IsometricStressFollowsThePublishedForceLengthCurve) {
  const double greatest = 280.0;
  for (double l = 0.0; l < 2.2; l += 0.05) {
    const Matrix f = Vector(l, 1.1, 0.9).asDiagonal();
    const Matrix p = stress(f, Vector::UnitX(), Parameters{0.0, 0.0, 0.0, 0.0, greatest});
    EXPECT_NEAR(p(0, 0), greatest * published_curve(l), 1e-11 * greatest) << l;
    EXPECT_NEAR(p.norm(), std::abs(p(0, 0)), 1e-12);
  }
}

TEST(Muscle, PullsWithItsWholeStressAtTheOptimalLengthAndNotAtAllBeyondItsEnds) {
  const Parameters p{0.0, 0.0, 0.0, 0.0, 280.0};
  const auto optimal = fiber_response(3.0, 1.0, 1.0, p);
  EXPECT_DOUBLE_EQ(optimal.along, 280.0);
  EXPECT_DOUBLE_EQ(optimal.along + optimal.muscle_curvature, 0.0);  // the top of the curve is flat
  EXPECT_NEAR(optimal.energy, 0.0, 1e-12);
  for (const double l : {0.0, 1e-12, 0.2, 0.399, 1.601, 3.0}) {
    const auto r = fiber_response(3.0, l * l, 1.0, p);
    EXPECT_NEAR(r.along, 0.0, 1e-12) << l;
    EXPECT_NEAR(r.muscle_curvature, 0.0, 1e-12) << l;
  }
}

TEST(Muscle, EnergyIsTheWorkOfThePublishedCurve) {
  const Parameters p{0.0, 0.0, 0.0, 0.0, 1.0};
  for (double l = 0.05; l < 2.0; l += 0.05) {
    const int steps = 20000;
    double work = 0.0;  // midpoint rule from 1 to l
    for (int k = 0; k < steps; ++k) work += published_curve(1 + (l - 1) * (k + 0.5) / steps) * (l - 1) / steps;
    EXPECT_NEAR(fiber_response(3.0, l * l, 1.0, p).energy, work, 1e-8) << l;
  }
}

TEST(Muscle, ThatPullsNothingIsPassedOverWithTheSameBits) {
  for (Sample s : samples()) {
    s.p.muscle = 0.0;
    const double i1 = s.f.squaredNorm(), i4 = (s.f * s.a).squaredNorm();
    const double j = s.f.determinant();
    auto whole = fiber_response(i1, i4, j, s.p);
    make_definite(whole, i4, PsdProjection::kClamp);
    s.p.active = false;
    const auto passed_over = fiber_response(i1, i4, j, s.p);
    EXPECT_EQ(passed_over.energy, whole.energy);
    EXPECT_EQ(passed_over.shear, whole.shear);
    EXPECT_EQ(passed_over.pressure, whole.pressure);
    EXPECT_EQ(passed_over.bulk, whole.bulk);
    EXPECT_EQ(passed_over.volume, whole.volume);
    EXPECT_EQ(passed_over.along, whole.along);
    EXPECT_EQ(passed_over.curvature, whole.curvature);
    EXPECT_EQ(passed_over.muscle_curvature, whole.muscle_curvature);
  }
}

TEST(Muscle, TangentBeyondTheOptimalLengthIsMadeDefiniteAndOthersAreLeft) {
  int indefinite = 0, kept = 0;
  for (const auto& s : samples()) {
    const double i4 = (s.f * s.a).squaredNorm();
    const auto exact = response(s.f, s.a, s.p);
    const auto before = assembled(s.f, s.a, s.p.dispersion, exact);
    const bool is_indefinite = exact.along + exact.muscle_curvature * i4 < -1e-12;
    for (const auto how : {PsdProjection::kClamp, PsdProjection::kAbsolute}) {
      auto r = exact;
      make_definite(r, i4, how);
      const auto k = assembled(s.f, s.a, s.p.dispersion, r);
      EXPECT_LE((k - k.transpose()).norm(), 1e-13 * k.norm());
      EXPECT_GE(lowest_eigenvalue(k), -1e-13 * (before.norm() + k.norm()));
      const double value = exact.along + exact.muscle_curvature * i4;
      const double definite = how == PsdProjection::kAbsolute ? std::abs(value) : std::max(value, 0.0);
      EXPECT_NEAR(r.along + r.muscle_curvature * i4, definite, 1e-12 * (1 + std::abs(exact.along)));
      if (!is_indefinite) {
        EXPECT_LE((k - before).norm(), 1e-12 * (1 + before.norm()));
      }
      (is_indefinite ? indefinite : kept) += 1;
    }
    auto untouched = exact;
    make_definite(untouched, i4, PsdProjection::kExact);
    EXPECT_EQ(untouched.muscle_curvature, exact.muscle_curvature);
  }
  EXPECT_GT(indefinite, 20);
  EXPECT_GT(kept, 20);
  // a muscle alone on the falling side of its curve has a negative eigenvalue that is gone afterwards
  const Matrix f = Vector(1.3, 1, 1).asDiagonal();
  auto r = response(f, Vector::UnitX(), Parameters{0.0, 0.0, 0.0, 0.0, 10.0});
  EXPECT_NEAR(lowest_eigenvalue(assembled(f, Vector::UnitX(), 0.0, r)), -10 * 8 * 0.3, 1e-10);
  make_definite(r, 1.69, PsdProjection::kAbsolute);
  EXPECT_NEAR(r.along + 1.69 * r.muscle_curvature, 24.0, 1e-10);
}

}  // namespace
}  // namespace lappet
