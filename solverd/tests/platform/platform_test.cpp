// What the system says of this process and of others: the same on every kind of system.
#include "platform/platform.h"

#include <gtest/gtest.h>
#ifdef _WIN32
#include <process.h>
#else
#include <unistd.h>
#endif

#include <cstdlib>
#include <vector>

#include "environment.h"

namespace lappet {
namespace {

int own_number() {
#ifdef _WIN32
  return ::_getpid();
#else
  return ::getpid();
#endif
}

TEST(Platform, TheMostMemoryGrowsWithWhatIsUsed) {
  const double before = peak_bytes();
  EXPECT_GT(before, 1e6);
  constexpr std::size_t kBytes = std::size_t{256} << 20;
  const std::vector<char> block(kBytes, 1);
  EXPECT_EQ(static_cast<const volatile char*>(block.data())[kBytes - 1], 1);  // clang leaves out what nobody reads
  EXPECT_GT(peak_bytes(), double(kBytes));
  EXPECT_GE(peak_bytes(), before);
}

TEST(Platform, AProcessThatRunsHasNotEndedAndOneThatNeverWasHas) {
  EXPECT_FALSE(ProcessWatch(0).ended());
  EXPECT_FALSE(ProcessWatch(own_number()).ended());
  EXPECT_TRUE(ProcessWatch(0x7ffffffc).ended());  // larger than any number of Linux, and than Windows gives
}

TEST(Platform, NoInputNeverEnds) {
  InputWatch none(-1);
  EXPECT_LT(none.pollable(), 0);
  EXPECT_FALSE(none.ended());
}

TEST(Platform, AVariableIsTakenOnce) {
  set_variable("LAPPET_TEST_VARIABLE", "value");
  EXPECT_EQ(take_variable("LAPPET_TEST_VARIABLE"), "value");
  EXPECT_EQ(std::getenv("LAPPET_TEST_VARIABLE"), nullptr);
  EXPECT_EQ(take_variable("LAPPET_TEST_VARIABLE"), "");
}

TEST(Platform, TheLapackOfCholmodIsFoundByName) {
  EXPECT_NE(loaded_function("dpotrf_"), nullptr);
  EXPECT_NE(loaded_function("openblas_set_num_threads"), nullptr) << "its threads would stand in each other's way";
  EXPECT_EQ(loaded_function("no_library_has_this_function"), nullptr);
}

TEST(Platform, LoopbackIsANumberOfThisComputer) {
  for (const char* host : {"127.0.0.1", "127.255.0.9"}) EXPECT_TRUE(is_loopback_number(host)) << host;
  for (const char* host : {"128.0.0.1", "localhost", "127.1", "127.0.0.1.", ""})
    EXPECT_FALSE(is_loopback_number(host)) << host;
}

}  // namespace
}  // namespace lappet
