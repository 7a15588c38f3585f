#include "math/simd_number.h"
#include "solve/multigrid/frame_product_kernel.h"

namespace lappet {

void fill_frame_product_avx2(FrameProduct<float>& product) {
  product = multiply_frame_rows<xsimd::batch<float, xsimd::fma3<xsimd::avx2>>, float>;
}
void fill_frame_product_avx2(FrameProduct<double>& product) {
  product = multiply_frame_rows<xsimd::batch<float, xsimd::fma3<xsimd::avx2>>, double>;
}

}  // namespace lappet
