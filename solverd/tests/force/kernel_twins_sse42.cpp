#include "kernel_twins_instance.h"
#include "math/simd_number.h"

namespace lappet {

void fill_kernel_twins_sse42(KernelTwins<float>& twins) {
  TwinInstance<xsimd::batch<float, xsimd::sse4_2>>::fill(twins);
}
void fill_kernel_twins_sse42(KernelTwins<double>& twins) {
  TwinInstance<xsimd::batch<double, xsimd::sse4_2>>::fill(twins);
}

}  // namespace lappet
