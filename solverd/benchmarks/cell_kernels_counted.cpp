#include "cell_kernels_instance.h"
#include "counted_number.h"

namespace lappet {

void fill_cell_kernels_counted(CellKernels& kernels) { fill_cell_kernels<Counted<float>, Counted<double>>(kernels); }

}  // namespace lappet
