#include "math/instruction_set.h"

#include <cstdlib>
#include <stdexcept>
#include <string>

namespace lappet {

std::string_view name(InstructionSet set) {
  switch (set) {
    case InstructionSet::kSse42:
      return "sse42";
    case InstructionSet::kAvx2:
      return "avx2";
    case InstructionSet::kAvx512:
      return "avx512";
    case InstructionSet::kNeon:
      return "neon";
    case InstructionSet::kScalar:
      break;
  }
  return "scalar";
}

std::vector<InstructionSet> available_instruction_sets() {
  std::vector<InstructionSet> sets{InstructionSet::kScalar};
#if defined(__x86_64__)
  __builtin_cpu_init();
#endif
  // Which sets have kernels, solverd/cmake/InstructionSets.cmake says.
#if defined(LAPPET_BUILT_SSE42)
  if (__builtin_cpu_supports("sse4.2")) sets.push_back(InstructionSet::kSse42);
#endif
#if defined(LAPPET_BUILT_AVX2)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) sets.push_back(InstructionSet::kAvx2);
#endif
#if defined(LAPPET_BUILT_AVX512)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("avx512f") &&
      __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw") &&
      __builtin_cpu_supports("avx512vl"))
    sets.push_back(InstructionSet::kAvx512);
#endif
#if defined(LAPPET_BUILT_NEON)
  sets.push_back(InstructionSet::kNeon);
#endif
  return sets;
}

InstructionSet choose_instruction_set() {
  const auto available = available_instruction_sets();
  const char* wanted = std::getenv("LAPPET_ISA");
  if (wanted == nullptr || *wanted == '\0') return available.back();
  std::string names;
  for (const auto set : available) {
    if (name(set) == wanted) return set;
    names += (names.empty() ? "" : ", ") + std::string(name(set));
  }
  throw std::invalid_argument("LAPPET_ISA is \"" + std::string(wanted) +
                              "\", which this processor or program does not " +
                              "have; leave it unset or set it to one of " + names);
}

}  // namespace lappet
