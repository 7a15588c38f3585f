#include "math/simd_number.h"
#include "solve/multigrid/coarse_product_kernel.h"

namespace lappet {

void fill_coarse_product_sse42(CoarseProduct<float>& product) {
  product = multiply_coarse_rows<xsimd::batch<float, xsimd::sse4_2>, float>;
}
void fill_coarse_product_sse42(CoarseProduct<double>& product) {
  product = multiply_coarse_rows<xsimd::batch<float, xsimd::sse4_2>, double>;
}

}  // namespace lappet
