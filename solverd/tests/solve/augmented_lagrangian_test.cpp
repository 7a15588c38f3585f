// How the multipliers of a spring that must close come to their end.
#include "solve/newton/augmented_lagrangian.h"

#include <gtest/gtest.h>

namespace lappet {
namespace {

// A gap that gives way by `compliance` for each unit of force and would be `open` wide without any, solved exactly each
// time: the multiplier lambda and the penalty k leave (open - s lambda) / (1 + s k) of it.
struct Spring {
  double open, compliance, penalty = 1.0, multiplier = 0.0;
  int updates = 0;

  double gap() const { return (open - compliance * multiplier) / (1.0 + compliance * penalty); }

  AugmentedLagrangian::Action close(AugmentedLagrangian& decides) {
    while (true) {
      const auto action = decides.next(0.0, gap());
      if (action != AugmentedLagrangian::Action::kUpdate) return action;
      multiplier += penalty * gap();
      penalty *= decides.stiffening();
      ++updates;
    }
  }
};

TEST(AugmentedLagrangian, ClosesAGapThatIsSoftBesideThePenaltyWithoutAnotherPenalty) {
  AugmentedLagrangian decides(1e-3, 1e-3);
  Spring spring{.open = 1.0, .compliance = 5.0};
  EXPECT_EQ(spring.close(decides), AugmentedLagrangian::Action::kConverged);
  EXPECT_EQ(spring.penalty, 1.0);
  EXPECT_LE(spring.updates, 4);
}

// As of sutures that a coarse lattice can hardly tell apart: a plain multiplier would take 250 updates at a compliance
// of 0.01 and be given up after 60.
TEST(AugmentedLagrangian, StiffensThePenaltyOfAGapThatHardlyGivesWay) {
  for (const double compliance : {0.2, 0.05, 0.01}) {
    AugmentedLagrangian decides(1e-3, 1e-3);
    Spring spring{.open = 0.012, .compliance = compliance};
    EXPECT_EQ(spring.close(decides), AugmentedLagrangian::Action::kConverged) << compliance;
    EXPECT_LE(spring.updates, 8) << compliance;
    EXPECT_GT(spring.penalty, 1.0) << compliance;
    EXPECT_LE(spring.penalty, 100.0) << compliance;
    const double force = spring.multiplier + spring.penalty * spring.gap();
    EXPECT_NEAR(compliance * force, spring.open, 1e-3) << compliance;
  }
}

// Walls that touch hold a suture open by less than the distance that they keep: that is closed, with no more penalty.
TEST(AugmentedLagrangian, TakesAGapThatOnlyWallsKeepOpenForClosedOnceItHardlyGivesWay) {
  AugmentedLagrangian decides(1e-3, 1e-3);
  Spring spring{.open = 0.05, .compliance = 0.2};
  AugmentedLagrangian::Action action;
  while ((action = decides.next(0.0, spring.gap(), 0.0)) == AugmentedLagrangian::Action::kUpdate) {
    spring.multiplier += spring.penalty * spring.gap();
    ++spring.updates;
  }
  EXPECT_EQ(action, AugmentedLagrangian::Action::kConverged);
  EXPECT_GT(spring.gap(), 1e-3);
  EXPECT_EQ(decides.stiffening(), 1.0);
  EXPECT_LE(spring.updates, 3);
  EXPECT_EQ(decides.next(2e-3, spring.gap(), 0.0), AugmentedLagrangian::Action::kIterate);  // forces must balance
  EXPECT_EQ(decides.next(0.0, 0.5, 0.5), AugmentedLagrangian::Action::kUpdate);             // and nothing else be open
}

// Demands that contradict others leave a wide gap: no penalty is to tear the tissue.
TEST(AugmentedLagrangian, GivesAWideGapThatHardlyGivesWayUp) {
  AugmentedLagrangian decides(1e-3, 1e-3);
  Spring spring{.open = 5.0, .compliance = 0.01};
  EXPECT_EQ(spring.close(decides), AugmentedLagrangian::Action::kGiveUp);
  EXPECT_EQ(spring.penalty, 1.0);
}

}  // namespace
}  // namespace lappet
