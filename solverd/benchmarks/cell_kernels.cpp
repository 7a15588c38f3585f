#include "cell_kernels.h"

#include <stdexcept>

namespace lappet {

CellKernels cell_kernels(InstructionSet set) {
  CellKernels kernels;
  switch (set) {
    case InstructionSet::kScalar:
      fill_cell_kernels_scalar(kernels);
      return kernels;
#if defined(__x86_64__)
    case InstructionSet::kSse42:
      fill_cell_kernels_sse42(kernels);
      return kernels;
    case InstructionSet::kAvx2:
      fill_cell_kernels_avx2(kernels);
      return kernels;
    case InstructionSet::kAvx512:
      fill_cell_kernels_avx512(kernels);
      return kernels;
#elif defined(__aarch64__)
    case InstructionSet::kNeon:
      fill_cell_kernels_neon(kernels);
      return kernels;
#endif
    default:
      throw std::logic_error("no benchmarks were built for this instruction set");
  }
}

}  // namespace lappet
