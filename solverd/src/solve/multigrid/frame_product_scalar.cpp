#include "solve/multigrid/frame_product_kernel.h"

namespace lappet {

void fill_frame_product_scalar(FrameProduct<float>& product) { product = multiply_frame_rows<float, float>; }
void fill_frame_product_scalar(FrameProduct<double>& product) { product = multiply_frame_rows<float, double>; }

}  // namespace lappet
