// Converged means that what is floppy has arrived too, whatever else is in the scene: default settings against the same
// frames solved to 1e-8 in double precision.
#include <gtest/gtest.h>

#include "box.h"
#include "session/session.h"

namespace lappet {
namespace {

constexpr double kNear = 0.05;  // mm

SessionSettings exact(SessionSettings settings) {
  settings.tolerance = 1e-8;
  settings.precision = "double";
  settings.max_newton = 300;
  return settings;
}

double difference(const FrameOutput& a, const FrameOutput& b) {
  double most = 0.0;
  for (std::size_t i = 0; i < a.points.size(); ++i)
    most = std::max(most, std::abs(double(a.points[i]) - double(b.points[i])));
  return most;
}

// A strip of 32 x 8 x 2 mm, held at one end, under its weight; `beside` it a block of 60 x 40 x 10 mm that a retractor
// stretches by half.
EpochInput strip(bool beside) {
  Surface surface = box_surface({0, 0, 0}, {32, 8, 2});
  if (beside) append(surface, box_surface({0, 20, 0}, {60, 60, 10}));
  EpochInput epoch = make_epoch(
      surface, [](const Vec3& c) { return c[0] < 1e-9; }, [](const Vec3& c) { return c[0] > 60 - 1e-9 ? 0 : -1; });
  add_landmark(epoch, {32, 4, 2});
  return epoch;
}

SessionSettings strip_settings() {
  SessionSettings settings;
  settings.spacing = 2;
  settings.fine_ratio = 1;
  settings.retractors = 1;
  settings.gravity = Vec3(0, 0, -9.81);
  settings.materials[0].youngs_modulus = 500;
  return settings;
}

TEST(Convergence, AFloppyStripHangsAsItDoesAloneHoweverStiffWhatIsBesideItPulls) {
  const auto tip = [](const SessionSettings& settings, bool beside) {
    Session session(settings);
    session.set_epoch(strip(beside));
    FrameInput frame = pulled({Vec3(beside ? 30 : 0, 0, 0)});
    const FrameOutput out = session.solve(frame, {}, kNever);
    EXPECT_TRUE(out.converged) << out.failure.message;
    EXPECT_LE(out.displacement_to_come, 0.02 * settings.spacing);
    return landmark(out, 0);
  };
  const Vec3 right = tip(exact(strip_settings()), false);
  EXPECT_LT(right[2], -2.0);
  EXPECT_LT((tip(strip_settings(), false) - right).norm(), kNear);
  EXPECT_LT((tip(strip_settings(), true) - right).norm(), kNear);
}

// What a frame says is still to come is what a solve to 1e-8 adds, to a factor of two.
TEST(Convergence, TheDisplacementToComeIsThatOfTheExactSolution) {
  for (const double tolerance : {1e-2, 3e-3, 1e-3}) {
    const auto frame = [&](const SessionSettings& settings) {
      Session session(settings);
      session.set_epoch(strip(false));
      const FrameOutput out = session.solve(pulled({Vec3::Zero()}), {}, kNever);
      EXPECT_TRUE(out.converged) << out.failure.message;
      return out;
    };
    SessionSettings settings = strip_settings();
    settings.tolerance = tolerance;
    settings.precision = "double";
    settings.correction = true;
    const FrameOutput out = frame(settings), right = frame(exact(strip_settings()));
    const double missing = difference(out, right);
    double largest = 0.0;
    for (std::size_t v = 0; v < out.correction.size() / 3; ++v)
      largest =
          std::max(largest, Vec3(out.correction[3 * v], out.correction[3 * v + 1], out.correction[3 * v + 2]).norm());
    EXPECT_GT(out.displacement_to_come, 0.5 * missing) << tolerance;
    EXPECT_LT(out.displacement_to_come, 2.0 * missing + 1e-4) << tolerance;
    EXPECT_GT(largest, 0.5 * missing) << tolerance;
    EXPECT_LT(largest, 2.0 * missing + 1e-4) << tolerance;
  }
}

TEST(Convergence, NothingIsToComeWhereNothingMoves) {
  SessionSettings settings = strip_settings();
  settings.gravity = Vec3::Zero();
  Session session(settings);
  session.set_epoch(strip(true));
  const FrameOutput out = session.solve(pulled({Vec3::Zero()}), {}, kNever);
  ASSERT_TRUE(out.converged) << out.failure.message;
  EXPECT_EQ(out.displacement_to_come, 0.0);
  EXPECT_EQ(out.newton_iterations, 0);
}

// A frame that is the same as the one before costs an evaluation, and says what that said.
TEST(Convergence, AFrameThatIsTheSameIsNotSolvedAgain) {
  Session session(strip_settings());
  session.set_epoch(strip(true));
  FrameInput frame = pulled({Vec3(10, 0, 0)});
  const FrameOutput first = session.solve(frame, {}, kNever);
  ASSERT_TRUE(first.converged);
  frame.time = 2;
  const FrameOutput again = session.solve(frame, {}, kNever);
  EXPECT_EQ(again.newton_iterations, 0);
  EXPECT_EQ(again.work.products.count, 0);
  EXPECT_EQ(again.displacement_to_come, first.displacement_to_come);
  // Resumed, it is looked at, and the frame is the same.
  Session other(strip_settings());
  other.set_epoch(strip(true));
  other.set_state(first.state);
  const FrameOutput resumed = other.solve(frame, {}, kNever);
  EXPECT_EQ(resumed.points, again.points);
  EXPECT_GT(resumed.work.products.count, 0);
}

}  // namespace
}  // namespace lappet
