// xsimd batches as `Number`. Included by the kernels' translation units only, each compiled for its instruction set:
// everything here is a template on the batch, so that no two units define the same function differently. xsimd's own
// select, sqrt, min, max, exp and log are found by argument-dependent look-up.
#pragma once
#include <xsimd/xsimd.hpp>

#include "math/number.h"

namespace lappet {

template <class T, class Arch>
struct NumberTraits<xsimd::batch<T, Arch>> {
  using Scalar = T;
  using Mask = xsimd::batch_bool<T, Arch>;
  using Batch = xsimd::batch<T, Arch>;
  static constexpr int kLanes = static_cast<int>(Batch::size);

  // Of its own type: aligned. Of another: converted lane by lane, which compilers turn into vector conversions.
  static Batch load(const T* from) { return Batch::load_aligned(from); }
  static void store(const Batch& value, T* to) { value.store_aligned(to); }
  template <class From>
  static Batch load(const From* from) {
    alignas(64) T buffer[Batch::size];
    for (std::size_t lane = 0; lane < Batch::size; ++lane) buffer[lane] = static_cast<T>(from[lane]);
    return Batch::load_aligned(buffer);
  }
  template <class To>
  static void store(const Batch& value, To* to) {
    alignas(64) T buffer[Batch::size];
    value.store_aligned(buffer);
    for (std::size_t lane = 0; lane < Batch::size; ++lane) to[lane] = static_cast<To>(buffer[lane]);
  }
};

}  // namespace lappet
