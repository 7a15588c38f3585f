#include <gtest/gtest.h>

#include "box.h"
#include "session/session.h"

namespace lappet {

namespace {

// A strip that is held at one end; a hook draws its other end along a line, so far in each frame.
constexpr double kStride = 1.0;  // mm
const Vec3 kHooked(28, 4, 3);

EpochInput strip() {
  return make_epoch(box_surface({0, 0, 0}, {30, 8, 3}), [](const Vec3& c) { return c[0] < 1e-9; });
}

SessionSettings settings(int threads) {
  SessionSettings s;
  s.spacing = 1;
  s.threads = threads;
  return s;
}

FrameInput drawn(const EpochInput& epoch, double strides) {
  EpochInput probe = epoch;
  add_landmark(probe, kHooked);
  FrameInput frame;
  frame.time = strides;
  frame.hooks = {{{kHooked, probe.landmark_triangles.back()}, kHooked + kStride * strides * Vec3(0.4, 0, 1), 300.0, 0}};
  return frame;
}

FrameOutput solved(Session& session, const FrameInput& frame) {
  FrameOutput out = session.solve(frame, {}, kNever);
  EXPECT_TRUE(out.converged) << out.failure.message;
  return out;
}

// The state after so many strides.
SolverState state_after(const EpochInput& epoch, int strides) {
  Session session(settings(1));
  session.set_epoch(epoch);
  FrameOutput out;
  for (int k = 1; k <= strides; ++k) out = solved(session, drawn(epoch, k));
  return out.state;
}

FrameOutput after_state(const EpochInput& epoch, const SolverState& state, const FrameInput& frame, int threads = 1) {
  Session session(settings(threads));
  session.set_epoch(epoch);
  session.set_state(state);
  return solved(session, frame);
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

}  // namespace

TEST(Motion, TissueThatIsDrawnOnSteadilyIsFoundInFewerIterationsAndAtTheSamePlace) {
  const EpochInput epoch = strip();
  const SolverState state = state_after(epoch, 3);
  ASSERT_EQ(state.motion.size(), state.nodes.size());
  SolverState still = state;
  still.motion.clear();
  const FrameOutput goes_on = after_state(epoch, state, drawn(epoch, 4));
  const FrameOutput starts = after_state(epoch, still, drawn(epoch, 4));
  EXPECT_LT(goes_on.newton_iterations, starts.newton_iterations);
  EXPECT_LT(goes_on.pcg_iterations, starts.pcg_iterations);
  EXPECT_LT(largest_difference(goes_on.state.nodes, starts.state.nodes), 2 * 0.02);  // each within 0.02 spacings
}

TEST(Motion, AStateHoldsItSoThatAResumedFrameIsTheSameBitForBit) {
  const EpochInput epoch = strip();
  Session whole(settings(2));
  whole.set_epoch(epoch);
  for (int k = 1; k <= 3; ++k) solved(whole, drawn(epoch, k));
  const FrameOutput on = solved(whole, drawn(epoch, 4));
  const FrameOutput resumed = after_state(epoch, state_after(epoch, 3), drawn(epoch, 4));
  EXPECT_EQ(on.state.nodes, resumed.state.nodes);
  EXPECT_EQ(on.state.motion, resumed.state.motion);
  EXPECT_EQ(on.newton_iterations, resumed.newton_iterations);
}

TEST(Motion, AHookThatTurnsBackFindsTissueWhereItWasLeft) {
  const EpochInput epoch = strip();
  const SolverState state = state_after(epoch, 3);
  SolverState still = state;
  still.motion.clear();
  const FrameOutput turned = after_state(epoch, state, drawn(epoch, 2));
  const FrameOutput plain = after_state(epoch, still, drawn(epoch, 2));
  EXPECT_EQ(turned.state.nodes, plain.state.nodes);
  EXPECT_EQ(turned.newton_iterations, plain.newton_iterations);
}

TEST(Motion, TissueThatStaysKeepsTheLastOne) {
  const EpochInput epoch = strip();
  Session session(settings(1));
  session.set_epoch(epoch);
  const FrameOutput moved = solved(session, drawn(epoch, 1));
  EXPECT_FALSE(moved.state.motion.empty());
  const FrameOutput stays = solved(session, drawn(epoch, 1));
  EXPECT_EQ(stays.newton_iterations, 0);
  EXPECT_EQ(stays.state.nodes, moved.state.nodes);
  EXPECT_EQ(stays.state.motion, moved.state.motion);
}

TEST(Motion, OneOfAnotherLatticeIsRefused) {
  const EpochInput epoch = strip();
  SolverState state = state_after(epoch, 1);
  state.motion.pop_back();
  Session session(settings(1));
  session.set_epoch(epoch);
  EXPECT_THROW(session.set_state(state), RefusedError);
}

}  // namespace lappet
