#include "math/simd_number.h"
#include "solve/multigrid/coarse_product_kernel.h"

namespace lappet {

void fill_coarse_product_neon(CoarseProduct<float>& product) {
  product = multiply_coarse_rows<xsimd::batch<float, xsimd::neon64>, float>;
}
void fill_coarse_product_neon(CoarseProduct<double>& product) {
  product = multiply_coarse_rows<xsimd::batch<float, xsimd::neon64>, double>;
}

}  // namespace lappet
