#include "kernel_twins.h"

#include <stdexcept>

namespace lappet {

template <class Real>
KernelTwins<Real> kernel_twins(InstructionSet set) {
  KernelTwins<Real> twins;
  switch (set) {
    case InstructionSet::kScalar:
      fill_kernel_twins_scalar(twins);
      return twins;
#if defined(__x86_64__)
    case InstructionSet::kSse42:
      fill_kernel_twins_sse42(twins);
      return twins;
    case InstructionSet::kAvx2:
      fill_kernel_twins_avx2(twins);
      return twins;
    case InstructionSet::kAvx512:
      fill_kernel_twins_avx512(twins);
      return twins;
#elif defined(__aarch64__)
    case InstructionSet::kNeon:
      fill_kernel_twins_neon(twins);
      return twins;
#endif
    default:
      throw std::logic_error("no twins were built for this instruction set");
  }
}

template KernelTwins<float> kernel_twins(InstructionSet);
template KernelTwins<double> kernel_twins(InstructionSet);

}  // namespace lappet
