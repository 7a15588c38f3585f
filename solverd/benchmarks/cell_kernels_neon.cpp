#include "cell_kernels_instance.h"
#include "math/simd_number.h"

namespace lappet {

void fill_cell_kernels_neon(CellKernels& kernels) {
  fill_cell_kernels<xsimd::batch<float, xsimd::neon64>, xsimd::batch<double, xsimd::neon64>>(kernels);
}

}  // namespace lappet
