// What a frame's changes do not reach stays where it is: as good as solving everything, finished by the whole where the
// neighborhood was too small, and the same bits whoever goes on from where.
#include "solve/newton/change_neighborhood.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "box.h"
#include "session/session.h"

namespace lappet {
namespace {

constexpr double kWidth = 150.0, kThickness = 6.0, kSpacing = 3.0;  // mm
constexpr std::int64_t kCells = 50 * 50 * 2;
// mm that the frames may be off: what the tolerance of the residual leaves open in a whole solve, too.
constexpr double kLeftOpen = 2e-3 * kSpacing;

SessionSettings patch_settings(const std::string& region) {
  SessionSettings s;
  s.spacing = kSpacing;
  s.fine_ratio = 1;
  s.threads = 1;
  s.region = region;
  s.sutures = 1;
  return s;
}

SessionSettings exact_settings() {
  SessionSettings s = patch_settings("whole");
  s.precision = "double";
  s.tolerance = 1e-7;
  return s;
}

// A patch on its bed, its rim held; a retractor grips a triangle of 12 mm a side or so in the middle of the skin.
EpochInput patch(double thickness = kThickness, bool gripped = false) {
  const auto on_rim = [](const Vec3& c) { return std::min({c[0], c[1], kWidth - c[0], kWidth - c[1]}) < 1e-9; };
  Surface surface = box_surface(Vec3::Zero(), {kWidth, kWidth, thickness});
  const Vec3 grip[3] = {{69, 70, thickness}, {81, 70, thickness}, {75, 81, thickness}};
  if (gripped)
    for (const Vec3& corner : grip) add_vertex(surface, corner);
  const Vec3 middle = (grip[0] + grip[1] + grip[2]) / 3.0;
  return make_epoch(
      surface, on_rim, [&](const Vec3& c) { return (c - middle).norm() < 1e-6 ? 0 : -1; },
      [](const Vec3& c) { return c[2] < 1e-9; });
}

Anchor on_skin(double x, double y) { return {{x, y, kThickness}, x > y ? 10 : 11}; }

// A hook that lifts the skin at a place by so much.
FrameInput lifted(double time, double by, double stiffness = 300.0, double x = 52.0) {
  FrameInput frame;
  frame.time = time;
  const Anchor anchor = on_skin(x, 61.0);
  frame.hooks = {{anchor, anchor.point + Vec3(0.3 * by, 0, by), stiffness}};
  return frame;
}

double furthest(const FrameOutput& a, const FrameOutput& b) {
  double most = 0.0;
  for (std::size_t i = 0; i < a.state.nodes.size(); i += 3) {
    double squared = 0.0;
    for (std::size_t k = i; k < i + 3; ++k) squared += std::pow(a.state.nodes[k] - b.state.nodes[k], 2);
    most = std::max(most, std::sqrt(squared));
  }
  return most;
}

std::size_t nodes_at_rest(const FrameOutput& frame) {
  std::size_t count = 0;
  const auto& u = frame.state.nodes;
  for (std::size_t i = 0; i < u.size(); i += 3) count += u[i] == 0.0 && u[i + 1] == 0.0 && u[i + 2] == 0.0;
  return count;
}

TEST(ChangeNeighborhood, WhatAHookDoesNotReachStaysAtRestAndTheRestIsWhereAnExactSolveOfAllPutsIt) {
  SessionSettings settings = patch_settings("auto");
  settings.stability = false;  // a search for saddles is one of all of the tissue
  Session session(settings), exact(exact_settings());
  session.set_epoch(patch());
  exact.set_epoch(patch());
  for (int k = 1; k <= 4; ++k) {
    const FrameOutput found = session.solve(lifted(k, 0.5 * k), {}, kNever);
    const FrameOutput all = exact.solve(lifted(k, 0.5 * k), {}, kNever);
    ASSERT_TRUE(found.converged) << found.failure.message;
    ASSERT_TRUE(all.converged) << all.failure.message;
    EXPECT_EQ(all.active_cells, kCells);
    EXPECT_GT(found.active_cells, 0);
    EXPECT_LT(found.active_cells, kCells / 2) << k;
    EXPECT_EQ(found.work.products.count, 0);  // of the whole
    EXPECT_LE(found.residual, 1e-3);
    EXPECT_GT(*std::ranges::max_element(found.state.nodes), 50 * kLeftOpen);
    EXPECT_LT(furthest(found, all), kLeftOpen) << k;
    EXPECT_GT(nodes_at_rest(found), found.state.nodes.size() / 3 / 2);
  }
}

// Where something is dragged the whole keeps its coarse operator, which a neighborhood cannot.
TEST(ChangeNeighborhood, WhatIsDraggedIsSolvedEverywhere) {
  SessionSettings settings = patch_settings("auto");
  settings.stability = false;
  settings.live = true;
  Session session(settings);
  session.set_epoch(patch());
  for (int k = 1; k <= 4; ++k) {
    const FrameOutput found = session.solve(lifted(1, 0.5 * k), {}, kNever);
    ASSERT_TRUE(found.converged) << found.failure.message;
    EXPECT_EQ(found.active_cells, kCells) << k;
  }
}

TEST(ChangeNeighborhood, ASutureIsDrawnTogetherThereAndItsMultiplierIsKept) {
  Session session(patch_settings("auto")), exact(exact_settings());
  session.set_epoch(patch());
  exact.set_epoch(patch());
  int alone = 0;
  for (int k = 0; k <= 3; ++k) {
    FrameInput frame;
    frame.time = k;
    frame.sutures = {{0, on_skin(70, 61), on_skin(82, 61), 0.08 * k, 500.0}};
    const FrameOutput found = session.solve(frame, {}, kNever), all = exact.solve(frame, {}, kNever);
    ASSERT_TRUE(found.converged) << found.failure.message;
    ASSERT_TRUE(all.converged) << all.failure.message;
    EXPECT_LE(found.largest_gap, 1e-3 * kSpacing);
    EXPECT_LT(furthest(found, all), kLeftOpen) << k;
    if (k == 0) continue;
    alone += found.active_cells < kCells / 2;
    EXPECT_GT(all.suture_forces[0], 5.0);
    EXPECT_NEAR(found.suture_forces[0], all.suture_forces[0], 0.01 * all.suture_forces[0]);
    EXPECT_NEAR(std::abs(found.state.suture_multipliers[0]), all.suture_forces[0], 0.1 * all.suture_forces[0]);
    // It holds on: the frame once more is one look at everything.
    const FrameOutput again = session.solve(frame, {}, kNever);
    EXPECT_EQ(again.active_cells, 0);
    EXPECT_EQ(again.work.evaluations.count, 1);
  }
  EXPECT_GE(alone, 2);
}

// On a lattice plane the gripped nodes are prescribed, off it they are held by forms with multipliers.
TEST(ChangeNeighborhood, ARetractorCarriesItsFacesThere) {
  for (const double thickness : {6.0, 5.0}) {
    SessionSettings settings = patch_settings("auto"), settings_exact = exact_settings();
    settings.retractors = settings_exact.retractors = 1;
    settings.fine_ratio = settings_exact.fine_ratio = 3;
    Session session(settings), exact(settings_exact);
    session.set_epoch(patch(thickness, true));
    exact.set_epoch(patch(thickness, true));
    for (int k = 1; k <= 3; ++k) {
      FrameInput frame = pulled({{0.3 * k, 0.0, 0.2 * k}});
      frame.time = k;
      const FrameOutput found = session.solve(frame, {}, kNever), all = exact.solve(frame, {}, kNever);
      ASSERT_TRUE(found.converged) << found.failure.message;
      ASSERT_TRUE(all.converged) << all.failure.message;
      EXPECT_LT(found.active_cells, kCells / 2) << thickness << " " << k;
      EXPECT_LT(furthest(found, all), kLeftOpen) << thickness << " " << k;
    }
  }
}

TEST(ChangeNeighborhood, AnUnchangedFrameCostsOneEvaluation) {
  Session session(patch_settings("auto"));
  session.set_epoch(patch());
  const FrameOutput first = session.solve(lifted(1, 1.0), {}, kNever);
  const FrameOutput again = session.solve(lifted(1, 1.0), {}, kNever);
  ASSERT_TRUE(again.converged);
  EXPECT_EQ(again.work.evaluations.count, 1);
  EXPECT_EQ(again.work.products.count, 0);
  EXPECT_EQ(again.active_cells, 0);
  EXPECT_EQ(again.state.nodes, first.state.nodes);
}

TEST(ChangeNeighborhood, APullThatReachesFurtherIsFinishedEverywhere) {
  Session session(patch_settings("auto")), exact(exact_settings()), whole(patch_settings("whole"));
  session.set_epoch(patch());
  exact.set_epoch(patch());
  whole.set_epoch(patch());
  bool outgrown = false;
  double apart = 0.0, usual = 0.0;
  for (int k = 1; k <= 4; ++k) {
    // Of 0.25 mm no more than the tolerance of the residual arrives at the rim; of 0.5 mm half more than that does.
    const FrameInput frame = lifted(k, k == 1 ? 0.25 : 10.0 * k, 3000.0);
    const FrameOutput found = session.solve(frame, {}, kNever), all = exact.solve(frame, {}, kNever);
    ASSERT_TRUE(found.converged) << found.failure.message;
    ASSERT_TRUE(all.converged) << all.failure.message;
    EXPECT_LE(found.residual, 1e-3);
    if (k == 1) {
      EXPECT_LT(found.active_cells, kCells / 2) << k;
    }
    outgrown = outgrown || found.active_cells == kCells;
    apart = std::max(apart, furthest(found, all));
    usual = std::max(usual, furthest(whole.solve(frame, {}, kNever), all));
  }
  EXPECT_TRUE(outgrown);
  EXPECT_LT(apart, 2.0 * usual + kLeftOpen);
}

TEST(ChangeNeighborhood, TissueOnABedTooSoftToHoldItIsSolvedEverywhere) {
  for (const double bed : {0.0, 0.01}) {
    SessionSettings settings = patch_settings("auto");
    settings.bed_stiffness = settings.bed_shear = bed;
    Session session(settings);
    session.set_epoch(patch());
    const FrameOutput found = session.solve(lifted(1, 1.0), {}, kNever);
    ASSERT_TRUE(found.converged) << found.failure.message;
    EXPECT_EQ(found.active_cells, kCells) << bed;
  }
}

TEST(ChangeNeighborhood, ASolveThatGoesOnFromAStateRepeatsItBitForBitOnAnyNumberOfThreads) {
  // A second hook elsewhere, a pull that everything feels, and back.
  const std::vector<FrameInput> frames = {lifted(1, 0.5),          lifted(2, 1.0), lifted(3, 1.0, 300.0, 80.0),
                                          lifted(4, 30.0, 3000.0), lifted(5, 1.0), lifted(6, 1.2)};
  SessionSettings settings = patch_settings("auto");
  Session session(settings);
  session.set_epoch(patch());
  std::vector<FrameOutput> through;
  for (const FrameInput& frame : frames) through.push_back(session.solve(frame, {}, kNever));
  std::int64_t least = kCells, most = 0;
  for (const FrameOutput& frame : through) {
    least = std::min(least, frame.active_cells);
    most = std::max(most, frame.active_cells);
  }
  EXPECT_LT(least, kCells / 2);
  EXPECT_EQ(most, kCells);
  for (std::size_t k = 1; k < frames.size(); ++k) {
    settings.threads = k % 2 == 0 ? 4 : 1;
    settings.correction = k % 3 == 0;  // what is asked for besides changes nothing
    Session resumed(settings);
    resumed.set_epoch(patch());
    resumed.set_state(through[k - 1].state);
    for (std::size_t l = k; l < frames.size(); ++l) {
      const FrameOutput found = resumed.solve(frames[l], {}, kNever);
      EXPECT_EQ(found.state.nodes, through[l].state.nodes) << k << " " << l;
      EXPECT_EQ(found.active_cells, through[l].active_cells) << k << " " << l;
    }
  }
}

}  // namespace
}  // namespace lappet
