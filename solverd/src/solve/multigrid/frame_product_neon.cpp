#include "math/simd_number.h"
#include "solve/multigrid/frame_product_kernel.h"

namespace lappet {

void fill_frame_product_neon(FrameProduct<float>& product) {
  product = multiply_frame_rows<xsimd::batch<float, xsimd::neon64>, float>;
}
void fill_frame_product_neon(FrameProduct<double>& product) {
  product = multiply_frame_rows<xsimd::batch<float, xsimd::neon64>, double>;
}

}  // namespace lappet
