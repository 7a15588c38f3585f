// The distance field against the formulas of a sphere, a box and an L, and against itself.
#include "force/constraints/signed_distance.h"

#include <gtest/gtest.h>

#include <random>

#include "box.h"
#include "lattice/refused.h"
#include "test_surfaces.h"

namespace lappet {
namespace {

constexpr std::size_t kBudget = std::size_t{1} << 30;

double box_distance(const Vec3& p, const Vec3& low, const Vec3& high) {
  const Vec3 q = (p - 0.5 * (low + high)).cwiseAbs() - 0.5 * (high - low);
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
}

std::vector<Vec3> random_points(const Vec3& low, const Vec3& high, int count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i)
    points.push_back(low + Vec3(unit(random), unit(random), unit(random)).cwiseProduct(high - low));
  return points;
}

// The largest error of value and gradient of a sphere of 10 mm, inside the band.
std::pair<double, double> sphere_errors(double spacing) {
  const Vec3 middle(1, 2, 3);
  const SignedDistance field(test::sphere(middle, 10.0, 120), spacing, 3.0, kBudget);
  double value = 0.0, gradient = 0.0;
  for (const Vec3& p : random_points(middle - Vec3::Constant(12), middle + Vec3::Constant(12), 40000)) {
    const double exact = (p - middle).norm() - 10.0;
    if (exact > field.reach() - 2 * spacing || exact < -field.depth() + 2 * spacing) continue;
    const auto sample = field.at(p);
    value = std::max(value, std::abs(sample.value - exact));
    gradient = std::max(gradient, (sample.gradient - (p - middle).normalized()).norm());
  }
  return {value, gradient};
}

TEST(SignedDistance, OfASphereIsRightToTheSquareOfTheSpacing) {
  const double chord = 10.0 * (1 - std::cos(std::numbers::pi / 240)) * 2;  // of its triangles
  for (const double s : {1.0, 0.5}) {
    const auto [value, gradient] = sphere_errors(s);
    EXPECT_LT(value, s * s / 4 / (10 - 3) * 1.2 + chord) << s;  // s^2 H / 4 and the next order
    EXPECT_LT(gradient, 0.02 * s) << s;
  }
}

TEST(SignedDistance, ItsGradientIsItsDerivativeAndHasNoKinks) {
  const SignedDistance field(test::box({0, 0, 0}, {5, 4, 3}), 0.5, 1.5, kBudget);
  const double step = 1e-5;
  for (const Vec3& p : random_points(Vec3::Constant(-1), {6, 5, 4}, 5000))
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 e = step * Vec3::Unit(axis);
      EXPECT_NEAR((field.at(p + e).value - field.at(p - e).value) / (2 * step), field.at(p).gradient[axis], 2e-5);
      // curvature is bounded by the second differences of distances: the gradient cannot jump
      EXPECT_LT((field.at(p + e).gradient - field.at(p - e).gradient).norm(), 2 * step * 3 * 2 / 0.5);
    }
}

TEST(SignedDistance, OfABoxIsExactAtItsFacesAndRoundsItsCornersByHalfTheSpacingAtMost) {
  const Vec3 low(0.13, -2, 1), high(7, 4.4, 9);
  const double s = 0.5;
  const SignedDistance field(test::box(low, high), s, 2.0, kBudget);
  int plain = 0;
  for (const Vec3& p : random_points(low - Vec3::Constant(1.5), high + Vec3::Constant(1.5), 40000)) {
    const double exact = std::clamp(box_distance(p, low, high), -field.depth(), field.reach());
    const auto sample = field.at(p);
    EXPECT_LT(std::abs(sample.value - exact), 0.52 * s) << p.transpose();
    if (std::abs(exact) > 0.52 * s) {
      EXPECT_EQ(sample.value < 0, exact < 0) << p.transpose();
    }
    // where one face alone is near
    const Vec3 from_low = (p - low).cwiseAbs(), from_high = (p - high).cwiseAbs();
    const Vec3 nearest = from_low.cwiseMin(from_high);
    int near = 0;
    for (int a = 0; a < 3; ++a) near += nearest[a] < 2.6;
    if (near != 1 || exact > 0.25 * field.reach() || exact < -1.0) continue;
    ++plain;
    EXPECT_NEAR(sample.value, exact, 2e-6) << p.transpose();
    EXPECT_NEAR(sample.gradient.norm(), 1.0, 1e-5);
  }
  EXPECT_GT(plain, 300);
}

TEST(SignedDistance, OfAnLHasTheRightSignEverywhereAlsoInItsInnerCorner) {
  const auto surface = test::prism({{0, 0}, {6, 0}, {6, 2}, {2, 2}, {2, 7}, {0, 7}}, -1, 4);
  const double s = 0.25;
  const SignedDistance field(surface, s, 1.0, kBudget);
  for (const Vec3& p : random_points({-1, -1, -2}, {7, 8, 5}, 40000)) {
    const double foot = box_distance(p, {0, 0, -1}, {6, 2, 4}), leg = box_distance(p, {0, 0, -1}, {2, 7, 4});
    const double outside = std::min(foot, leg);
    if (outside > 0.0) {
      EXPECT_LT(std::abs(field.at(p).value - std::min(outside, field.reach())), 0.52 * s) << p.transpose();
    }
    if (std::abs(outside) > 0.52 * s) {
      EXPECT_EQ(field.at(p).value < 0, outside < 0) << p.transpose();
    }
  }
}

TEST(SignedDistance, OfTwoBonesIsTheNearersAndOverlapsAndTouchingFacesAreInside) {
  Surface apart = test::box({0, 0, 0}, {2, 2, 2});
  test::append(apart, test::box({3, 0, 0}, {5, 2, 2}));
  const SignedDistance two(apart, 0.25, 1.0, kBudget);
  for (const Vec3& p : random_points({-0.4, 0.7, 0.7}, {5.4, 1.3, 1.3}, 5000)) {
    const double exact = std::min(box_distance(p, {0, 0, 0}, {2, 2, 2}), box_distance(p, {3, 0, 0}, {5, 2, 2}));
    EXPECT_NEAR(two.at(p).value, std::clamp(exact, -two.depth(), two.reach()), 0.13) << p.transpose();
  }
  Surface halves = box_surface({0, 0, 0}, {2, 2, 2});
  test::append(halves, box_surface({2, 0, 0}, {4, 2, 2}));
  const SignedDistance split(halves, 0.25, 1.0, kBudget), whole(test::box({0, 0, 0}, {4, 2, 2}), 0.25, 1.0, kBudget);
  Surface lapping = test::box({0, 0, 0}, {2.5, 2, 2});
  test::append(lapping, test::box({2, 0, 0}, {4, 2, 2}));
  const SignedDistance overlap(lapping, 0.25, 1.0, kBudget);
  for (const Vec3& p : random_points(Vec3::Constant(-1), {5, 3, 3}, 20000)) {
    EXPECT_NEAR(split.at(p).value, whole.at(p).value, 1e-5) << p.transpose();
    const double exact = box_distance(p, {0, 0, 0}, {4, 2, 2});
    if (exact > 0.1) {
      EXPECT_GT(overlap.at(p).value, 0.0) << p.transpose();
    }
    if (exact < -0.1) {
      EXPECT_LT(overlap.at(p).value, 0.0) << p.transpose();
    }
  }
}

TEST(SignedDistance, IsCutOffFarFromTheSurfaceAndDoesNotAskHowFacesAreTurned) {
  Surface ball = test::sphere({0, 0, 0}, 10.0, 40);
  const SignedDistance field(ball, 0.5, 1.5, kBudget);
  for (auto& t : ball.triangles) std::swap(t[1], t[2]);
  const SignedDistance turned(ball, 0.5, 1.5, kBudget);
  for (const Vec3& p : random_points(Vec3::Constant(-20), Vec3::Constant(20), 5000)) {
    EXPECT_EQ(field.at(p).value, turned.at(p).value);
    const double exact = p.norm() - 10.0;
    if (exact > 3.0) {
      EXPECT_NEAR(field.at(p).value, field.reach(), 1e-6);
    }
    if (exact < -3.0) {
      EXPECT_NEAR(field.at(p).value, -field.depth(), 1e-6);
    }
    if (exact > 3.0 || exact < -3.0) {
      EXPECT_NEAR(field.at(p).gradient.norm(), 0.0, 1e-6);
    }
  }
  // Memory goes with the surface, not with the volume.
  const SignedDistance fine(test::sphere({0, 0, 0}, 10.0, 40), 0.1, 0.3, kBudget);
  const SignedDistance coarse(test::sphere({0, 0, 0}, 10.0, 40), 0.2, 0.6, kBudget);
  EXPECT_LT(double(fine.bytes()), 5.0 * double(coarse.bytes()));
}

TEST(SignedDistance, RefusesAGridThatTheBudgetDoesNotHold) {
  const Surface box = test::box({0, 0, 0}, {500, 500, 500});
  try {
    SignedDistance(box, 0.01, 0.1, kBudget);
    FAIL() << "it was built";
  } catch (const RefusedError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kMemoryBudget);
    EXPECT_NE(std::string(error.what()).find("larger spacing"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace lappet
