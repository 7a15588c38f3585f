// Fibers and muscle through a Session: bars against the published forms of both, solved for the state whose sides are
// free (material_formulas.h, pulled_bar.h).
#include <gtest/gtest.h>

#include <numbers>

#include "material_formulas.h"
#include "pulled_bar.h"

namespace lappet {
namespace {

SessionSettings fibrous(double degrees, double k1, double k2, double dispersion) {
  SessionSettings s;
  s.retractors = 1;
  s.threads = 2;
  auto& m = s.materials[0];
  m.fiber_direction = Vec3(std::cos(degrees * std::numbers::pi / 180), std::sin(degrees * std::numbers::pi / 180), 0);
  m.fiber_k1 = k1;
  m.fiber_k2 = k2;
  m.fiber_dispersion = dispersion;
  return s;
}
void make_reference(SessionSettings& s) {
  s.quadrature = 8;
  s.precision = "double";
  s.tolerance = 1e-8;
}
Piola piola_of(const SessionSettings& s, double activation = 0) {
  return [m = s.materials[0], activation](const Matrix3& f) { return full_piola(m, f, activation); };
}

// Pulls a bar and compares its force and its lateral stretches with those of the free state; returns the force per
// area and the axial stretch.
std::array<double, 2> expect_free_sides(const SessionSettings& s, const Bar& bar, double elongation, double error) {
  Session session(s);
  session.set_epoch(bar_epoch(bar));
  const Gauge gauge = read_gauge(pull(session, elongation), bar);
  const Matrix3 f = free_sides(piola_of(s), gauge.axial);
  EXPECT_NEAR(gauge.lateral_z, f(2, 2), error * f(2, 2));
  const double across = Vec3(f.col(1)).norm();  // a line across the bar leans where the fibers are oblique
  EXPECT_NEAR(gauge.lateral_y, across, error * across);
  const double expected = piola_of(s)(f)(0, 0) * bar.area();
  const double force = pulling_force(session, elongation, 0.005 * bar.length);
  EXPECT_NEAR(force, expected, error * expected);
  return {force / bar.area(), gauge.axial};
}

class Directions : public ::testing::TestWithParam<int> {};

TEST_P(Directions, AFibrousBarHasTheForceAndTheLateralStretchesOfItsDirection) {
  const Bar slender{GetParam() == 45 ? 80.0 : 40.0, 4, 4};  // oblique fibers also shear: held ends disturb the middle
  SessionSettings s = fibrous(GetParam(), 40, 1.5, 0.1);
  expect_free_sides(s, slender, 0.2 * slender.length, 0.01);
  make_reference(s);
  expect_free_sides(s, slender, 0.2 * slender.length, GetParam() == 45 ? 5e-3 : 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Fibers, Directions, ::testing::Values(0, 45, 90),
                         [](const auto& info) { return "At" + std::to_string(info.param); });

TEST(FiberSession, FullyDispersedFibersHaveNoDirection) {
  double force[3];
  int k = 0;
  for (const double degrees : {0.0, 45.0, 90.0}) {
    SessionSettings s = fibrous(degrees, 60, 2, 1.0 / 3.0);
    force[k++] = expect_free_sides(s, Bar{}, 10, 0.01)[0];
  }
  EXPECT_NEAR(force[1], force[0], 1e-4 * force[0]);
  EXPECT_NEAR(force[2], force[0], 1e-4 * force[0]);
}

TEST(FiberSession, FibersStiffenWithStretchAlongThemAndNotAcross) {
  const auto stress = [](double degrees, double elongation) {
    return expect_free_sides(fibrous(degrees, 20, 5, 0.0), Bar{}, elongation, 0.01)[0];
  };
  const double along[] = {stress(0, 2), stress(0, 8), stress(0, 14)};
  EXPECT_GT((along[2] - along[1]) / 6, 4 * along[0] / 2);
  const double across[] = {stress(90, 2), stress(90, 8), stress(90, 14)};
  EXPECT_LT((across[2] - across[1]) / 6, 1.05 * across[0] / 2);  // neo-Hookean tissue softens
}

// The volume is free: nothing but the law keeps it. The published invariants beside a fixed bulk modulus lose a
// quarter.
TEST(FiberSession, AStripOfSkinKeepsItsVolumeWithinOnePercentAndPullsAsItsTwoFreeSidesSay) {
  for (const double degrees : {0.0, 90.0}) {
    SessionSettings s = fibrous(degrees, 1500, 2, 0.2);
    s.materials[0].fiber_slack = 1.15;
    s.materials[0].poissons_ratio = 0.49;
    make_reference(s);
    const Bar bar{24, 4, 4};
    for (const double elongation : {0.1, 0.35, 0.6}) {
      expect_free_sides(s, bar, elongation * bar.length, degrees == 0 ? 0.02 : 0.01);
      Session session(s);
      session.set_epoch(bar_epoch(bar));
      const Gauge gauge = read_gauge(pull(session, elongation * bar.length), bar);
      EXPECT_NEAR(gauge.axial * gauge.lateral_y * gauge.lateral_z, 1.0, 0.01) << degrees << " " << elongation;
    }
  }
}

// Fibers said to run at 45 degrees to the skin run along it: the bar's skin is its side, whose normal is y.
TEST(FiberSession, FibersRunAlongTheSkinAboveThem) {
  SessionSettings s = fibrous(45, 40, 1.5, 0.1), along = fibrous(0, 40, 1.5, 0.1);
  const Bar bar;
  EpochInput epoch = bar_epoch(bar);
  epoch.skin.points = {{0, 4, 0}, {0, 4, 4}, {40, 4, 4}, {40, 4, 0}};
  epoch.skin.triangles = {{0, 1, 2}, {0, 2, 3}};
  Session session(s);
  session.set_epoch(epoch);
  const Matrix3 f = free_sides(piola_of(along), read_gauge(pull(session, 8), bar).axial);
  const double expected = piola_of(along)(f)(0, 0) * bar.area();
  EXPECT_NEAR(pulling_force(session, 8, 0.2), expected, 0.01 * expected);
}

SessionSettings muscular(double strength) {
  SessionSettings s;
  s.retractors = 1;
  s.threads = 2;
  s.materials[0].muscle_stress = strength;
  return s;
}

TEST(MuscleSession, AMuscleBetweenHeldEndsPullsByItsIsometricStressTimesActivation) {
  const SessionSettings s = muscular(30);
  const Bar bar;
  Session session(s);
  session.set_epoch(bar_epoch(bar));
  for (const double activation : {0.0, 0.3, 1.0}) {
    const double expected = 30 * activation * bar.area();
    EXPECT_NEAR(pulling_force(session, 0, 0.1, {activation}), expected, 2e-3 * 30 * bar.area()) << activation;
    EXPECT_NEAR(read_gauge(pull(session, 0, {activation}), bar).axial, 1, 1e-3);  // nothing moves
  }
}

TEST(MuscleSession, AStretchedMuscleFollowsTheForceLengthCurve) {
  for (const double elongation : {-8.0, 8.0, 20.0}) {  // on the peak of the curve, and down its flank
    SessionSettings s = muscular(12);                  // weak enough that its falling flank does not make the bar neck
    s.stability = false;  // the curve is that of a straight bar, which buckles at the first of them
    const Bar bar;
    Session session(s);
    session.set_epoch(bar_epoch(bar));
    const Gauge gauge = read_gauge(pull(session, elongation, {0.8}), bar);
    const Matrix3 f = free_sides(piola_of(s, 0.8), gauge.axial);
    EXPECT_NEAR(gauge.lateral_y, f(1, 1), 1e-2 * f(1, 1)) << elongation;
    const double force = piola_of(s, 0.8)(f)(0, 0);
    EXPECT_NEAR(pulling_force(session, elongation, 0.2, {0.8}) / bar.area(), force, 1e-2 * std::abs(force));
  }
}

// Where tissue and muscle together press by more than Euler's load the straight bar is a saddle of the energy: the
// session finds the bent one, and keeps the straight one at a smaller load or when told not to look for saddles.
TEST(MuscleSession, AMuscleShortenedBeyondItsSlackLengthBuckles) {
  const Bar bar;
  const auto shortened = [&](double elongation, bool stability) {
    SessionSettings s = muscular(12);
    s.stability = stability;
    Session session(s);
    session.set_epoch(bar_epoch(bar));
    const FrameOutput out = pull(session, elongation, {0.8});
    const Vec3 middle = 0.5 * (landmark(out, 4) + landmark(out, 5));  // at the height of the axis
    return std::pair(out.energy, std::hypot(middle[1] - bar.width / 2, middle[2] - bar.height / 2));
  };
  EXPECT_LT(shortened(-6, true).second, 1e-3);  // mm
  const auto straight = shortened(-8, false), bent = shortened(-8, true);
  EXPECT_LT(straight.second, 1e-3);
  EXPECT_GT(bent.second, 1.0);
  EXPECT_LT(bent.first, straight.first - 1.0);  // mN mm
}

TEST(MuscleSession, AFreeMuscleShortensUntilItsTissueBearsItsStress) {
  SessionSettings s = muscular(20);
  s.retractors = 0;
  const Bar bar;
  Session session(s);
  session.set_epoch(bar_epoch(bar, false));
  double low = 0.6, high = 1.0;
  for (int k = 0; k < 50; ++k) {
    const double stretch = 0.5 * (low + high);
    (piola_of(s, 1)(free_sides(piola_of(s, 1), stretch))(0, 0) > 0 ? high : low) = stretch;
  }
  EXPECT_LT(low, 0.85);
  FrameInput frame;
  frame.activation = {1.0};
  FrameOutput out = session.solve(frame, {}, kNever);
  ASSERT_TRUE(out.converged) << out.failure.message;
  EXPECT_NEAR(read_gauge(out, bar).axial, low, 1e-2 * low);
  frame.activation = {0.0};  // and comes back when it relaxes
  out = session.solve(frame, {}, kNever);
  ASSERT_TRUE(out.converged) << out.failure.message;
  EXPECT_NEAR(read_gauge(out, bar).axial, 1, 5e-3);
}

// A frame that a single step does not reach is reached over load steps, which pass through part of the activation; the
// state is the one of many small frames.
TEST(MuscleSession, ActivationGrowsOverLoadStepsToTheStateOfManyFrames) {
  const Bar bar;
  const auto shortened = [&](int max_newton, int frames) {
    SessionSettings s = muscular(40);
    s.retractors = 0;
    s.max_newton = max_newton;
    s.tolerance = 1e-5;
    s.precision = "double";
    Session session(s);
    session.set_epoch(bar_epoch(bar, false));
    FrameOutput out;
    for (int k = 1; k <= frames; ++k) {
      FrameInput frame;
      frame.activation = {static_cast<double>(k) / frames};
      out = session.solve(frame, {}, kNever);
      EXPECT_TRUE(out.converged) << out.failure.message;
    }
    EXPECT_EQ(out.state.activation, (std::vector<double>{1.0}));
    return std::pair(read_gauge(out, bar).axial, out.load_steps);
  };
  const auto slow = shortened(100, 10), hurried = shortened(4, 1);
  EXPECT_EQ(slow.second, 1);
  EXPECT_GT(hurried.second, 1);
  EXPECT_NEAR(hurried.first, slow.first, 1e-4);
}

}  // namespace
}  // namespace lappet
