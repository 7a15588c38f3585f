#include "kernel_twins_instance.h"

namespace lappet {

void fill_kernel_twins_scalar(KernelTwins<float>& twins) { TwinInstance<float>::fill(twins); }
void fill_kernel_twins_scalar(KernelTwins<double>& twins) { TwinInstance<double>::fill(twins); }

}  // namespace lappet
