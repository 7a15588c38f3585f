#include "kernel_twins_instance.h"
#include "math/simd_number.h"

namespace lappet {

void fill_kernel_twins_avx512(KernelTwins<float>& twins) {
  TwinInstance<xsimd::batch<float, xsimd::avx512bw>>::fill(twins);
}
void fill_kernel_twins_avx512(KernelTwins<double>& twins) {
  TwinInstance<xsimd::batch<double, xsimd::avx512bw>>::fill(twins);
}

}  // namespace lappet
