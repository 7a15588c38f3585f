// A bar pressed beyond its buckling load buckles, in however many frames, and whoever resumes it sees the same.
#include <gtest/gtest.h>

#include <cmath>

#include "pulled_bar.h"

namespace lappet {
namespace {

constexpr double kPressed = -12.0;  // mm, of 40

SessionSettings pressed_settings() {
  SessionSettings settings;
  settings.retractors = 1;
  return settings;
}

FrameOutput press(Session& session, int step, int steps) {
  FrameInput frame = pulled({Vec3(kPressed * step / steps, 0, 0)});
  frame.time = step;
  return session.solve(frame, {}, kNever);
}

FrameOutput pressed(const SessionSettings& settings, int steps) {
  Session session(settings);
  session.set_epoch(bar_epoch(Bar{}));
  FrameOutput out;
  for (int step = 1; step <= steps; ++step) {
    out = press(session, step, steps);
    EXPECT_TRUE(out.converged) << out.failure.message;
  }
  return out;
}

TEST(Buckling, ABarPressedToSeventyPerCentBucklesInOneFourAndSixteenFrames) {
  const FrameOutput at_once = pressed(pressed_settings(), 1);
  EXPECT_GT(at_once.lowest_stiffness, 0.0);
  EXPECT_LT(at_once.energy, 400.0);
  for (const int steps : {4, 16}) EXPECT_NEAR(pressed(pressed_settings(), steps).energy, at_once.energy, 1.0) << steps;
}

TEST(Buckling, WithoutLookingItStaysStraightInItsFirstFrame) {
  SessionSettings settings = pressed_settings();
  Session looking(settings);
  settings.stability = false;
  Session blind(settings);
  for (Session* session : {&looking, &blind}) session->set_epoch(bar_epoch(Bar{}));
  const FrameOutput buckled = press(looking, 1, 4), straight = press(blind, 1, 4);
  ASSERT_TRUE(buckled.converged && straight.converged);
  EXPECT_GT(straight.energy, 1.3 * buckled.energy);
  EXPECT_EQ(buckled.saddles_left, 1);
  EXPECT_GT(buckled.lowest_stiffness, 0.0);
  EXPECT_EQ(straight.saddles_left, 0);
  EXPECT_TRUE(std::isnan(straight.lowest_stiffness));
}

TEST(Buckling, ABarShortOfItsBucklingLoadLosesItsStiffnessLittleByLittle) {
  Session session(pressed_settings());
  session.set_epoch(bar_epoch(Bar{}));
  double before = 1.0;
  for (const double share : {0.06, 0.08, 0.1}) {
    FrameInput frame = pulled({Vec3(share * kPressed, 0, 0)});
    const FrameOutput out = session.solve(frame, {}, kNever);
    ASSERT_TRUE(out.converged);
    EXPECT_LT(out.lowest_stiffness, before - 0.1) << share;
    EXPECT_GT(out.lowest_stiffness, 0.0);
    EXPECT_EQ(out.saddles_left, 0);
    ASSERT_EQ(out.softest_point.size(), 3U);
    before = out.lowest_stiffness;
  }
  EXPECT_LT(before, 0.2);
  FrameInput same = pulled({Vec3(0.1 * kPressed, 0, 0)});
  same.time = 9;
  const FrameOutput again = session.solve(same, {}, kNever);
  EXPECT_EQ(again.newton_iterations, 0);
  EXPECT_EQ(again.lowest_stiffness, before);  // what the frame before said
}

TEST(Buckling, AResumedSolveLeavesTheSaddleToTheSameSideBitForBit) {
  Session session(pressed_settings());
  session.set_epoch(bar_epoch(Bar{}));
  const FrameOutput first = press(session, 1, 40);
  const FrameOutput second = press(session, 10, 40);
  ASSERT_TRUE(second.converged);
  ASSERT_GT(second.saddles_left, 0);
  Session resumed(pressed_settings());
  resumed.set_epoch(bar_epoch(Bar{}));
  resumed.set_state(first.state);
  EXPECT_EQ(press(resumed, 10, 40).state.nodes, second.state.nodes);
}

TEST(Buckling, APulledBarIsStable) {
  Session session(pressed_settings());
  session.set_epoch(bar_epoch(Bar{}));
  const FrameOutput out = pull(session, 12.0);
  EXPECT_GT(out.lowest_stiffness, 0.9);
  EXPECT_EQ(out.saddles_left, 0);
}

}  // namespace
}  // namespace lappet
