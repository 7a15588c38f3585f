// The instruction sets that kernels are built for, and which of them this processor has.
#pragma once
#include <string_view>
#include <vector>

namespace lappet {

enum class InstructionSet { kScalar, kSse42, kAvx2, kAvx512, kNeon };

std::string_view name(InstructionSet set);

// Those that this program was built for and this processor has, from the plainest to the widest; scalar is always one.
std::vector<InstructionSet> available_instruction_sets();

// The widest one, or what the environment variable LAPPET_ISA names (scalar, sse42, avx2, avx512, neon). Throws
// RefusedError where it names none, or one that is not available.
InstructionSet choose_instruction_set();

}  // namespace lappet
