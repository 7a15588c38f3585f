#include "cell_kernels_instance.h"
#include "math/simd_number.h"

namespace lappet {

void fill_cell_kernels_sse42(CellKernels& kernels) {
  fill_cell_kernels<xsimd::batch<float, xsimd::sse4_2>, xsimd::batch<double, xsimd::sse4_2>>(kernels);
}

}  // namespace lappet
