// Bad starts and demands that have no equilibrium: the same answer as from rest, or a sentence.
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include <functional>
#include <random>
#include <tuple>

#include "session/retry_schedule.h"
#include "sheet.h"

namespace lappet {
namespace {

using Start = std::function<Vec3(const Vec3& rest)>;  // positions, mm

SolverState state_of(const Lattice& lattice, const Start& start) {
  SolverState state;
  state.is_double = true;
  state.activation = {0.0};
  for (const Vec3& rest : lattice.node_rest) {
    const Vec3 u = start(rest) - rest;
    state.nodes.insert(state.nodes.end(), {u[0], u[1], u[2]});
  }
  return state;
}

double difference(const SolverState& a, const SolverState& b) {
  double most = 0.0;
  for (std::size_t i = 0; i < a.nodes.size(); ++i) most = std::max(most, std::abs(a.nodes[i] - b.nodes[i]));
  return most;
}

struct NamedStart {
  const char* name;
  Start start;
};

// Uniform in [-0.5, 0.5], by the place.
Vec3 noise(const Vec3& x) {
  std::mt19937 random(static_cast<unsigned>(7.0 + 2.0 * (x[0] + 1009.0 * x[1] + 65537.0 * x[2])));
  std::uniform_real_distribution<double> unit(-0.5, 0.5);
  const double a = unit(random), b = unit(random), c = unit(random);
  return {a, b, c};
}

const NamedStart kStarts[] = {
    {"Collapsed", [](const Vec3& x) { return Vec3(x[0], x[1], 0.0); }},
    {"CollapsedAlongThePull", [](const Vec3& x) { return Vec3(50.0, x[1], x[2]); }},
    {"Inverted", [](const Vec3& x) { return Vec3(x[0], x[1], -x[2]); }},
    {"Random", [](const Vec3& x) { return Vec3(noise(x).cwiseProduct(kSheet) + 0.5 * kSheet); }},
    // those below are valid to start from: Newton's iteration itself must come back
    {"ATenthAsThick", [](const Vec3& x) { return Vec3(x[0], x[1], 0.1 * x[2]); }},
    {"ATenthAsLong", [](const Vec3& x) { return Vec3(50.0 + 0.1 * (x[0] - 50.0), x[1], x[2]); }},
    {"RandomByHalfASpacing", [](const Vec3& x) { return Vec3(x + 2.0 * noise(x)); }},
    {"APatchTurnedOver",
     [](const Vec3& x) {
       const bool patch = std::abs(x[0] - 50.5) < 2.5 && std::abs(x[1] - 35.0) < 5.0;
       return Vec3(x[0], x[1], patch ? 4.0 - x[2] : x[2]);
     }},
};

class BadStart : public ::testing::TestWithParam<std::tuple<const char*, NamedStart>> {};

TEST_P(BadStart, ASheetStretchedByThirtyPercentAndTwistedReachesTheEquilibriumFromRest) {
  SheetScene scene;
  scene.model = std::get<0>(GetParam());
  Session session(sheet_settings(scene));
  session.set_epoch(sheet_epoch());
  const Lattice lattice = sheet_lattice(scene);
  const FrameOutput expected = session.solve(sheet_frame(scene), {}, kNever);
  ASSERT_TRUE(expected.converged) << expected.failure.message;
  ASSERT_EQ(expected.inverted_cells, 0);
  EXPECT_EQ(expected.restart, Restart::kNone) << "there was nothing before it";

  session.set_state(state_of(lattice, std::get<1>(GetParam()).start));
  const FrameOutput out = session.solve(sheet_frame(scene), {}, kNever);
  ASSERT_TRUE(out.converged) << out.failure.message;
  EXPECT_EQ(out.inverted_cells, 0);
  EXPECT_LT(difference(out.state, expected.state), 2e-4 * scene.spacing);
  EXPECT_NEAR(out.energy, expected.energy, 1e-9 * expected.energy);
  EXPECT_LE(out.newton_iterations, 60);
}

INSTANTIATE_TEST_SUITE_P(Materials, BadStart,
                         ::testing::Combine(::testing::Values("neoHookean", "corotated"), ::testing::ValuesIn(kStarts)),
                         [](const auto& info) {
                           return std::string(std::get<0>(info.param)) + std::get<1>(info.param).name;
                         });

TEST(Globalization, ABadStartIsGivenBackWhenTheFrameIsRefused) {
  SheetScene scene;
  scene.spacing = 4.0;
  scene.tolerance = 1e-4;
  SessionSettings settings = sheet_settings(scene);
  settings.max_newton = 2;  // nothing converges
  const Lattice lattice = sheet_lattice(scene);
  Session session(settings);
  session.set_epoch(sheet_epoch());
  SolverState state = state_of(lattice, [](const Vec3& x) { return Vec3(x[0], x[1], -x[2]); });
  state.is_double = false;
  session.set_state(state);
  const FrameOutput out = session.solve(sheet_frame(scene), {}, kNever);
  EXPECT_FALSE(out.converged);
  EXPECT_EQ(out.failure.code, FailureCode::kIterations) << out.failure.message;
  EXPECT_EQ(out.restart, Restart::kInvalidStart);
  EXPECT_EQ(difference(out.state, state), 0.0);
}

// A box pushed through its own fixed face: the corotated material has a true equilibrium there, all of it inverted.
TEST(Globalization, AnInvertedEquilibriumIsGivenOnlyAsRestConfirmsIt) {
  SessionSettings s;
  s.spacing = 1;
  s.retractors = 1;
  s.precision = "double";
  s.tolerance = 1e-6;
  s.materials[0].model = "corotated";
  s.materials[0].poissons_ratio = 0.0;
  s.stability = false;
  const auto solve = [&](const std::vector<double>& pushes) {
    Session session(s);
    session.set_epoch(make_epoch(
        box_surface({0, 0, 0}, {8, 4, 4}), [](const Vec3& c) { return c[0] < 1e-9; },
        [](const Vec3& c) { return c[0] > 8 - 1e-9 ? 0 : -1; }));
    FrameOutput out;
    for (const double push : pushes) out = session.solve(pulled({Vec3(push, 0, 0)}), {}, kNever);
    return out;
  };
  const FrameOutput stepped = solve({-1, -12}), direct = solve({-12});
  ASSERT_TRUE(direct.converged) << direct.failure.message;
  ASSERT_GT(direct.inverted_cells, 0);
  ASSERT_TRUE(stepped.converged) << stepped.failure.message;
  EXPECT_LE(stepped.energy, direct.energy * (1 + 1e-6));
  // the one from the frame before has no more energy than the one from rest: it stands
  EXPECT_EQ(stepped.restart, Restart::kNone);
  EXPECT_EQ(stepped.inverted_cells, direct.inverted_cells);
  // the confirmation costs the iterations from rest
  EXPECT_GT(stepped.newton_iterations, direct.newton_iterations);

  // It is a saddle: where these are looked for no tissue stays inverted.
  s.stability = true;
  const FrameOutput left = solve({-12});
  ASSERT_TRUE(left.converged) << left.failure.message;
  EXPECT_GT(left.saddles_left, 0);
  EXPECT_EQ(left.inverted_cells, 0);
  EXPECT_LT(left.energy, 0.5 * direct.energy);

  s.materials[0].model = "neoHookean";  // goes around, or is refused
  const FrameOutput around = solve({-12});
  EXPECT_EQ(around.converged, around.failure.message.empty());
  if (around.converged) {
    EXPECT_GT(around.minimum_j, 0.0);
  }
}

TEST(Globalization, AHookTargetFarBeyondTheTissueIsRefusedBeforeSolvingUnlessItsForceIsSmall) {
  SessionSettings s;
  Session session(s);
  EpochInput epoch = make_epoch(box_surface({0, 0, 0}, {12, 8, 2}), [](const Vec3& c) { return c[0] < 1e-9; });
  EpochInput places = epoch;
  add_landmark(places, Vec3(11, 4, 2));
  session.set_epoch(epoch);
  FrameInput frame;
  frame.hooks = {{{places.landmarks[0], places.landmark_triangles[0]}, Vec3(0, 0, -1e6), 1e9}};
  const FrameOutput refused = session.solve(frame, {}, kNever);
  EXPECT_FALSE(refused.converged);
  EXPECT_EQ(refused.newton_iterations, 0);
  EXPECT_EQ(refused.failure.code, FailureCode::kUnreachable) << refused.failure.message;
  for (const double x : refused.state.nodes) EXPECT_EQ(x, 0.0);
  // a far target with a soft spring is a constant force
  frame.hooks[0].stiffness = 20.0 / 1e6;
  const FrameOutput solved = session.solve(frame, {}, kNever);
  ASSERT_TRUE(solved.converged) << solved.failure.message;
  EXPECT_NEAR(Vec3(solved.hook_forces[0], solved.hook_forces[1], solved.hook_forces[2]).norm(), 20.0, 0.01);
}

TEST(Globalization, ARetractorThatLeavesTheSceneIsRefusedBeforeSolving) {
  SheetScene scene;
  scene.spacing = 4.0;
  scene.tolerance = 1e-4;
  scene.pull = 1e5;
  Session session(sheet_settings(scene));
  session.set_epoch(sheet_epoch());
  const FrameOutput out = session.solve(sheet_frame(scene), {}, kNever);
  EXPECT_FALSE(out.converged);
  EXPECT_EQ(out.newton_iterations, 0);
  EXPECT_NE(out.failure.message.find("retractor 0"), std::string::npos) << out.failure.message;
}

TEST(Globalization, AHookThatTearsTheTissueEndsWithinTwoHundredIterationsOrConverges) {
  SessionSettings s;
  s.max_newton = 30;
  for (const double distance : {100.0, 250.0}) {
    Session session(s);
    EpochInput epoch = make_epoch(box_surface({0, 0, 0}, {12, 8, 2}), [](const Vec3& c) { return c[0] < 1e-9; });
    EpochInput places = epoch;
    add_landmark(places, Vec3(11, 4, 2));
    session.set_epoch(epoch);
    FrameInput frame;
    frame.hooks = {{{places.landmarks[0], places.landmark_triangles[0]}, Vec3(11, 4, -distance), 1e9}};
    const FrameOutput out = session.solve(frame, {}, kNever);
    EXPECT_LE(out.newton_iterations, 200);
    EXPECT_EQ(out.converged, out.failure.message.empty()) << out.failure.message;
    if (out.converged) {
      EXPECT_EQ(out.inverted_cells, 0);
    }
    for (const float x : out.points) EXPECT_TRUE(std::isfinite(x));
  }
}

std::vector<std::string> tried(RetrySchedule schedule,
                               const std::function<std::pair<int, double>(const Attempt&)>& outcome) {
  std::vector<std::string> order;
  while (schedule.next()) {
    const Attempt now = *schedule.next();
    order.push_back(fmt::format("{}{}", now.from_rest ? "rest " : "", now.load_steps));
    const auto [step, residual] = outcome(now);
    schedule.failed(step, residual, 0);
  }
  return order;
}

TEST(Globalization, RetriesHalveTheLoadWhileThatHelpsAndThenStartOverFromRest) {
  using Order = std::vector<std::string>;
  // the first load step always fails alike: two halvings show it
  EXPECT_EQ(tried(RetrySchedule(true, 100), [](const Attempt&) { return std::pair{0, 1.0}; }),
            (Order{"1", "2", "4", "rest 1", "rest 2", "rest 4"}));
  EXPECT_EQ(tried(RetrySchedule(false, 100), [](const Attempt&) { return std::pair{0, 1.0}; }),
            (Order{"rest 1", "rest 2", "rest 4"}));
  // each halving helps
  EXPECT_EQ(tried(RetrySchedule(true, 100), [](const Attempt& a) { return std::pair{a.load_steps / 2, 1.0}; }),
            (Order{"1", "2", "4", "8", "16", "rest 1", "rest 2", "rest 4", "rest 8", "rest 16"}));
  EXPECT_EQ(
      tried(RetrySchedule(false, 100), [](const Attempt& a) { return std::pair{0, std::pow(0.3, a.load_steps)}; }),
      (Order{"rest 1", "rest 2", "rest 4", "rest 8", "rest 16"}));
}

TEST(Globalization, AttemptsEndWithTheirBudgetOfIterationsAndThoseFromRestHaveHalfOfIt) {
  RetrySchedule schedule(true, 100);
  EXPECT_EQ(schedule.newton_left(0), 100);
  EXPECT_EQ(schedule.newton_left(350), 50);
  schedule.failed(1, 1.0, 400);
  ASSERT_TRUE(schedule.next());
  EXPECT_TRUE(schedule.next()->from_rest);
  EXPECT_EQ(schedule.newton_left(400), 100);
  EXPECT_EQ(schedule.newton_left(570), 30);
  schedule.failed(1, 1.0, 600);
  EXPECT_FALSE(schedule.next());
}

}  // namespace
}  // namespace lappet
