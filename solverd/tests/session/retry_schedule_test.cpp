// A schedule of retries that add to their budget, or go on instead of starting afresh.
#include "session/retry_schedule.h"

#include <gtest/gtest.h>

#include <limits>

namespace lappet {
namespace {

TEST(RetrySchedule, AnAttemptThatGetsFurtherAlongTheLoadAddsToTheBudget) {
  RetrySchedule schedule(true, 100);
  schedule.failed(0, 1.0, 100);  // of one load step
  EXPECT_EQ(schedule.newton_left(350), 50);
  schedule.failed(1, 1.0, 210);  // at half the load
  EXPECT_EQ(schedule.newton_left(450), 50);
  schedule.failed(2, 1.0, 320);  // of four: no further
  EXPECT_EQ(schedule.newton_left(450), 50);
  ASSERT_TRUE(schedule.next());
  EXPECT_EQ(schedule.next()->load_steps, 8);
  EXPECT_FALSE(schedule.next()->from_rest);
}

TEST(RetrySchedule, AnAttemptThatRunsOutOfIterationsNearAnEquilibriumGoesOnWithinTheBudget) {
  RetrySchedule schedule(true, 100);
  for (const int used : {100, 200, 300}) {
    schedule.failed(0, 3e-3, used, true);
    ASSERT_TRUE(schedule.next());
    EXPECT_TRUE(schedule.next()->goes_on);
    EXPECT_EQ(schedule.next()->load_steps, 1);
  }
  schedule.failed(0, 3e-3, 400, true);
  ASSERT_TRUE(schedule.next());
  EXPECT_TRUE(schedule.next()->from_rest);
  EXPECT_FALSE(schedule.next()->goes_on);
}

TEST(RetrySchedule, OneThatGoesOnAndGetsLostIsTriedInLoadSteps) {
  RetrySchedule schedule(true, 100);
  schedule.failed(0, 3e-3, 100, true);
  schedule.failed(0, 0.5, 200);
  ASSERT_TRUE(schedule.next());
  EXPECT_FALSE(schedule.next()->goes_on);
  EXPECT_EQ(schedule.next()->load_steps, 2);
}

TEST(RetrySchedule, WhereTissueDoesNotPassThroughTissueNoAttemptBeginsAtRest) {
  RetrySchedule schedule(true, 100, true);
  int attempts = 0;
  for (int used = 100; schedule.next(); used += 100, ++attempts) {
    EXPECT_FALSE(schedule.next()->from_rest);
    schedule.failed(0, 0.5, used);
  }
  EXPECT_GT(attempts, 1);
  EXPECT_TRUE(RetrySchedule(false, 100, true).next()->from_rest);  // there is no other start
}

TEST(RetrySchedule, AnyNumberOfIterationsMayBeAllowed) {
  RetrySchedule schedule(true, std::numeric_limits<int>::max());
  for (int used = 0; schedule.next() && !schedule.next()->from_rest; used += 1'000'000) {
    EXPECT_GE(schedule.newton_left(used), 1'000'000);
    schedule.failed(0, 3e-3, used + 1'000'000, true);
  }
  ASSERT_TRUE(schedule.next());
  EXPECT_GE(schedule.newton_left(4'000'000), 1'000'000);
}

}  // namespace
}  // namespace lappet
