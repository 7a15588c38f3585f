#include "cell_kernels_instance.h"
#include "math/simd_number.h"

namespace lappet {

void fill_cell_kernels_avx2(CellKernels& kernels) {
  fill_cell_kernels<xsimd::batch<float, xsimd::fma3<xsimd::avx2>>, xsimd::batch<double, xsimd::fma3<xsimd::avx2>>>(
      kernels);
}

}  // namespace lappet
