#include "cell_kernels_instance.h"
#include "math/simd_number.h"

namespace lappet {

void fill_cell_kernels_avx512(CellKernels& kernels) {
  fill_cell_kernels<xsimd::batch<float, xsimd::avx512bw>, xsimd::batch<double, xsimd::avx512bw>>(kernels);
}

}  // namespace lappet
