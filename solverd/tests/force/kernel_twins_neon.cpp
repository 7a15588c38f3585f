#include "kernel_twins_instance.h"
#include "math/simd_number.h"

namespace lappet {

void fill_kernel_twins_neon(KernelTwins<float>& twins) {
  TwinInstance<xsimd::batch<float, xsimd::neon64>>::fill(twins);
}
void fill_kernel_twins_neon(KernelTwins<double>& twins) {
  TwinInstance<xsimd::batch<double, xsimd::neon64>>::fill(twins);
}

}  // namespace lappet
