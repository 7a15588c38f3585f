#include "solve/multigrid/coarse_product_kernel.h"

namespace lappet {

void fill_coarse_product_scalar(CoarseProduct<float>& product) { product = multiply_coarse_rows<float, float>; }
void fill_coarse_product_scalar(CoarseProduct<double>& product) { product = multiply_coarse_rows<float, double>; }

}  // namespace lappet
