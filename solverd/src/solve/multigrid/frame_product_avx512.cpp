#include "math/simd_number.h"
#include "solve/multigrid/frame_product_kernel.h"

namespace lappet {

void fill_frame_product_avx512(FrameProduct<float>& product) {
  product = multiply_frame_rows<xsimd::batch<float, xsimd::avx512bw>, float>;
}
void fill_frame_product_avx512(FrameProduct<double>& product) {
  product = multiply_frame_rows<xsimd::batch<float, xsimd::avx512bw>, double>;
}

}  // namespace lappet
