// Tissue that meets tissue: blocks pressed together against the formula, a strip that folds on itself, wounds that are
// sutured, what a hook cannot carry through, and what a session that never comes near itself pays: nothing.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>

#include "force/self_contact/self_contact.h"
#include "grid_box.h"
#include "session/session.h"
#include "solve/system/reaction.h"

namespace lappet {
namespace {

SessionSettings with_contact(int retractors, bool on = true) {
  SessionSettings s;
  s.spacing = 1.0;
  s.retractors = retractors;
  s.self_contact = on;
  s.materials[0].model = "neoHookean";
  s.materials[0].youngs_modulus = 50.0;
  s.materials[0].poissons_ratio = 0.3;
  return s;
}

Vec3 point(const FrameOutput& out, std::size_t v) {
  return {out.points[3 * v], out.points[3 * v + 1], out.points[3 * v + 2]};
}

Vec3 reaction(const FrameOutput& out, Holder::Kind kind) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; 2 * k < out.holders.size(); ++k)
    if (out.holders[2 * k] == static_cast<std::int32_t>(kind)) sum += Vec3::Map(&out.reactions[3 * k]);
  return sum;
}

std::size_t piercings(const Surface& surface, const FrameOutput& out) {
  const Lattice lattice = build_lattice(surface, {});
  return SelfContact(lattice, surface, 50.0).count_piercings<double>(out.state.nodes);
}

// Two blocks of 4 x 4 x 3 mm on each other, a gap between them.
Surface stacked_blocks(double gap) {
  Surface surface = grid_box({0, 0, 0}, {4, 4, 3}, 0.5);
  append(surface, grid_box({0, 0, 3 + gap}, {4, 4, 6 + gap}, 0.4));
  return surface;
}

TEST(SelfContactSession, TwoBlocksPressedTogetherBearTheForceOfTheirShortening) {
  SessionSettings s = with_contact(1);
  s.materials[0].model = "corotated";
  s.materials[0].poissons_ratio = 0.0;
  s.precision = "double";
  s.tolerance = 1e-5;
  Session session(s);
  const double gap = 0.3;
  const Surface surface = stacked_blocks(gap);
  session.set_epoch(make_epoch(
      surface, [](const Vec3& c) { return c[2] < 1e-9; },
      [&](const Vec3& c) { return c[2] > 6 + gap - 1e-9 ? 0 : -1; }));
  for (const double push : {0.4, 0.6, 0.9, 1.5}) {
    const FrameOutput out = session.solve(pulled({Vec3(0, 0, -push)}), {}, kNever);
    ASSERT_TRUE(out.converged) << push << ": " << out.failure.message;
    EXPECT_GT(out.self_contacts, 81);
    EXPECT_EQ(out.piercings, 0);
    double below = 0.0, above = 0.0;
    int of_below = 0, of_above = 0;
    for (std::size_t v = 0; v < surface.points.size(); ++v) {
      if (std::abs(surface.points[v][2] - 3) < 1e-9) below += point(out, v)[2], ++of_below;
      if (std::abs(surface.points[v][2] - 3 - gap) < 1e-9) above += point(out, v)[2], ++of_above;
    }
    const double left = above / of_above - below / of_below;
    EXPECT_GT(left, 0.1 * 0.05) << push;  // of the reach
    EXPECT_LT(left, 0.05);
    const double shortening = push - (gap - left), force = 50.0 * 16.0 * shortening / 6.0;
    EXPECT_NEAR(reaction(out, Holder::Kind::kFixed)[2], force, 0.02 * force) << push;
    EXPECT_NEAR(reaction(out, Holder::Kind::kRetractor)[2], -force, 0.02 * force) << push;
  }
}

// A block is pressed on a larger one, carried aside and back: it sticks while shear is less than Coulomb's law allows,
// slides at what that allows, and sticks again on the way back.
TEST(SelfContactSession, ABlockSticksUntilFrictionIsOvercomeAndThenSlidesAtCoulombsForce) {
  SessionSettings s = with_contact(1);
  s.materials[0].model = "corotated";
  s.materials[0].poissons_ratio = 0.0;
  s.precision = "double";
  const double gap = 0.3, push = 0.45;
  Surface surface = grid_box({0, 0, 0}, {12, 8, 3}, 1.0);
  const std::size_t first_of_upper = surface.points.size();
  append(surface, grid_box({4, 2, 3 + gap}, {8, 6, 6 + gap}, 0.8));
  const auto vertex_at = [&](const Vec3& at, std::size_t from, std::size_t to) {
    std::size_t nearest = from;
    for (std::size_t v = from; v < to; ++v)
      if ((surface.points[v] - at).norm() < (surface.points[nearest] - at).norm()) nearest = v;
    return nearest;
  };
  const std::size_t below = vertex_at({6, 4, 3}, 0, first_of_upper),
                    above = vertex_at({6, 4, 3 + gap}, first_of_upper, surface.points.size());
  struct Found {
    double shear, pressure, apart;
  };
  const auto carried = [&](double friction, const std::vector<double>& ways) {
    s.friction = friction;
    Session session(s);
    session.set_epoch(make_epoch(
        surface, [](const Vec3& c) { return c[2] < 1e-9; },
        [&](const Vec3& c) { return c[2] > 6 + gap - 1e-9 ? 0 : -1; }));
    std::vector<Found> result;
    for (const double way : ways) {
      FrameInput frame = pulled({Vec3(way, 0, -push)});
      frame.time = double(result.size() + 1);
      const FrameOutput out = session.solve(frame, {}, kNever);
      EXPECT_TRUE(out.converged) << way << ": " << out.failure.message;
      EXPECT_EQ(out.piercings, 0);
      const Vec3 held = reaction(out, Holder::Kind::kFixed);
      result.push_back({-held[0], held[2], point(out, above)[0] - point(out, below)[0]});
    }
    return result;
  };
  const std::vector<double> ways{0.0, 0.05, 0.1, 1.0, 1.4, 1.35};
  const double friction = 0.3, creep = 2e-3 * s.spacing;
  const std::vector<Found> found = carried(friction, ways), smooth = carried(0.0, ways);
  for (const std::size_t k : {1UL, 2UL}) {  // it holds
    EXPECT_NEAR(found[k].apart, found[k - 1].apart, creep) << ways[k];
    EXPECT_LT(found[k].shear, friction * found[k].pressure) << ways[k];
    EXPECT_GT(found[k].shear, 5.0 * std::abs(smooth[k].shear)) << ways[k];
  }
  EXPECT_NEAR(found[2].shear, 2.0 * found[1].shear, 0.1 * found[2].shear);
  for (const std::size_t k : {3UL, 4UL}) {  // it slides
    EXPECT_NEAR(found[k].shear, friction * found[k].pressure, 0.03 * found[k].shear) << ways[k];
    EXPECT_GT(found[k].apart, found[k - 1].apart + 50.0 * creep) << ways[k];
  }
  EXPECT_NEAR(found[5].apart, found[4].apart, 2.0 * creep);  // and holds, once it has crept back
  EXPECT_LT(found[5].shear, 0.8 * found[4].shear);
  for (std::size_t k = 0; k < ways.size(); ++k) EXPECT_NEAR(smooth[k].shear, 0.0, 0.01 * smooth[k].pressure) << ways[k];
}

TEST(SelfContactSession, FrictionWithoutSelfContactIsRefused) {
  SessionSettings s = with_contact(1, false);
  s.friction = 0.3;
  EXPECT_ANY_THROW(Session{s});
  s.self_contact = true;
  s.friction = -0.1;
  EXPECT_ANY_THROW(Session{s});
}

// Turned over, its end comes down on its own middle, whose underside is held, and presses on it.
TEST(SelfContactSession, AStripThatIsFoldedOntoItselfNeverPassesThroughItself) {
  const Surface strip = grid_box({0, 0, 0}, {30, 4, 2}, 1.0);
  const auto fold = [&](bool on, std::vector<FrameOutput>& frames) {
    Session session(with_contact(1, on));
    session.set_epoch(make_epoch(
        strip, [](const Vec3& c) { return c[0] < 14 && c[2] < 1e-9; },
        [](const Vec3& c) { return c[0] > 30 - 1e-9 ? 0 : -1; }));
    constexpr int kFrames = 10;
    for (int f = 1; f <= kFrames; ++f) {
      const double share = double(f) / kFrames;
      const Vec3 end(30, 2, 1);
      const Vec3 to(30 - 24 * share, 2.3, 1 + 10 * std::sin(std::numbers::pi * share) + 1.7 * share);
      const Eigen::Isometry3d motion = Eigen::Translation3d(to) *
                                       Eigen::AngleAxisd(-std::numbers::pi * share, Vec3::UnitY()) *
                                       Eigen::Translation3d(-end);
      FrameInput frame;
      frame.time = f;
      frame.retractors = {{0, motion.matrix()}};
      frames.push_back(session.solve(frame, {}, kNever));
    }
  };
  std::vector<FrameOutput> apart, through;
  fold(true, apart);
  fold(false, through);
  for (const FrameOutput& out : apart) {
    EXPECT_TRUE(out.converged) << out.time << ": " << out.failure.message;
    EXPECT_EQ(out.piercings, 0) << out.time;
    EXPECT_EQ(piercings(strip, out), 0U) << out.time;
  }
  EXPECT_GT(apart.back().self_contacts, 0);
  EXPECT_TRUE(through.back().converged);
  EXPECT_GT(piercings(strip, through.back()), 0U);
}

// Two blocks beside each other, as a cut leaves them.
Surface cut_block(double gap) {
  Surface surface = grid_box({0, 0, 0}, {10 - gap / 2, 6, 3}, 1.0);
  append(surface, grid_box({10 + gap / 2, 0, 0}, {20, 6, 3}, 0.8));
  return surface;
}

EpochInput held_at_both_ends(const Surface& surface) {
  return make_epoch(
      surface, [](const Vec3& c) { return c[0] < 1e-9; }, [](const Vec3& c) { return c[0] > 20 - 1e-9 ? 0 : -1; });
}

TEST(SelfContactSession, WhatNeverComesNearItselfHasTheSameBitsAsWithout) {
  std::vector<FrameOutput> outputs[2];
  for (const bool on : {false, true}) {
    Session session(with_contact(1, on));
    session.set_epoch(held_at_both_ends(cut_block(0.05)));
    for (const double pull : {2.0, 5.0}) outputs[on].push_back(session.solve(pulled({Vec3(pull, 1, 2)}), {}, kNever));
  }
  for (std::size_t f = 0; f < 2; ++f) {
    ASSERT_TRUE(outputs[1][f].converged);
    EXPECT_EQ(outputs[0][f].points, outputs[1][f].points);
    EXPECT_EQ(outputs[0][f].state.nodes, outputs[1][f].state.nodes);
    EXPECT_EQ(outputs[0][f].energy, outputs[1][f].energy);
    EXPECT_EQ(outputs[0][f].newton_iterations, outputs[1][f].newton_iterations);
    EXPECT_EQ(outputs[0][f].pcg_iterations, outputs[1][f].pcg_iterations);
    EXPECT_EQ(outputs[1][f].self_contacts, 0);
  }
}

// Where it ends it is as far from the other block as where it began: only the way between tells.
TEST(SelfContactSession, ABlockThatIsCarriedBeyondAnotherInOneFrameDoesNotJumpOverIt) {
  Surface surface = grid_box({0, 0, 0}, {4, 4, 4}, 1.0);
  append(surface, grid_box({6, 0, 0}, {10, 4, 4}, 1.0));
  const EpochInput epoch = make_epoch(
      surface, [](const Vec3& c) { return c[0] < 5 && c[2] < 1e-9; },
      [](const Vec3& c) { return c[0] > 5 && c[2] > 4 - 1e-9 ? 0 : -1; });
  const FrameInput frame = pulled({Vec3(-12, 0, 0)});
  Session without(with_contact(1, false)), with(with_contact(1));
  without.set_epoch(epoch);
  with.set_epoch(epoch);
  const FrameOutput jumped = without.solve(frame, {}, kNever);
  ASSERT_TRUE(jumped.converged);
  EXPECT_EQ(piercings(surface, jumped), 0U);
  const FrameOutput blocked = with.solve(frame, {}, kNever);
  EXPECT_FALSE(blocked.converged);
  EXPECT_EQ(blocked.piercings, 0);
}

TEST(SelfContactSession, ACutAtRestHasNoForceHoweverThinItIs) {
  for (const double gap : {0.01, 0.05, 0.3}) {
    Session session(with_contact(1));
    session.set_epoch(held_at_both_ends(cut_block(gap)));
    const FrameOutput out = session.solve(FrameInput{}, {}, kNever);
    ASSERT_TRUE(out.converged);
    EXPECT_EQ(out.newton_iterations, 0) << gap;
    EXPECT_EQ(out.energy, 0.0) << gap;
    EXPECT_EQ(out.self_contacts, 0) << gap;
  }
}

TEST(SelfContactSession, SuturesCloseThroughContactAsFarAsWallsThatTouchLetThem) {
  SessionSettings s = with_contact(1);
  s.sutures = 3;
  Session session(s);
  const double gap = 1.0;
  const Surface surface = cut_block(gap);
  session.set_epoch(held_at_both_ends(surface));
  const auto anchor = [&](double x, double y) {
    EpochInput epoch;
    epoch.surface = surface;
    add_landmark(epoch, Vec3(x, y, 3));
    return Anchor{epoch.landmarks[0], epoch.landmark_triangles[0]};
  };
  FrameInput frame = pulled({Vec3(0, 0, 0)});
  for (int k = 0; k < 3; ++k) {
    SutureState suture{k, anchor(10 - gap / 2, 1.0 + 2 * k), anchor(10 + gap / 2, 1.0 + 2 * k), 1.0, 1000.0};
    frame.sutures.push_back(suture);
  }
  const FrameOutput out = session.solve(frame, {}, kNever);
  ASSERT_TRUE(out.converged) << out.failure.message;
  EXPECT_LE(out.largest_gap, (1.25 * 0.05 + s.gap_tolerance) * s.spacing);  // what walls that touch are apart
  EXPECT_EQ(out.piercings, 0);
  EXPECT_GT(out.self_contacts, 0);
}

// The walls do not face each other at rest, as those that the flaps of a Z-plasty bring together: a retractor turns one
// of them to the other. A solve that is resumed once they do face must find the same walls.
TEST(SelfContactSession, ASutureBringsTheSameWallsTogetherWhereverTheSolveIsResumed) {
  Surface surface = grid_box({0, 0, 0}, {6, 6, 3}, 1.0);
  append(surface, grid_box({10, 0, 0}, {16, 6, 3}, 1.0));
  EpochInput epoch = make_epoch(
      surface, [](const Vec3& c) { return c[0] < 1e-9; },
      [](const Vec3& c) { return c[1] > 6 - 1e-9 && c[0] > 9 ? 0 : -1; });
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const Vec3 c = center(surface, t);
    epoch.walls.push_back(std::abs(c[0] - 6) < 1e-9 || (c[0] > 9 && c[1] < 1e-9));
  }
  add_landmark(epoch, Vec3(6, 3, 3));
  add_landmark(epoch, Vec3(13, 0, 3));
  // About the middle of the second wall, so that it faces the first one, 1 mm away.
  const Vec3 middle(13, 0, 1.5);
  const Eigen::Isometry3d turned = Eigen::Translation3d(Vec3(7, 3, 1.5)) *
                                   Eigen::AngleAxisd(-0.5 * std::numbers::pi, Vec3::UnitZ()) *
                                   Eigen::Translation3d(-middle);
  SessionSettings s = with_contact(1);
  s.sutures = 1;
  const auto frame_at = [&](double time, double closure) {
    FrameInput frame;
    frame.time = time;
    frame.retractors = {{0, turned.matrix()}};
    const auto anchor = [&](std::size_t k) { return Anchor{epoch.landmarks[k], epoch.landmark_triangles[k]}; };
    if (closure >= 0.0) frame.sutures = {{0, anchor(0), anchor(1), closure, 1000.0}};
    return frame;
  };
  Session through(s), resumed(s);
  through.set_epoch(epoch);
  resumed.set_epoch(epoch);
  ASSERT_TRUE(through.solve(frame_at(1, -1.0), {}, kNever).converged);
  const FrameOutput before = through.solve(frame_at(2, 0.0), {}, kNever);
  ASSERT_TRUE(before.converged) << before.failure.message;
  const FrameOutput closed = through.solve(frame_at(3, 1.0), {}, kNever);
  ASSERT_TRUE(closed.converged) << closed.failure.message;
  EXPECT_GT(closed.self_contacts, 0);
  EXPECT_EQ(closed.piercings, 0);
  resumed.set_state(before.state);
  const FrameOutput again = resumed.solve(frame_at(3, 1.0), {}, kNever);
  EXPECT_EQ(closed.points, again.points);
  EXPECT_EQ(closed.state.nodes, again.state.nodes);
  // Without the labels the suture holds its anchors, which come together where the walls lie in each other.
  epoch.walls.clear();
  Session unlabeled(s);
  unlabeled.set_epoch(epoch);
  unlabeled.set_state(before.state);
  EXPECT_NE(unlabeled.solve(frame_at(3, 1.0), {}, kNever).points, closed.points);
}

// The blocks are stout, so that the one neither bends aside nor climbs over the other.
TEST(SelfContactSession, AHookIsHeldBackByWhatIsInItsWay) {
  Session session(with_contact(1));
  Surface surface = grid_box({0, 0, 0}, {9.75, 12, 12}, 1.0);
  append(surface, grid_box({10.25, 0, 0}, {20, 12, 12}, 0.8));
  EpochInput epoch = held_at_both_ends(surface);
  add_landmark(epoch, Vec3(10.25, 6, 6));  // in the middle of its wall: pulled, it does not tip over
  session.set_epoch(epoch);
  FrameInput frame;
  frame.time = 1;
  frame.hooks.push_back({{epoch.landmarks[0], epoch.landmark_triangles[0]}, Vec3(5, 6, 6), 20.0});
  const FrameOutput out = session.solve(frame, {}, kNever);
  ASSERT_TRUE(out.converged) << out.failure.message;
  EXPECT_EQ(out.piercings, 0);
  EXPECT_GT(out.self_contacts, 0);
  const Vec3 force = Vec3::Map(out.hook_forces.data());
  EXPECT_GT(out.hook_points[0], 9.0);
  const Vec3 held = reaction(out, Holder::Kind::kFixed) + reaction(out, Holder::Kind::kWeakBed);
  EXPECT_LT((held + force).norm(), 0.01 * force.norm());
  EXPECT_GT(reaction(out, Holder::Kind::kFixed)[0], -0.5 * force[0]);
}

TEST(SelfContactSession, AStartThatGoesThroughItselfIsToldAndSolved) {
  const Surface surface = cut_block(0.3);
  const EpochInput epoch = held_at_both_ends(surface);
  const FrameInput frame = pulled({Vec3(-1.2, 0.13, 0.21)});
  Session without(with_contact(1, false)), with(with_contact(1));
  without.set_epoch(epoch);
  with.set_epoch(epoch);
  const FrameOutput through = without.solve(frame, {}, kNever);
  ASSERT_TRUE(through.converged);
  ASSERT_GT(piercings(surface, through), 0U);
  with.set_state(through.state);
  const FrameOutput told = with.solve(frame, {}, kNever);
  EXPECT_EQ(std::size_t(told.piercings_before), piercings(surface, through));
  EXPECT_EQ(told.untangled, 0);
  EXPECT_TRUE(told.converged) << told.failure.message;
}

// How far the block was pushed together where the frame starts, mm; the frame pushes it by 0.6 mm.
class SelfContactStart : public testing::TestWithParam<double> {};

TEST_P(SelfContactStart, ThatGoesThroughItselfIsTakenApartAndRestsWhereItWouldFromApart) {
  SessionSettings settings = with_contact(1);
  settings.precision = "double";
  settings.tolerance = 1e-6;
  const Surface surface = cut_block(0.3);
  const EpochInput epoch = held_at_both_ends(surface);
  const auto pushed = [](double by) { return pulled({Vec3(-by, 0.13, 0.21)}); };
  Session with(settings), apart(settings);
  settings.self_contact = false;
  Session without(settings);
  for (Session* session : {&with, &apart, &without}) session->set_epoch(epoch);
  const FrameOutput through = without.solve(pushed(GetParam()), {}, kNever);
  ASSERT_TRUE(through.converged);
  const std::size_t places = piercings(surface, through);
  ASSERT_GT(places, 0U);
  with.set_state(through.state);
  const FrameOutput taken_apart = with.solve(pushed(0.6), {}, kNever), never_met = apart.solve(pushed(0.6), {}, kNever);
  ASSERT_TRUE(taken_apart.converged) << taken_apart.failure.message;
  ASSERT_TRUE(never_met.converged) << never_met.failure.message;
  EXPECT_EQ(std::size_t(taken_apart.piercings_before), places);
  EXPECT_EQ(std::size_t(taken_apart.untangled), places);
  EXPECT_EQ(taken_apart.piercings, 0);
  EXPECT_EQ(piercings(surface, taken_apart), 0U);
  EXPECT_GT(taken_apart.self_contacts, 0);
  EXPECT_NEAR(taken_apart.energy, never_met.energy, 1e-4 * never_met.energy);
  for (std::size_t i = 0; i < never_met.points.size(); ++i)
    EXPECT_NEAR(taken_apart.points[i], never_met.points[i], 1e-3);
}

// By little it is taken apart before the frame is solved, from too deep where it rests.
INSTANTIATE_TEST_SUITE_P(ByLittleAndTooDeep, SelfContactStart, testing::Values(0.6, 1.2));

}  // namespace
}  // namespace lappet
