#include "math/simd_number.h"
#include "solve/multigrid/frame_product_kernel.h"

namespace lappet {

void fill_frame_product_sse42(FrameProduct<float>& product) {
  product = multiply_frame_rows<xsimd::batch<float, xsimd::sse4_2>, float>;
}
void fill_frame_product_sse42(FrameProduct<double>& product) {
  product = multiply_frame_rows<xsimd::batch<float, xsimd::sse4_2>, double>;
}

}  // namespace lappet
