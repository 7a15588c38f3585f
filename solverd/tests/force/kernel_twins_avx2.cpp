#include "kernel_twins_instance.h"
#include "math/simd_number.h"

namespace lappet {

void fill_kernel_twins_avx2(KernelTwins<float>& twins) {
  TwinInstance<xsimd::batch<float, xsimd::fma3<xsimd::avx2>>>::fill(twins);
}
void fill_kernel_twins_avx2(KernelTwins<double>& twins) {
  TwinInstance<xsimd::batch<double, xsimd::fma3<xsimd::avx2>>>::fill(twins);
}

}  // namespace lappet
