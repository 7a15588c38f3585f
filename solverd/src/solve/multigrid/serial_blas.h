// CHOLMOD and its BLAS compute in the thread that calls them. Many sessions factor at a time, each in threads of its
// own, and one factorization is too small to be shared out.
#pragma once
#include <utility>

#include "platform/platform.h"

namespace lappet {

// CHOLMOD's supernodal routines open OpenMP regions of four threads for loops of microseconds, whatever
// OMP_NUM_THREADS says; on a busy machine each waits spinning for threads that do not run, and a factorization takes a
// hundred times as long. No other code here uses OpenMP: its regions get one thread. OpenBLAS, if it is that, likewise;
// its build without threads is no remedy, as it has no locks either and gives wrong numbers to several callers
// (cmake/CheckBlas.cmake refuses it). Both are looked up, as it is CHOLMOD that may or may not bring them along.
inline void keep_blas_serial() {
  static const bool done = [] {
    for (const auto& [name, count] : {std::pair{"omp_set_max_active_levels", 0}, {"openblas_set_num_threads", 1}})
      if (const auto set = reinterpret_cast<void (*)(int)>(loaded_function(name))) set(count);
    return true;
  }();
  static_cast<void>(done);
}

}  // namespace lappet
