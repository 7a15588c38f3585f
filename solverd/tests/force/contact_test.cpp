// Contact with bones against statics: weights, slopes, pulleys; and its energy against its forces.
#include "force/constraints/contact.h"

#include <gtest/gtest.h>

#include <random>

#include "box.h"
#include "grid_box.h"
#include "lattice/refused.h"
#include "session/session.h"
#include "solve/newton/equilibrium.h"
#include "test_surfaces.h"

namespace lappet {
namespace {

const Vec3 kBall(20, 10, -15);
constexpr double kRadius = 15.0;

Surface ball(int rings = 50) { return test::sphere(kBall, kRadius, rings); }

Vec3 point(const FrameOutput& out, std::size_t v) {
  return {out.points[3 * v], out.points[3 * v + 1], out.points[3 * v + 2]};
}

TEST(Contact, ABlockOnABonesFlatTopSinksByItsWeightOverThePenalty) {
  SessionSettings s;
  s.materials[0].model = "corotated";
  s.materials[0].poissons_ratio = 0.0;
  s.gravity = Vec3(0, 0, -9.81);
  s.tolerance = 1e-6;
  s.precision = "double";
  s.bones = test::box({-5, -5, -10}, {12, 12, 0});
  Session session(s);
  EpochInput epoch = make_epoch(grid_box({0, 0, 0}, {6, 6, 4}, 1.0), {});
  add_landmark(epoch, Vec3(3, 3, 0));
  session.set_epoch(epoch);
  const FrameOutput out = session.solve(FrameInput{}, {}, kNever);
  ASSERT_TRUE(out.converged) << out.failure.message;
  const double weight = s.materials[0].density * 9.81e-6 * 4;  // kPa
  const double penalty = 10.0 * s.materials[0].youngs_modulus / s.spacing;
  EXPECT_NEAR(-landmark(out, 0)[2], weight / penalty, 0.01 * weight / penalty);
  EXPECT_EQ(out.contacts, 49);
}

class ContactSystem {
 public:
  ContactSystem(const Surface& surface, const Surface& bones, const std::function<bool(const Vec3&)>& fixed,
                double penalty, const Vec3& gravity)
      : epoch_(make_epoch(surface, fixed)), lattice_(build_lattice(surface, {})) {
    system_ = std::make_unique<System<double>>(lattice_, CellMaterials{{MaterialParameters{}}}, 1,
                                               attach(lattice_, surface, epoch_.fixed, epoch_.bed, epoch_.grip), 0,
                                               BedStiffness{10.0, 10.0}, gravity);
    const auto distance = std::make_shared<const SignedDistance>(bones, 0.5, 3.0, std::size_t{1} << 30);
    system_->set_contact(std::make_unique<Contact>(BoneDistance({distance}), lattice_, surface, epoch_.fixed, penalty));
    u.assign(3 * system_->nodes(), 0.0);
  }
  System<double>& system() { return *system_; }
  const Lattice& lattice() const { return lattice_; }
  std::vector<double> u;

 private:
  EpochInput epoch_;
  Lattice lattice_;
  std::unique_ptr<System<double>> system_;
};

TEST(Contact, ForcesAreTheDerivativeOfTheEnergyAndTheTangentThatOfTheForces) {
  const Surface tissue = grid_box({0, 0, 0}, {8, 6, 2}, 1.0);
  ContactSystem scene(tissue, test::sphere({4, 3, -6}, 6.6, 80), {}, 500.0, Vec3::Zero());
  auto& system = scene.system();
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (auto& x : scene.u) x = 0.03 * normal(random);
  std::vector<double> direction(scene.u.size());
  for (auto& x : direction) x = normal(random);
  for (const bool pressed : {false, true}) {
    Multipliers multipliers;
    if (pressed) system.update(multipliers, scene.u, system.evaluate(scene.u, multipliers));
    EXPECT_GT(system.evaluate(scene.u, multipliers).contact.count(), 10);
    const double eps = 1e-6;
    const auto moved = [&](double by) {
      auto v = scene.u;
      for (std::size_t i = 0; i < v.size(); ++i) v[i] += by * direction[i];
      return v;
    };
    const double up = system.evaluate(moved(eps), multipliers).energy,
                 down = system.evaluate(moved(-eps), multipliers).energy;
    const Evaluation at = system.evaluate(scene.u, multipliers);
    double slope = 0.0;
    for (std::size_t i = 0; i < direction.size(); ++i) slope += at.gradient[i] * direction[i];
    EXPECT_NEAR((up - down) / (2 * eps), slope, 1e-5 * std::abs(slope));

    // along the bone's normal the tangent is complete: lift everything
    std::vector<double> lift(scene.u.size(), 0.0), product(scene.u.size());
    for (std::size_t i = 2; i < lift.size(); i += 3) lift[i] = 1.0;
    system.linearize(at, PsdProjection::kExact);
    system.multiply(lift, product);
    double stiffness = 0.0, expected = 0.0;
    for (std::size_t i = 0; i < lift.size(); ++i) stiffness += lift[i] * product[i];
    for (const ContactPenalty& penalty : system.contact_penalties())
      expected += penalty.stiffness * penalty.direction[2] * penalty.direction[2];
    EXPECT_NEAR(stiffness, expected, 1e-4 * expected);  // a rigid lift strains nothing
  }
}

EquilibriumOutcome settle(ContactSystem& scene) {
  TwoLevel<double> preconditioner(scene.system(), 4);
  EquilibriumOptions options;
  options.tolerance = 1e-5;
  Multipliers multipliers;
  return find_equilibrium<double>(scene.system(), preconditioner, scene.u, multipliers, options,
                                  {[](int, double, double) {}, [] { return false; }});
}

TEST(Contact, TheBonesCarryTheWholeWeight) {
  ContactSystem scene(grid_box({0, 0, 0}, {6, 6, 4}, 1.0), test::box({-5, -5, -10}, {12, 12, 0}), {}, 500.0,
                      Vec3(0, 0, -9.81));
  const auto outcome = settle(scene);
  ASSERT_TRUE(outcome.converged) << outcome.failure.message;
  const double weight = MaterialParameters{}.density * 9.81e-6 * 6 * 6 * 4;
  EXPECT_NEAR(outcome.at.contact.force[2], weight, 1e-3 * weight);
  EXPECT_LT(outcome.at.contact.force.head<2>().norm(), 1e-9 * weight);
}

TEST(Contact, AStrapOverARollerHasTheSameTensionOnBothSides) {
  // Held at x = 0 and drawn down on the other side by hooks: a belt over a pulley without friction, wrapped unevenly.
  const Surface strap = grid_box({0, 0, 0}, {40, 6, 2}, 1.0);
  std::vector<Eigen::Vector2d> circle;
  const double radius = 9.0;
  for (int i = 0; i < 96; ++i) {
    const double a = 2 * std::numbers::pi * i / 96;
    circle.emplace_back(-radius + radius * std::cos(a), 18 + radius * std::sin(a));  // z, x: the axes after y
  }
  ContactSystem scene(
      strap, test::prism(circle, -6, 12, 1), [](const Vec3& c) { return c[0] < 1e-9; }, 500.0, Vec3::Zero());
  std::vector<PointConstraint> constraints;
  ContactState contact;
  for (const double down : {5.0, 12.0, 20.0}) {
    constraints.clear();
    const AnchorStencils stencils(scene.lattice(), strap, kStencilRadius);
    for (std::size_t t = 0; t < strap.triangles.size(); ++t) {
      const Vec3 c = center(strap, t);
      if (c[0] > 40 - 1e-9)
        constraints.push_back(
            make_hook(scene.lattice(), stencils.around(c, to_index(t)), Vec3(40 - 0.4 * down, c[1], c[2] - down), 3.0));
    }
    scene.system().set_point_constraints(constraints);
    const auto outcome = settle(scene);
    ASSERT_TRUE(outcome.converged) << outcome.failure.message;
    contact = outcome.at.contact;
  }
  Vec3 right = Vec3::Zero();
  for (const PointConstraint& constraint : constraints)
    right -= constraint.stiffness * constraint.pieces[0].value<double>(scene.u);
  const Vec3 left = -(right + contact.force);  // what the fixed end holds
  EXPECT_GT(right.norm(), 50.0);
  EXPECT_NEAR(left.norm() / right.norm(), 1.0, 0.03);
  EXPECT_LT(left.normalized()[0], -0.95);
  EXPECT_LT(contact.largest_penetration, 0.1);
  EXPECT_LT(std::abs(contact.force[1]), 1e-3 * right.norm());
}

// A strap over the ball, one end held by a retractor, the other by another; both drawn down and then along.
FrameInput strap_frame(double down, double along) {
  FrameInput frame = pulled({Vec3(along, 0, -down), Vec3(along, 0, -down)});
  return frame;
}

SessionSettings strap_settings() {
  SessionSettings s;
  s.retractors = 2;
  s.bones = ball();
  return s;
}

EpochInput strap() {
  return make_epoch(grid_box({0, 4, 0.5}, {40, 16, 2.5}, 1.0), {}, [](const Vec3& c) {
    return c[0] < 1e-9 ? 0 : c[0] > 40 - 1e-9 ? 1 : -1;
  });
}

TEST(Contact, AStrapDrawnOverABallSlidesAndNeverEntersByATenthOfTheSpacing) {
  for (const double spacing : {1.0, 2.0}) {
    SessionSettings s = strap_settings();
    s.spacing = spacing;
    s.origin = Vec3(0, 4, 0.5);
    Session session(s);
    const EpochInput epoch = strap();
    session.set_epoch(epoch);
    Vec3 before = Vec3::Zero();
    std::size_t top = 0;
    for (std::size_t v = 0; v < epoch.surface.points.size(); ++v)
      if ((epoch.surface.points[v] - Vec3(20, 10, 0.5)).norm() < 0.1) top = v;
    for (int f = 1; f <= 10; ++f) {
      const double down = 1.5 * std::min(f, 6), along = 1.0 * std::max(0, f - 6);
      const FrameOutput out = session.solve(strap_frame(down, along), {}, kNever);
      ASSERT_TRUE(out.converged) << f << ": " << out.failure.message;
      double deepest = 0.0;
      for (std::size_t v = 0; v < epoch.surface.points.size(); ++v)
        deepest = std::max(deepest, kRadius - (point(out, v) - kBall).norm());
      EXPECT_LT(deepest, 0.1 * spacing) << f;
      EXPECT_LT(out.largest_penetration, 0.1 * spacing) << f;
      EXPECT_NEAR(out.largest_penetration, deepest, 0.03 * spacing) << f;
      if (f > 1) {
        EXPECT_GT(out.contacts, 5) << f;
      }
      // Without friction the strap follows its ends around the ball; what it lags behind, it stretches.
      const Vec3 now = point(out, top);
      if (f > 7) {
        EXPECT_GT((now - before).norm(), 0.75) << f;
        const Vec3 normal = (0.5 * (now + before) - kBall).normalized();
        EXPECT_LT(std::abs((now - before).dot(normal)), 0.05) << f;
      }
      before = now;
    }
  }
}

TEST(Contact, GivesTheSameBitsForAnyThreadsAndTheSameTissueForABoneInTwoPieces) {
  std::vector<float> first;
  for (const int threads : {1, 3}) {
    SessionSettings s = strap_settings();
    s.threads = threads;
    Session session(s);
    session.set_epoch(strap());
    session.solve(strap_frame(3, 0), {}, kNever);
    const FrameOutput out = session.solve(strap_frame(5, 0.5), {}, kNever);
    ASSERT_TRUE(out.converged) << out.failure.message;
    if (first.empty()) first = out.points;
    EXPECT_EQ(out.points, first) << threads;
  }
  std::vector<std::vector<float>> results;
  for (const bool split : {false, true}) {
    SessionSettings s;
    s.retractors = 2;
    s.tolerance = 1e-4;
    s.bones = split ? box_surface({12, 0, -10}, {20, 20, 0}) : box_surface({12, 0, -10}, {28, 20, 0});
    if (split) test::append(s.bones, box_surface({20, 0, -10}, {28, 20, 0}));
    Session session(s);
    session.set_epoch(strap());
    const FrameOutput out = session.solve(strap_frame(3, 0), {}, kNever);
    ASSERT_TRUE(out.converged) << out.failure.message;
    results.push_back(out.points);
  }
  for (std::size_t i = 0; i < results[0].size(); ++i) ASSERT_NEAR(results[0][i], results[1][i], 1e-3) << i;
}

TEST(Contact, TissueThatStartsInBoneIsPushedOutOrRefusedWithItsDepth) {
  for (const double depth : {0.3, 1.2}) {
    SessionSettings s;
    s.bones = test::box({-5, -5, -10}, {12, 12, depth});
    Session session(s);
    const EpochInput epoch = make_epoch(grid_box({0, 0, 0}, {6, 6, 4}, 1.0), {});
    if (depth < 0.5) {
      session.set_epoch(epoch);
      const FrameOutput out = session.solve(FrameInput{}, {}, kNever);
      ASSERT_TRUE(out.converged) << out.failure.message;
      EXPECT_LT(out.largest_penetration, 0.1);
    } else {
      try {
        session.set_epoch(epoch);
        FAIL() << "it was taken";
      } catch (const RefusedError& error) {
        EXPECT_EQ(error.code(), ErrorCode::kInvalidInput);
        EXPECT_NE(std::string(error.what()).find("1.2 mm deep in bone"), std::string::npos) << error.what();
      }
    }
  }
}

// Found by the stability matrix, as the next one: no point of the surface lies in such a bone.
TEST(Contact, ABoneThatTissueEnclosesIsRefused) {
  SessionSettings s;
  s.bones = test::box({4, 4, 1}, {8, 8, 4});
  Session session(s);
  try {
    session.set_epoch(make_epoch(test::box({0, 0, 0}, {12, 12, 6}), [](const Vec3& c) { return c[2] < 1e-9; }));
    FAIL() << "the epoch was not refused";
  } catch (const RefusedError& error) {
    EXPECT_NE(std::string(error.what()).find("deep in bone"), std::string::npos) << error.what();
  }
}

TEST(Contact, AFaceThatARetractorCarriesIntoBoneIsNoEquilibrium) {
  for (const double down : {0.9, 3.0}) {
    SessionSettings s;
    s.retractors = 1;
    s.bones = test::box({-5, -5, -6}, {17, 17, -1});
    Session session(s);
    session.set_epoch(make_epoch(
        grid_box({0, 0, 0}, {12, 12, 6}, 2.0), [](const Vec3& c) { return c[2] > 6 - 1e-9; },
        [](const Vec3& c) { return c[2] < 1e-9 ? 0 : -1; }));
    const FrameOutput out = session.solve(pulled({Vec3(0, 0, -down)}), {}, kNever);
    EXPECT_EQ(out.converged, down < 1.0) << out.failure.message;
    EXPECT_EQ(out.failure.message.find("deep into bone") != std::string::npos, down > 1.0) << out.failure.message;
  }
}

TEST(Contact, ABoneThatIsOpenIsRefused) {
  SessionSettings s;
  s.bones = ball();
  s.bones.triangles.pop_back();
  EXPECT_THROW(Session{s}, RefusedError);
}

TEST(Contact, APressureOfTheModulusIsHeldByMultipliersWhereThePenaltyAloneWouldGiveWay) {
  // A block squeezed between a bone below and a retractor above, to two thirds of its height: pressures near the
  // modulus, where the penalty alone would leave more than a tenth of the spacing.
  SessionSettings s;
  s.retractors = 1;
  s.bones = test::box({-5, -5, -10}, {12, 12, 0});
  Session session(s);
  session.set_epoch(
      make_epoch(grid_box({0, 0, 0}, {6, 6, 4}, 1.0), {}, [](const Vec3& c) { return c[2] > 4 - 1e-9 ? 0 : -1; }));
  for (const double down : {0.8, 1.6, 2.4}) {
    const FrameOutput out = session.solve(pulled({Vec3(0, 0, -down)}), {}, kNever);
    ASSERT_TRUE(out.converged) << down << ": " << out.failure.message;
    EXPECT_LT(out.largest_penetration, 0.082) << down;
  }
}

TEST(Contact, ALongStepDoesNotTakeTissueThroughAThinBone) {
  SessionSettings s;
  s.retractors = 1;
  s.bones = test::box({-5, -5, -4}, {15, 11, -2.8});  // a plate of 1.2 mm
  Session session(s);
  const EpochInput epoch =
      make_epoch(grid_box({0, 0, 0}, {10, 6, 2}, 1.0), {}, [](const Vec3& c) { return c[0] < 1e-9 ? 0 : -1; });
  // A hook draws the free end far below the plate.
  std::int32_t triangle = 0;
  for (std::size_t t = 0; t < epoch.surface.triangles.size(); ++t)
    if ((center(epoch.surface, t) - Vec3(9.5, 3, 2)).norm() < 0.8) triangle = to_index(t);
  // In steps of so many mm: short ones must not take it through little by little.
  for (const double by : {14.0, 2.0, 0.25}) {
    session.set_epoch(epoch);
    FrameOutput out;
    for (double down = by; down <= 14.0; down += by) {
      FrameInput frame = pulled({Vec3::Zero()});
      frame.time = down;
      frame.hooks.push_back({{center(epoch.surface, triangle), triangle}, Vec3(9, 3, 2 - down), 30.0});
      out = session.solve(frame, {}, kNever);
      ASSERT_TRUE(out.converged) << by << " " << down << ": " << out.failure.message;
    }
    for (std::size_t v = 0; v < epoch.surface.points.size(); ++v) EXPECT_GT(point(out, v)[2], -2.9) << by << " " << v;
    EXPECT_GT(out.contacts, 0);
  }
}

}  // namespace
}  // namespace lappet
