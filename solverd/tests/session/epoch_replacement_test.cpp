// An epoch takes the place of the one before it whole or not at all: whatever fails on the way, and wherever, the one
// before goes on as if the message had not come.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "box.h"
#include "lattice/refused.h"
#include "session/session.h"

namespace {

// While it is not negative: how many large blocks may still be allocated.
std::atomic<long> blocks_left{-1};
constexpr std::size_t kLargeBlock = 2048;  // bytes

void* allocate(std::size_t size) {
  if (size >= kLargeBlock && blocks_left.load() >= 0 && blocks_left.fetch_sub(1) <= 0) {
    blocks_left = 0;
    throw std::bad_alloc();
  }
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}

}  // namespace

void* operator new(std::size_t size) { return allocate(size); }
void* operator new[](std::size_t size) { return allocate(size); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }

namespace lappet {
namespace {

EpochInput slab(const Vec3& size) {
  EpochInput epoch = make_epoch(box_surface({0, 0, 0}, size), [](const Vec3& c) { return c[0] < 1e-9; });
  add_landmark(epoch, 0.5 * size + Vec3(0, 0, 0.5 * size[2]));
  return epoch;
}

FrameInput lifted(const EpochInput& epoch, double time, double by) {
  FrameInput frame;
  frame.time = time;
  frame.hooks = {{{epoch.landmarks[0], epoch.landmark_triangles[0]}, epoch.landmarks[0] + Vec3(0, 0, by), 40.0, 7}};
  return frame;
}

SessionSettings settings() {
  SessionSettings s;
  s.threads = 1;
  return s;
}

TEST(EpochReplacement, WhereverMemoryIsSpentTheEpochBeforeGoesOnBitForBitAndASmallerOneIsTaken) {
  const EpochInput first = slab({12, 8, 3}), larger = slab({20, 8, 3}), smaller = slab({8, 8, 3});
  Session undisturbed(settings());
  undisturbed.set_epoch(first);
  undisturbed.solve(lifted(first, 1, 1.0), {}, kNever);
  const FrameOutput expected = undisturbed.solve(lifted(first, 2, 1.5), {}, kNever);
  undisturbed.set_epoch(smaller);
  const FrameOutput expected_after = undisturbed.solve(lifted(smaller, 3, 1.0), {}, kNever);
  ASSERT_TRUE(expected.converged && expected_after.converged);

  int refused = 0;
  bool taken = false;
  for (long allowed = 0; !taken; allowed += 1 + allowed / 8) {
    Session session(settings());
    session.set_epoch(first);
    session.solve(lifted(first, 1, 1.0), {}, kNever);
    blocks_left = allowed;
    try {
      session.set_epoch(larger);
      taken = true;
    } catch (const std::bad_alloc&) {
      ++refused;
    }
    blocks_left = -1;
    if (taken) break;
    const FrameOutput found = session.solve(lifted(first, 2, 1.5), {}, kNever);
    ASSERT_EQ(found.state.nodes, expected.state.nodes) << allowed;
    ASSERT_EQ(found.stress, expected.stress) << allowed;
    ASSERT_EQ(session.set_epoch(smaller).cells, 8 * 8 * 3);
    ASSERT_EQ(session.solve(lifted(smaller, 3, 1.0), {}, kNever).state.nodes, expected_after.state.nodes) << allowed;
  }
  EXPECT_GT(refused, 15);
}

TEST(EpochReplacement, AnEpochBeyondTheBudgetOrInBoneIsRefusedAndTheOneBeforeStays) {
  SessionSettings s = settings();
  s.memory_budget = std::size_t{32} << 20;
  s.bones = box_surface({-1, -1, -4}, {9, 9, 0});
  Session session(s);
  const EpochInput first = slab({8, 8, 3});
  session.set_epoch(first);
  const FrameOutput before = session.solve(lifted(first, 1, 1.0), {}, kNever);
  ASSERT_TRUE(before.converged) << before.failure.message;
  EpochInput sunk = first;
  for (Vec3& point : sunk.surface.points) point[2] -= 2.0;
  for (const EpochInput& bad : {slab({900, 900, 30}), sunk}) {
    EXPECT_THROW(session.set_epoch(bad), RefusedError);
    EXPECT_EQ(session.solve(lifted(first, 1, 1.0), {}, kNever).state.nodes, before.state.nodes);
  }
  EXPECT_TRUE(session.solve(lifted(first, 2, 1.2), {}, kNever).converged);
}

TEST(EpochReplacement, ResultsCarryTheIdsOfTheirHooks) {
  Session session(settings());
  const EpochInput epoch = slab({12, 8, 3});
  session.set_epoch(epoch);
  FrameInput frame = lifted(epoch, 1, 1.0);
  frame.hooks.push_back(frame.hooks[0]);
  EXPECT_THROW(session.solve(frame, {}, kNever), RefusedError);  // two of one id
  frame.hooks[1].index = 3;
  frame.hooks[1].target += Vec3(0, 0, 2.0);
  const FrameOutput one = session.solve(frame, {}, kNever);
  EXPECT_EQ(one.hook_indices, (std::vector<std::int32_t>{7, 3}));
  std::swap(frame.hooks[0], frame.hooks[1]);
  const FrameOutput other = session.solve(frame, {}, kNever);
  EXPECT_EQ(other.hook_indices, (std::vector<std::int32_t>{3, 7}));
  EXPECT_NEAR(one.hook_forces[2], other.hook_forces[5], 0.02 * std::abs(one.hook_forces[2]));
  EXPECT_LT(one.hook_forces[2], one.hook_forces[5]);
}

}  // namespace
}  // namespace lappet
