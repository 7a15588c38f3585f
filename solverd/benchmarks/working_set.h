// The memory that benchmarks work on, and how they walk through it: again and again over a few groups (in cache), or
// once over each of several windows of a set that no cache holds (streaming).
#pragma once
#include <benchmark/benchmark.h>
#include <tbb/cache_aligned_allocator.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace lappet {

enum class Mode { kCache, kStream };
inline const char* name(Mode mode) { return mode == Mode::kCache ? "cache" : "stream"; }

// One allocation for all benchmarks, so that its pages are made once.
class Arena {
 public:
  explicit Arena(std::size_t bytes) : memory_(bytes) {}
  std::size_t bytes() const { return memory_.size(); }
  // True where another owner had it before: what it holds is to be written anew, from the start.
  bool claim(const std::string& owner) {
    if (owner == owner_) return false;
    owner_ = owner;
    used_ = 0;
    return true;
  }
  template <class T>
  T* take(std::size_t count) {
    T* place = reinterpret_cast<T*>(memory_.data() + used_);
    used_ += (count * sizeof(T) + 63) / 64 * 64;
    if (used_ > memory_.size()) throw std::length_error("a benchmark asks for more memory than its arena has");
    return place;
  }

 private:
  std::vector<std::byte, tbb::cache_aligned_allocator<std::byte>> memory_;
  std::size_t used_ = 0;
  std::string owner_;
};

// Repeats what lies behind `first` of `count` items of `each` numbers, tile by tile.
template <class T>
void repeat(T* items, std::int64_t first, std::int64_t count, std::int64_t each) {
  for (std::int64_t done = first; done < count; done += first)
    std::copy_n(items, std::min(first, count - done) * each, items + done * each);
}

// The parts of a streamed set: a measurement walks through one, the next one through the next.
inline constexpr std::int64_t kWindows = 32;

// Runs run(begin, end) on `items` things as the mode says, and reports their cost. cells: real cells per item.
struct Walk {
  Mode mode;
  std::int64_t items = 0;
  double cells = 0.0, bytes = 0.0, operations = 0.0;  // per item, per cell, per cell
  std::int64_t next = 0;                              // window

  template <class Run>
  void measure(benchmark::State& state, const Run& run) {
    if (mode == Mode::kCache) {
      run(std::int64_t{0}, items);
      for (auto _ : state) run(std::int64_t{0}, items);
      report(state, cells * double(items));
    } else {
      const std::int64_t window = std::max<std::int64_t>(1, items / kWindows), windows = items / window;
      for (auto _ : state) {
        run(next * window, (next + 1) * window);
        next = (next + 1) % windows;
      }
      report(state, cells * double(window));
    }
  }

 private:
  void report(benchmark::State& state, double cells_an_iteration) const {
    state.counters["cells"] = cells_an_iteration;
    state.counters["bytes_per_cell"] = bytes;
    state.counters["operations_per_cell"] = operations;
    state.counters["set_bytes"] = bytes * cells * double(items);
  }
};

// Registers a benchmark under kernel/precision/set/mode.
template <class Body>
benchmark::internal::Benchmark* enlist(const std::string& kernel, const std::string& precision, std::string_view set,
                                       Mode mode, Body body) {
  auto* entry = benchmark::RegisterBenchmark(
      (kernel + "/" + precision + "/" + std::string(set) + "/" + name(mode)).c_str(), std::move(body));
  if (mode == Mode::kStream) entry->Iterations(1);
  return entry;
}

void enlist_machine(Arena& arena);
void enlist_cell_kernels(Arena& arena);
void enlist_passes(Arena& arena);
void enlist_threads();

}  // namespace lappet
