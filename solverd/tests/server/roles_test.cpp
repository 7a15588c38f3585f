// Roles, rates and limits: the small values of a daemon that several share.
#include "server/roles.h"

#include <gtest/gtest.h>

#include <chrono>

#include "lattice/refused.h"
#include "server/session_limits.h"
#include "server/token_bucket.h"

namespace lappet {
namespace {

TEST(Roles, EachMayWhatThoseBeforeItMay) {
  EXPECT_LT(Role::kFollower, Role::kAuthor);
  EXPECT_LT(Role::kAuthor, Role::kAdmin);
  for (const Role role : {Role::kFollower, Role::kAuthor, Role::kAdmin}) EXPECT_EQ(role_of(role_name(role)), role);
  EXPECT_FALSE(role_of("king"));
  EXPECT_EQ(rule_of("hello").least, Role::kFollower);
  EXPECT_EQ(rule_of("solve").least, Role::kAuthor);
  EXPECT_EQ(rule_of("shutdown").least, Role::kAdmin);
  EXPECT_THROW(rule_of("frame"), RefusedError);
  for (const MessageRule& rule : kMessageRules) EXPECT_TRUE(!rule.work || rule.least >= Role::kAuthor) << rule.type;
}

TEST(TokenBucket, GivesSoManyASecondAndAsManyAtOnceAfterAPause) {
  const auto start = TokenBucket::Clock::now();
  TokenBucket bucket(10.0, 5.0, start);
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(bucket.take(start));
  EXPECT_FALSE(bucket.take(start));
  EXPECT_FALSE(bucket.full(start));
  EXPECT_TRUE(bucket.empty(start + std::chrono::milliseconds(90)));
  EXPECT_TRUE(bucket.take(start + std::chrono::milliseconds(110)));
  EXPECT_FALSE(bucket.take(start + std::chrono::milliseconds(120)));
  const auto later = start + std::chrono::hours(1);
  EXPECT_TRUE(bucket.full(later));
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(bucket.take(later));
  EXPECT_FALSE(bucket.take(later)) << "a pause gives no more than so many";
}

TEST(SessionLimits, TheClientGetsWhatItAsksForAndNoMore) {
  SessionSettings settings;
  settings.memory_budget = std::size_t{1} << 50;
  settings.threads = 0;
  settings.time_budget = 0.0;
  const SessionLimits limits{1 << 20, 3, 60.0};
  SessionSettings given = within(settings, limits);
  EXPECT_EQ(given.memory_budget, std::size_t{1} << 20);
  EXPECT_EQ(given.threads, 3) << "all of the machine is more than three";
  EXPECT_EQ(given.time_budget, 60.0) << "without a limit is longer than 60 s";
  settings.memory_budget = 5;
  settings.threads = 2;
  settings.time_budget = 1.5;
  given = within(settings, limits);
  EXPECT_EQ(given.memory_budget, 5U);
  EXPECT_EQ(given.threads, 2);
  EXPECT_EQ(given.time_budget, 1.5);
  given = within(settings, {});
  EXPECT_EQ(given.memory_budget, 5U);
  EXPECT_EQ(given.threads, 2);
}

}  // namespace
}  // namespace lappet
