// The kernel suite: solverd_benchmarks [--stream-bytes N] and the options of google-benchmark. `make bench` runs it and
// makes its tables of what --benchmark_format=json prints.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <string>
#include <vector>

#include "math/instruction_set.h"
#include "working_set.h"

namespace {

// Four times the last cache, or 2 GiB where that is less: on servers the last cache is shared with many.
std::size_t default_stream_bytes() {
  std::size_t last = 8 << 20;
  for (const auto& cache : benchmark::CPUInfo::Get().caches)
    last = std::max(last, static_cast<std::size_t>(cache.size));
  return std::min(4 * last, std::size_t{2} << 30);
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  CLI::App app("Measures the elastic kernels of lappet-solverd.", "solverd_benchmarks");
  std::size_t stream_bytes = default_stream_bytes();
  app.add_option("--stream-bytes", stream_bytes, "Memory that streaming walks through, bytes")
      ->capture_default_str()
      ->check(CLI::Range(std::size_t{1} << 24, std::size_t{1} << 36));
  CLI11_PARSE(app, argc, argv);
  try {
    std::string sets;
    for (const auto set : lappet::available_instruction_sets())
      sets += (sets.empty() ? "" : ",") + std::string(lappet::name(set));
    benchmark::AddCustomContext("instruction_sets", sets);
    benchmark::AddCustomContext("isa", std::string(lappet::name(lappet::choose_instruction_set())));
    benchmark::AddCustomContext("compiler", LAPPET_COMPILER);
    benchmark::AddCustomContext("stream_bytes", std::to_string(stream_bytes));
    // A pass touches a part of what all passes need; half as much again lets the product walk through all of the wish.
    // Those that touch less (the results name it) still pass twice the last cache.
    lappet::Arena arena(stream_bytes + stream_bytes / 2);
    lappet::enlist_machine(arena);
    lappet::enlist_cell_kernels(arena);
    lappet::enlist_passes(arena);
    lappet::enlist_threads();
    benchmark::RunSpecifiedBenchmarks();
  } catch (const std::exception& error) {
    std::cerr << "solverd_benchmarks: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
