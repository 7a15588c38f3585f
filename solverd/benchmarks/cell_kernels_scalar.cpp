#include "cell_kernels_instance.h"

namespace lappet {

void fill_cell_kernels_scalar(CellKernels& kernels) { fill_cell_kernels<float, double>(kernels); }

}  // namespace lappet
