// Threads that slide through several anchors, in blocks that springs hold at the anchors themselves: a block moves
// without being deformed, so that all follows from the springs and the thread.
#include <gtest/gtest.h>

#include <optional>

#include "box.h"
#include "lattice/refused.h"
#include "session/session.h"
#include "test_surfaces.h"

namespace lappet {
namespace {

constexpr double kSpring = 20.0;  // mN/mm, of each block

// Blocks of 4 x 4 x 4 mm about some points, each held by a hook there.
class Blocks {
 public:
  explicit Blocks(const std::vector<Vec3>& centers, std::int32_t sutures = 1, const char* precision = "double") {
    settings_.sutures = sutures;
    settings_.precision = precision;
    settings_.bed_stiffness = settings_.bed_shear = 0.0;
    settings_.materials[0].youngs_modulus = 1.0;  // the weak bed of floating tissue goes by it
    session_.emplace(settings_);
    Surface blocks;
    for (const Vec3& c : centers) test::append(blocks, test::box(c - Vec3::Constant(2.0), c + Vec3::Constant(2.0)));
    EpochInput epoch = make_epoch(blocks, {});
    const std::size_t per_block = blocks.triangles.size() / centers.size();
    for (std::size_t k = 0; k < centers.size(); ++k) {
      anchors_.push_back({centers[k], to_index(k * per_block)});
      frame_.hooks.push_back({anchors_.back(), centers[k], kSpring, to_index(k)});
    }
    session_->set_epoch(epoch);
    frame_.time = 1;
  }
  // A thread through the blocks in some order.
  void add_thread(const std::vector<std::size_t>& through, double stiffness, double length, double tension = 0.0) {
    SutureState thread{to_index(frame_.sutures.size()),
                       anchors_[through.front()],
                       anchors_[through.back()],
                       1.0,
                       stiffness,
                       true,
                       length,
                       tension,
                       {}};
    for (std::size_t k = 1; k + 1 < through.size(); ++k) thread.inner.push_back(anchors_[through[k]]);
    frame_.sutures.push_back(thread);
  }
  FrameInput& frame() { return frame_; }
  FrameOutput solve() {
    const FrameOutput out = session_->solve(frame_, {}, kNever);
    EXPECT_TRUE(out.converged) << out.failure.message;
    return out;
  }
  static Vec3 at(const FrameOutput& out, std::size_t block) { return Vec3::Map(&out.hook_points[3 * block]); }
  static Vec3 pull(const FrameOutput& out, std::size_t block) { return Vec3::Map(&out.hook_forces[3 * block]); }

 private:
  SessionSettings settings_;
  std::optional<Session> session_;
  std::vector<Anchor> anchors_;
  FrameInput frame_;
};

TEST(SlidingThread, ThroughThreeBitesOnALineItDrawsTheEndsAsTheSpringsSayAndLeavesTheMiddleWhereItIs) {
  for (const double stiffness : {3.0, 40.0, 5000.0}) {
    Blocks blocks({{0, 0, 0}, {6, 0, 0}, {14, 0, 0}});
    blocks.add_thread({0, 1, 2}, stiffness, 11.0);
    const FrameOutput out = blocks.solve();
    // tension = stiffness (14 - 2 tension / spring - 11); 1e-3 mm is lost at each piece
    const double tension = stiffness * (14.0 - 2e-3 - 11.0) / (1.0 + 2.0 * stiffness / kSpring);
    EXPECT_NEAR(out.suture_forces[0] / tension, 1.0, 1e-3);
    EXPECT_NEAR(Blocks::at(out, 0)[0], tension / kSpring, 2e-3);
    EXPECT_NEAR(Blocks::at(out, 1)[0], 6.0, 1e-3);
    EXPECT_NEAR(Blocks::at(out, 2)[0], 14.0 - tension / kSpring, 2e-3);
    EXPECT_NEAR(out.inner_bite_points[0], Blocks::at(out, 1)[0], 1e-9);
  }
}

TEST(SlidingThread, ItsTensionIsTheSameInAllPiecesWhateverTheSpringsAndTheTurns) {
  for (const char* precision : {"double", "float"}) {
    Blocks blocks({{0, 0, 0}, {7, 5, 0}, {14, 0, 3}, {20, 6, 0}}, 1, precision);
    blocks.add_thread({0, 1, 2, 3}, 60.0, 20.0);
    const FrameOutput out = blocks.solve();
    const double tension = out.suture_forces[0];
    EXPECT_GT(tension, 20.0);
    double length = 0.0;
    for (std::size_t k = 0; k < 3; ++k) length += (Blocks::at(out, k + 1) - Blocks::at(out, k)).norm();
    EXPECT_NEAR(tension, 60.0 * (length - 3e-3 - 20.0), 1e-2 * tension);
    for (std::size_t k = 0; k < 4; ++k) {
      Vec3 of_thread = Vec3::Zero();  // one tension along both pieces that meet here
      for (const std::size_t other : {k - 1, k + 1})
        if (other < 4) of_thread += tension * (Blocks::at(out, other) - Blocks::at(out, k)).normalized();
      EXPECT_LT((of_thread + Blocks::pull(out, k)).norm(), 3e-3 * tension) << precision << ' ' << k;
    }
  }
}

// Two stations across gaps of 2 and 4 mm between the blocks; the thread crosses one, runs along the far edge and comes
// back across the other.
TEST(SlidingThread, ARunningSutureClosesAllStationsEquallyAndSeparateSuturesDoNot) {
  const std::vector<Vec3> centers{{0, 0, 0}, {6, 0, 0}, {6, 30, 0}, {-2, 30, 0}};
  const auto closed = [](const FrameOutput& out) {
    const double first = 6.0 - (Blocks::at(out, 1) - Blocks::at(out, 0)).norm();
    const double second = 8.0 - (Blocks::at(out, 2) - Blocks::at(out, 3)).norm();
    return std::pair{first, second};
  };
  Blocks running(centers);
  running.add_thread({0, 1, 2, 3}, 1e4, 42.0);
  const auto [first, second] = closed(running.solve());
  EXPECT_GT(first, 0.5);
  EXPECT_NEAR(second / first, 1.0, 0.03);
  Blocks separate(centers, 2);
  separate.add_thread({0, 1}, 1e4, 5.4);
  separate.add_thread({2, 3}, 1e4, 5.4);
  const auto [one, other] = closed(separate.solve());
  EXPECT_NEAR(one, 0.6, 0.01);
  EXPECT_NEAR(other, 2.6, 0.01);
}

TEST(SlidingThread, AsStiffAsSteelItKeepsItsLengthAndSlackItDoesNothing) {
  Blocks stiff({{0, 0, 0}, {7, 5, 0}, {14, 0, 3}});
  stiff.add_thread({0, 1, 2}, 1e8, 15.0);
  const FrameOutput out = stiff.solve();
  const double length =
      (Blocks::at(out, 1) - Blocks::at(out, 0)).norm() + (Blocks::at(out, 2) - Blocks::at(out, 1)).norm();
  EXPECT_NEAR(length, 15.0, 4e-3);
  EXPECT_GT(out.suture_forces[0], 10.0);
  Blocks loose({{0, 0, 0}, {7, 5, 0}, {14, 0, 3}});
  loose.add_thread({0, 1, 2}, 1000.0, 20.0);
  const FrameOutput rest = loose.solve();
  EXPECT_EQ(rest.suture_forces[0], 0.0);
  EXPECT_NEAR((Blocks::at(rest, 1) - Vec3(7, 5, 0)).norm(), 0.0, 1e-9);
}

TEST(SlidingThread, ATensionThatIsGivenIsKept) {
  Blocks blocks({{0, 0, 0}, {7, 0, 0}, {7, 8, 0}});
  blocks.add_thread({0, 1, 2}, 1000.0, 0.0, 15.0);
  const FrameOutput out = blocks.solve();
  EXPECT_NEAR(out.suture_forces[0], 15.0, 1e-3);
  EXPECT_NEAR(Blocks::pull(out, 0).norm(), 15.0, 0.05);
  const Vec3 here = Blocks::at(out, 1);  // it turns by nearly a right angle there
  const Vec3 both = (Blocks::at(out, 0) - here).normalized() + (Blocks::at(out, 2) - here).normalized();
  EXPECT_NEAR(Blocks::pull(out, 1).norm(), 15.0 * both.norm(), 0.05);
  EXPECT_NEAR(both.norm(), std::sqrt(2.0), 0.2);
}

// The knot of a loop is where it begins and ends.
TEST(SlidingThread, ALoopThatIsTiedDrawsItsCornersTogether) {
  Blocks blocks({{0, 0, 0}, {8, 0, 0}, {8, 8, 0}, {0, 8, 0}});
  blocks.add_thread({0, 1, 2, 3, 0}, 500.0, 28.0);
  const FrameOutput out = blocks.solve();
  const Vec3 middle(4, 4, 0);
  for (std::size_t k = 1; k < 4; ++k)
    EXPECT_NEAR((Blocks::at(out, k) - middle).norm(), (Blocks::at(out, 0) - middle).norm(), 2e-3);
  EXPECT_NEAR((Blocks::at(out, 1) - Blocks::at(out, 0)).norm(), 7.0 + out.suture_forces[0] / 500.0 / 4.0, 5e-3);
}

TEST(SlidingThread, IsRefusedWhereItIsToCloseExactlyOrHasTooManyBites) {
  Blocks blocks({{0, 0, 0}, {7, 0, 0}, {14, 0, 0}});
  blocks.add_thread({0, 1, 2}, 1000.0, 10.0);
  blocks.frame().sutures[0].is_thread = false;
  EXPECT_THROW(blocks.solve(), RefusedError);
  blocks.frame().sutures[0].is_thread = true;
  blocks.frame().sutures[0].inner.resize(255, blocks.frame().sutures[0].inner[0]);
  EXPECT_THROW(blocks.solve(), RefusedError);
}

TEST(SlidingThread, RemembersTheLengthThatItHadWhenItWasPlaced) {
  Blocks blocks({{0, 0, 0}, {7, 0, 0}, {14, 0, 0}});
  blocks.add_thread({0, 1, 2}, 1e5, 12.0);
  const FrameOutput out = blocks.solve();
  EXPECT_NEAR(out.state.suture_gaps[0], 14.0, 1e-6);
  EXPECT_EQ(out.state.suture_gaps[1], 0.0);
  const FrameOutput again = blocks.solve();
  EXPECT_EQ(again.state.suture_gaps, out.state.suture_gaps);
  EXPECT_NEAR(again.suture_forces[0] / out.suture_forces[0], 1.0, 1e-3);
}

}  // namespace
}  // namespace lappet
