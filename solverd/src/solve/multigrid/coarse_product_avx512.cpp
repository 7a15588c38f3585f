#include "math/simd_number.h"
#include "solve/multigrid/coarse_product_kernel.h"

namespace lappet {

void fill_coarse_product_avx512(CoarseProduct<float>& product) {
  product = multiply_coarse_rows<xsimd::batch<float, xsimd::avx512bw>, float>;
}
void fill_coarse_product_avx512(CoarseProduct<double>& product) {
  product = multiply_coarse_rows<xsimd::batch<float, xsimd::avx512bw>, double>;
}

}  // namespace lappet
