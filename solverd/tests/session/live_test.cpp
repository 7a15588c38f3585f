// Live mode: frames that follow a drag are those that are found one by one, in fewer iterations.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "box.h"
#include "session/find_frame.h"
#include "session/session.h"
#include "solve/newton/predict_motion.h"

namespace lappet {

namespace {

const Vec3 kHooked(28, 4, 3);

// A strip that is held at one end.
EpochInput strip() {
  return make_epoch(box_surface({0, 0, 0}, {30, 8, 3}), [](const Vec3& c) { return c[0] < 1e-9; });
}

SessionSettings settings(bool live, double tolerance = 1e-3) {
  SessionSettings s;
  s.spacing = 1;
  s.stability = false;
  s.live = live;
  s.tolerance = tolerance;
  return s;
}

// Its other end, dragged from place to place.
template <class Real>
struct Drag {
  explicit Drag(const SessionSettings& s)
      : settings(s),
        input(strip()),
        epoch(input, settings, std::nullopt, nullptr, {}),
        state(carry_over(initial_state<Real>(settings), nullptr, epoch.lattice, {})) {
    EpochInput probe = input;
    add_landmark(probe, kHooked);
    anchor = {kHooked, probe.landmark_triangles.back()};
  }
  FrameInput hooked(const Vec3& by) const {
    FrameInput frame;
    frame.hooks = {{anchor, kHooked + by, 300.0, 0}};
    return frame;
  }
  SolveEffort to(const Vec3& by) {
    FoundFrame<Real> found = find_frame<Real>(settings, epoch, state, hooked(by), {}, {}, kNever);
    EXPECT_TRUE(found.outcome.converged) << found.outcome.failure.message;
    EXPECT_EQ(found.effort.restart, Restart::kNone);
    state = std::move(found.state);
    effort.add(found.effort);
    return found.effort;
  }

  SessionSettings settings;
  EpochInput input;
  EpochSystem<Real> epoch;
  TissueState<Real> state;
  Anchor anchor;
  SolveEffort effort;
};

// Up, back, and on along a bow to the side.
std::vector<Vec3> ways() {
  std::vector<Vec3> by;
  for (int k = 1; k <= 8; ++k) by.emplace_back(0, 0, 0.4 * k);
  for (int k = 1; k <= 8; ++k) by.emplace_back(0, 0, 3.2 - 0.4 * k);
  for (int k = 1; k <= 8; ++k) by.emplace_back(0.1 * k, 4 * std::sin(0.1 * k), 0.05 * k * k);
  return by;
}

template <class A, class B>
double largest_distance(const std::vector<A>& a, const std::vector<B>& b) {
  double most = 0.0;
  for (std::size_t i = 0; i < a.size(); i += 3)
    most = std::max(most, std::hypot(double(a[i]) - double(b[i]), double(a[i + 1]) - double(b[i + 1]),
                                     double(a[i + 2]) - double(b[i + 2])));
  return most;
}

}  // namespace

// At the tolerance of live mode and at that of frames.
TEST(Live, ADragIsFollowedInFewerIterationsToTheSamePlaces) {
  for (const double tolerance : {1e-2, 1e-3}) {
    Drag<float> followed(settings(true, tolerance)), one_by_one(settings(false, tolerance));
    SessionSettings exactly = settings(false, 1e-7);
    exactly.precision = "double";
    Drag<double> exact(exactly);
    const double left = kSpacingsPerTolerance * tolerance * followed.settings.spacing;
    for (const Vec3& by : ways()) {
      followed.to(by);
      one_by_one.to(by);
      exact.to(by);
      EXPECT_LE(largest_distance(followed.state.u, exact.state.u), left);
      EXPECT_LE(largest_distance(one_by_one.state.u, exact.state.u), left);
    }
    EXPECT_LT(followed.effort.newton_iterations, one_by_one.effort.newton_iterations);
    // A coarse operator that is kept may cost a few.
    EXPECT_LE(followed.effort.pcg_iterations, 1.1 * one_by_one.effort.pcg_iterations);
  }
}

TEST(Live, TheCoarseOperatorOfOneUpdateServesTheNext) {
  Drag<float> followed(settings(true)), one_by_one(settings(false));
  for (const Vec3& by : ways()) {
    followed.to(by);
    one_by_one.to(by);
  }
  EXPECT_LE(3 * followed.epoch.preconditioner.assemblies(), one_by_one.epoch.preconditioner.assemblies());
}

TEST(Live, FarFromWhereItWasSetUpItIsSetUpAnew) {
  Drag<float> followed(settings(true)), one_by_one(settings(false));
  int most = 0, most_one_by_one = 0;
  for (int k = 1; k <= 40; ++k) {
    const double turn = 0.06 * k;  // the strip bends by more than a right angle
    const Vec3 by(-18 * (1 - std::cos(turn)), 0, 18 * std::sin(turn));
    most = std::max(most, followed.to(by).pcg_iterations);
    most_one_by_one = std::max(most_one_by_one, one_by_one.to(by).pcg_iterations);
  }
  EXPECT_GT(followed.epoch.preconditioner.assemblies(), 1U);
  EXPECT_LE(most, 2 * most_one_by_one);
}

TEST(Live, ADragIsTheSameBitForBitWithAnyNumberOfThreads) {
  const auto nodes = [](int threads) {
    SessionSettings s = settings(true);
    s.threads = threads;
    Session session(s);
    const EpochInput epoch = strip();
    session.set_epoch(epoch);
    const Drag<float> frames(s);
    std::vector<std::vector<double>> found;
    for (const Vec3& by : ways()) found.push_back(session.solve(frames.hooked(by), {}, kNever).state.nodes);
    return found;
  };
  EXPECT_EQ(nodes(1), nodes(2));
}

TEST(Live, WhereTissueMayTouchFramesAreFoundOneByOne) {
  const auto nodes = [](bool live, bool bone) {
    SessionSettings s = settings(live);
    s.self_contact = !bone;
    if (bone) s.bones = box_surface({20, -2, -6}, {32, 10, -1});
    Session session(s);
    // Two strips, one above the other, of which the hook draws the upper one down on what is below.
    EpochInput epoch = strip();
    Surface surface = box_surface({0, 0, -4}, {30, 8, -1});
    if (!bone) {
      append(surface, epoch.surface);
      epoch = make_epoch(surface, [](const Vec3& c) { return c[0] < 1e-9; });
    }
    session.set_epoch(epoch);
    EpochInput probe = epoch;
    add_landmark(probe, kHooked);
    std::vector<std::vector<double>> found;
    std::int32_t touching = 0;
    for (int k = 1; k <= 6; ++k) {
      FrameInput frame;
      frame.hooks = {{{kHooked, probe.landmark_triangles.back()}, kHooked - Vec3(0, 0, 0.6 * k), 300.0, 0}};
      const FrameOutput out = session.solve(frame, {}, kNever);
      EXPECT_TRUE(out.converged) << out.failure.message;
      touching += out.contacts + out.self_contacts;
      found.push_back(out.state.nodes);
    }
    EXPECT_GT(touching, 0);
    return found;
  };
  EXPECT_EQ(nodes(true, true), nodes(false, true));
  // Before they touch they are followed freely: the last ones, which touch, are within what may be left.
  const auto followed = nodes(true, false), one_by_one = nodes(false, false);
  for (std::size_t k = 0; k < followed.size(); ++k)
    EXPECT_LE(largest_distance(followed[k], one_by_one[k]), 2 * kSpacingsPerTolerance * 1e-3);
}

TEST(Live, AMotionIsPredictedWhicheverWayTheTargetGoes) {
  Drag<float> drag(settings(true));
  drag.to({0, 0, 2});
  drag.epoch.motions.clear();
  for (const Vec3& by : {Vec3(0.2, 0, 2), Vec3(0.2, 0.2, 2), Vec3(0.2, 0.2, 2.2)}) drag.to(by);
  ASSERT_EQ(drag.epoch.motions.size(), 3U);
  System<float>& system = drag.epoch.system;
  // Back in all three directions, by other shares.
  drag.epoch.constraints.apply(drag.hooked({0.1, -0.1, 2.05}), drag.state);
  const Evaluation start = system.evaluate(drag.state.u, drag.state.multipliers);
  const double residual = start.relative_residual, energy = start.energy;
  std::vector<float> motion(drag.state.u.size());
  std::vector<std::vector<float>> twice = drag.epoch.motions;
  twice.insert(twice.end(), drag.epoch.motions.begin(), drag.epoch.motions.end());
  predict_motion<float>(system, start, twice, motion);
  std::vector<float> u = drag.state.u;
  for (std::size_t i = 0; i < u.size(); ++i) {
    EXPECT_TRUE(system.is_free(i / 3) || motion[i] == 0.0F);
    u[i] += motion[i];
  }
  const Evaluation end = system.evaluate(u, drag.state.multipliers);
  EXPECT_LT(end.relative_residual, 0.1 * residual);
  EXPECT_LT(end.energy, energy);
}

}  // namespace lappet
