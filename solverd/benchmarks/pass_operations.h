// How many arithmetic operations the passes of the daemon take per cell: neo-Hookean, one quadrature point. Counted by
// running their kernels on Counted numbers (counted_number.h); adding up at the nodes of the lattice is left out.
#pragma once

namespace lappet {

struct PassOperations {
  double product, evaluate, stress_derivative, diagonal;
};
PassOperations count_pass_operations();

}  // namespace lappet
