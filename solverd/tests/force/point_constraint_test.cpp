// Threads: they pull and never push, their energy, forces and tangent belong together, and the force on a thread is
// what its stiffness, its length and the most it is drawn with say.
#include "force/constraints/point_constraint.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>

#include "box.h"
#include "session/session.h"
#include "test_surfaces.h"

namespace lappet {
namespace {

PointConstraint thread_of(double length, double most, double stiffness = 200.0) {
  PointConstraint constraint;
  constraint.stiffness = stiffness;
  constraint.thread = Thread{length, most};
  return constraint;
}

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

TEST(Thread, EnergyForceAndTangentBelongTogether) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> draw(-1.0, 1.0);
  std::size_t slack = 0, taut = 0, limited = 0;
  for (const double size : {1e-4, 1e-3, 0.1, 1.0, 4.0})
    for (const double length : {0.0, 0.05, 1.5})
      for (const double most : {kNoLimit, 150.0})
        for (const double multiplier : {0.0, 40.0}) {
          const PointConstraint thread = thread_of(length, most);
          const Vec3 lambda(multiplier, 0.0, 0.0), c = size * Vec3(draw(random), draw(random), draw(random));
          const Vec3 force = thread.force(c, lambda);
          slack += force.norm() == 0.0;
          limited += std::abs(force.norm() - most) < 0.1;
          taut += force.norm() > 0.0 && force.norm() < most;
          const Eigen::Matrix3d root = thread.tangent_root(c, lambda), tangent = root.transpose() * root;
          const double step = 1e-6 * std::max(size, 1e-3);
          for (int axis = 0; axis < 3; ++axis) {
            const Vec3 way = step * Vec3::Unit(axis);
            const double slope = (thread.energy(c + way, lambda) - thread.energy(c - way, lambda)) / (2.0 * step);
            EXPECT_NEAR(slope, force[axis], 1e-5 * (1.0 + force.norm())) << size << ' ' << length << ' ' << most;
            const Vec3 turn = (thread.force(c + way, lambda) - thread.force(c - way, lambda)) / (2.0 * step);
            EXPECT_LT((turn - tangent.col(axis)).norm(), 1e-4 * (1.0 + tangent.norm())) << size << ' ' << length;
          }
        }
  EXPECT_GT(slack, 5u);
  EXPECT_GT(taut, 5u);
  EXPECT_GT(limited, 5u);
}

TEST(Thread, PullsAndNeverPushes) {
  const PointConstraint thread = thread_of(2.0, 300.0, 100.0);
  const Vec3 none = Vec3::Zero();
  EXPECT_EQ(thread.force(Vec3(1.9, 0, 0), none), none);
  EXPECT_EQ(thread.force(none, none), none);
  EXPECT_NEAR(thread.force(Vec3(0, 3, 0), none)[1], 100.0, 0.2);  // 1e-3 mm is lost at the knot
  EXPECT_NEAR(thread.force(Vec3(0, -9, 0), none)[1], -300.0, 1e-3);
}

TEST(Thread, ItsMultiplierClosesWhatAPenaltyLeavesOpen) {
  PointConstraint thread = thread_of(1.0, kNoLimit, 50.0);
  thread.exact = true;
  thread.compliance = 1.0 / 950.0;  // 1000 mN/mm in all
  const Vec3 c(1.2, 0, 0);
  Vec3 multiplier = Vec3::Zero();
  for (int k = 0; k < 900; ++k) multiplier = thread.next_multiplier(c, multiplier);
  EXPECT_LT(thread.gap(c, multiplier), 1e-9);
  EXPECT_NEAR(thread.force(c, multiplier).norm(), 1000.0 * 0.2, 1.1);  // 1e-3 mm is lost at the knot
  for (int k = 0; k < 900; ++k) multiplier = thread.next_multiplier(Vec3(0.5, 0, 0), multiplier);
  EXPECT_NEAR(multiplier[0], 0.0, 1e-9);
}

// Two blocks of 6 x 8 x 3 mm, 1 mm apart, held at their outer ends, sewn in the middle of their walls.
class Sewn : public testing::Test {
 protected:
  FrameOutput solve(double stiffness, double length, double tension) {
    SessionSettings settings;
    settings.sutures = 1;
    settings.precision = "double";
    Session session(settings);
    Surface blocks = box_surface({0, 0, 0}, {6, 8, 3});
    append(blocks, box_surface({7, 0, 0}, {13, 8, 3}));
    EpochInput epoch = make_epoch(blocks, [](const Vec3& c) { return c[0] < 1e-9 || c[0] > 13 - 1e-9; });
    add_landmark(epoch, Vec3(6, 4.4, 1.4));
    add_landmark(epoch, Vec3(7, 4.4, 1.4));
    session.set_epoch(epoch);
    const auto at = [&](std::size_t k) { return Anchor{epoch.landmarks[k], epoch.landmark_triangles[k]}; };
    FrameInput frame;
    frame.time = 1;
    frame.sutures = {{0, at(0), at(1), 1.0, stiffness, true, length, tension}};
    const FrameOutput out = session.solve(frame, {}, kNever);
    EXPECT_TRUE(out.converged) << out.failure.message;
    return out;
  }
  static double apart(const FrameOutput& out) {
    return (Vec3::Map(out.suture_points.data()) - Vec3::Map(out.suture_points.data() + 3)).norm();
  }
};

TEST_F(Sewn, StiffnessMattersAndTheForceIsThatOfTheStretch) {
  double before = 0.0;
  for (const double stiffness : {1.0, 30.0, 1000.0}) {
    const FrameOutput out = solve(stiffness, 0.2, 0.0);
    EXPECT_NEAR(out.suture_forces[0], stiffness * (apart(out) - 0.2), 2e-3 * stiffness + 1e-3);
    const Vec3 along = Vec3::Map(out.suture_points.data() + 3) - Vec3::Map(out.suture_points.data());
    const Vec3 force = Vec3::Map(out.suture_force_vectors.data());
    EXPECT_LT((force - out.suture_forces[0] * along.normalized()).norm(), 0.02 * out.suture_forces[0]);
    EXPECT_GT(out.suture_forces[0], 1.2 * before);
    before = out.suture_forces[0];
  }
}

TEST_F(Sewn, AThreadAsStiffAsSteelKeepsItsLength) {
  const FrameOutput out = solve(1e8, 0.2, 0.0);
  EXPECT_NEAR(apart(out), 0.2, 3e-3);
  EXPECT_GT(out.suture_forces[0], 10.0);
}

TEST_F(Sewn, ALongThreadDoesNothing) {
  const FrameOutput out = solve(1000.0, 1.5, 0.0);
  EXPECT_EQ(out.suture_forces[0], 0.0);
  EXPECT_NEAR(apart(out), 1.0, 1e-6);
}

TEST_F(Sewn, ATensionThatIsGivenIsKept) {
  const FrameOutput out = solve(1000.0, 0.0, 5.0);
  EXPECT_NEAR(out.suture_forces[0], 5.0, 1e-3);
  EXPECT_GT(apart(out), 0.3);
  EXPECT_LT(apart(out), 1.0);
}

}  // namespace
}  // namespace lappet
