// Threads: they pull and never push, their energy, forces and tangent belong together, and the force on a thread is
// what its stiffness, its length and the most it is drawn with say. Sutures with slack: they hold their ends within it.
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
  constraint.pieces.resize(1);
  return constraint;
}

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

// The stiffness of all pieces together, as a thread's tangent says it.
Eigen::MatrixXd stiffness_of(const PointConstraint& thread, std::span<const Vec3> c, const Vec3& multiplier) {
  PointTangent tangent;
  thread.add_tangent(c, multiplier, tangent);
  const auto size = static_cast<Eigen::Index>(3 * c.size());
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(size, size);
  Eigen::VectorXd row = Eigen::VectorXd::Zero(size);
  for (Eigen::Index j = 0; j < std::ssize(c); ++j) {
    const Eigen::Matrix3d& root = tangent.roots[static_cast<std::size_t>(j)];
    result.block<3, 3>(3 * j, 3 * j) = root.transpose() * root;
    if (!tangent.rows.empty()) row.segment<3>(3 * j) = tangent.rows[static_cast<std::size_t>(j)];
  }
  return result + row * row.transpose();
}

double tension_of(const PointConstraint& thread, const Vec3& c, const Vec3& multiplier) {
  return thread.tension({&c, 1}, multiplier);
}

TEST(Thread, EnergyForceAndTangentBelongTogetherThroughAnyNumberOfBites) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> draw(-1.0, 1.0);
  std::size_t slack = 0, taut = 0, limited = 0;
  for (const std::size_t pieces : {1u, 2u, 5u})
    for (const double size : {1e-4, 1e-3, 0.1, 1.0, 4.0})
      for (const double length : {0.0, 0.05, 1.5})
        for (const double most : {kNoLimit, 150.0})
          for (const double multiplier : {0.0, 40.0}) {
            PointConstraint thread = thread_of(length, most);
            thread.pieces.resize(pieces);
            const Vec3 lambda(multiplier, 0.0, 0.0);
            std::vector<Vec3> c(pieces);
            for (Vec3& piece : c) piece = size * Vec3(draw(random), draw(random), draw(random));
            const std::vector<Vec3> forces = thread.forces(c, lambda);
            const double tension = thread.tension(c, lambda);
            slack += tension == 0.0;
            limited += std::abs(tension - most) < 0.1;
            taut += tension > 0.0 && tension < most;
            const Eigen::MatrixXd tangent = stiffness_of(thread, c, lambda);
            const double step = 1e-6 * std::max(size, 1e-3);
            for (std::size_t j = 0; j < pieces; ++j)
              for (int axis = 0; axis < 3; ++axis) {
                std::vector<Vec3> more = c, less = c;
                more[j][axis] += step;
                less[j][axis] -= step;
                const double slope = (thread.energy(more, lambda) - thread.energy(less, lambda)) / (2.0 * step);
                EXPECT_NEAR(slope, forces[j][axis], 1e-5 * (1.0 + tension)) << size << ' ' << length << ' ' << most;
                const std::vector<Vec3> up = thread.forces(more, lambda), down = thread.forces(less, lambda);
                Eigen::VectorXd turn(static_cast<Eigen::Index>(3 * pieces));
                for (std::size_t k = 0; k < pieces; ++k)
                  turn.segment<3>(static_cast<Eigen::Index>(3 * k)) = (up[k] - down[k]) / (2.0 * step);
                const auto column = tangent.col(static_cast<Eigen::Index>(3 * j) + axis);
                EXPECT_LT((turn - column).norm(), 1e-4 * (1.0 + tangent.norm())) << size << ' ' << length;
              }
          }
  EXPECT_GT(slack, 15u);
  EXPECT_GT(taut, 15u);
  EXPECT_GT(limited, 15u);
}

TEST(Thread, PullsAndNeverPushes) {
  const PointConstraint thread = thread_of(2.0, 300.0, 100.0);
  const Vec3 none = Vec3::Zero();
  const auto force = [&](const Vec3& c) { return thread.forces({&c, 1}, none).front(); };
  EXPECT_EQ(force(Vec3(1.9, 0, 0)), none);
  EXPECT_EQ(force(none), none);
  EXPECT_NEAR(force(Vec3(0, 3, 0))[1], 100.0, 0.2);  // 1e-3 mm is lost at the knot
  EXPECT_NEAR(force(Vec3(0, -9, 0))[1], -300.0, 1e-3);
}

TEST(Thread, ThatSlidesHasOneTensionWhichGoesByItsWholeLength) {
  PointConstraint thread = thread_of(4.0, kNoLimit, 100.0);
  thread.pieces.resize(3);
  const std::vector<Vec3> c{{1, 0, 0}, {0, 0, 2}, {0, -3, 0}};
  const std::vector<Vec3> forces = thread.forces(c, Vec3::Zero());
  EXPECT_NEAR(thread.tension(c, Vec3::Zero()), 100.0 * (6.0 - 4.0), 0.31);  // 1e-3 mm is lost at each piece
  for (std::size_t j = 0; j < 3; ++j) {
    EXPECT_NEAR(forces[j].norm() / forces[0].norm(), 1.0, 1e-6);
    EXPECT_NEAR(forces[j].normalized().dot(c[j].normalized()), 1.0, 1e-12);
  }
}

TEST(Thread, ItsMultiplierClosesWhatAPenaltyLeavesOpen) {
  PointConstraint thread = thread_of(1.0, kNoLimit, 50.0);
  thread.exact = true;
  thread.compliance = 1.0 / 950.0;  // 1000 mN/mm in all
  const Vec3 c(1.2, 0, 0), less(0.5, 0, 0);
  Vec3 multiplier = Vec3::Zero();
  for (int k = 0; k < 900; ++k) multiplier = thread.next_multiplier({&c, 1}, multiplier);
  EXPECT_LT(thread.gap({&c, 1}, multiplier), 1e-9);
  EXPECT_NEAR(tension_of(thread, c, multiplier), 1000.0 * 0.2, 1.1);  // 1e-3 mm is lost at the knot
  for (int k = 0; k < 900; ++k) multiplier = thread.next_multiplier({&less, 1}, multiplier);
  EXPECT_NEAR(multiplier[0], 0.0, 1e-9);
}

PointConstraint suture_with(double slack) {
  PointConstraint constraint;
  constraint.stiffness = 200.0;
  constraint.exact = true;
  constraint.slack = slack;
  constraint.pieces.resize(1);
  return constraint;
}

TEST(Slack, EnergyForceAndTangentBelongTogether) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> draw(-1.0, 1.0);
  const auto random_vector = [&](double size) { return Vec3(size * Vec3(draw(random), draw(random), draw(random))); };
  std::size_t free = 0, held = 0;
  for (const double slack : {0.0, 0.05, 0.2})
    for (const double size : {0.02, 0.1, 1.0})
      for (const double multiplier : {0.0, 10.0, 60.0})
        for (int sample = 0; sample < 5; ++sample) {
          const PointConstraint suture = suture_with(slack);
          const Vec3 c = random_vector(size), lambda = random_vector(multiplier);
          const auto force_at = [&](const Vec3& at) { return suture.forces({&at, 1}, lambda).front(); };
          const Vec3 force = force_at(c);
          (force.norm() == 0.0 ? free : held) += 1;
          const Eigen::MatrixXd tangent = stiffness_of(suture, {&c, 1}, lambda);
          const double step = 1e-6;
          for (int axis = 0; axis < 3; ++axis) {
            const Vec3 more = c + step * Vec3::Unit(axis), less = c - step * Vec3::Unit(axis);
            const double slope = (suture.energy({&more, 1}, lambda) - suture.energy({&less, 1}, lambda)) / (2.0 * step);
            EXPECT_NEAR(slope, force[axis], 1e-5 * (1.0 + force.norm())) << slack << ' ' << size;
            EXPECT_LT(((force_at(more) - force_at(less)) / (2.0 * step) - tangent.col(axis)).norm(), 1e-2);
          }
        }
  EXPECT_GT(free, 15u);
  EXPECT_GT(held, 15u);
}

// A spring of 5 mN/mm draws the ends apart, from 3 mm.
TEST(Slack, ItsMultiplierBecomesTheForceThatHoldsTheEndsWithinItAndFallsAgain) {
  const PointConstraint suture = suture_with(0.2);
  const Vec3 along = Vec3(1, 2, -2) / 3.0;
  const double spring = 5.0;
  Vec3 multiplier = Vec3::Zero();
  double open = 0.0;
  const auto settle = [&](double rest) {
    for (int update = 0; update < 20; ++update) {
      double low = 0.0, high = rest;  // where the forces balance
      for (int k = 0; k < 60; ++k) {
        open = 0.5 * (low + high);
        const Vec3 c = open * along;
        const double pull = suture.forces({&c, 1}, multiplier).front().dot(along);
        (pull > spring * (rest - open) ? high : low) = open;
      }
      const Vec3 c = open * along;
      multiplier = suture.next_multiplier({&c, 1}, multiplier);
    }
  };
  settle(3.0);
  EXPECT_NEAR(open, 0.2, 1e-9);
  EXPECT_NEAR(multiplier.dot(along), spring * 2.8, 1e-6);
  settle(0.5);
  EXPECT_NEAR(multiplier.dot(along), spring * 0.3, 1e-6);
  settle(0.1);  // the ends stay within the slack by themselves
  EXPECT_NEAR(open, 0.1, 1e-9);
  EXPECT_EQ(multiplier.norm(), 0.0);
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
