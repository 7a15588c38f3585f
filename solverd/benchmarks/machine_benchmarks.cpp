// What the machine can do: copying as STREAM counts it (what is read and what is written), and multiply-adds.
#include <cstring>

#include "cell_kernels.h"
#include "working_set.h"

namespace lappet {

namespace {

constexpr std::int64_t kCopiedInCache = 12 * 1024;  // bytes, as much again where they go: the first cache holds both
constexpr std::int64_t kRounds = 20000;

template <class T>
void enlist_rate(InstructionSet set, const char* precision, double (*multiply_add)(std::int64_t, T*)) {
  enlist("multiply_add", precision, name(set), Mode::kCache, [multiply_add](benchmark::State& state) {
    double operations = 0.0;
    T result;
    for (auto _ : state) {
      operations = multiply_add(kRounds, &result);
      benchmark::DoNotOptimize(result);
    }
    state.counters["operations"] = operations;
  });
}

}  // namespace

void enlist_machine(Arena& arena) {
  for (const Mode mode : {Mode::kCache, Mode::kStream})
    enlist("copy", "bytes", "any", mode, [&arena, mode, walk = Walk{mode}](benchmark::State& state) mutable {
      if (arena.claim(std::string("copy/") + name(mode)))
        walk.items = mode == Mode::kCache ? kCopiedInCache : std::int64_t(arena.bytes() / 2) / 64 * 64;
      auto* from = arena.take<std::byte>(0);
      std::byte* to = from + walk.items;
      walk.cells = 1.0;
      walk.bytes = 2.0;
      walk.measure(state, [&](std::int64_t begin, std::int64_t end) {
        std::memcpy(to + begin, from + begin, static_cast<std::size_t>(end - begin));
        benchmark::ClobberMemory();
      });
    });
  for (const InstructionSet set : available_instruction_sets()) {
    const CellKernels kernels = cell_kernels(set);
    enlist_rate(set, "float", kernels.multiply_add_float);
    enlist_rate(set, "double", kernels.multiply_add_double);
  }
}

}  // namespace lappet
