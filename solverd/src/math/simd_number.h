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

  // Processors have 12 (AVX2) or 14 bits (AVX-512) of these at once in float; a Newton step makes 14 bits whole.
  static Batch rough_reciprocal(const Batch& x) {
#if defined(__AVX512F__)
    if constexpr (std::is_same_v<T, float> && Batch::size == 16) return Batch(_mm512_rcp14_ps(x));
#endif
#if defined(__AVX2__)
    if constexpr (std::is_same_v<T, float> && Batch::size == 8) return Batch(_mm256_rcp_ps(x));
#endif
    return Batch(T(1)) / x;
  }
  static Batch rough_reciprocal_sqrt(const Batch& x) {
#if defined(__AVX512F__)
    if constexpr (std::is_same_v<T, float> && Batch::size == 16) return Batch(_mm512_rsqrt14_ps(x));
#endif
#if defined(__AVX2__)
    if constexpr (std::is_same_v<T, float> && Batch::size == 8) return Batch(_mm256_rsqrt_ps(x));
#endif
    return Batch(T(1)) / xsimd::sqrt(x);
  }
  static Batch reciprocal_sqrt(const Batch& x) {
#if defined(__AVX512F__)
    if constexpr (std::is_same_v<T, float>) {
      const Batch y = rough_reciprocal_sqrt(x);
      return y * (Batch(T(1.5)) - Batch(T(0.5)) * x * y * y);
    }
#endif
    return Batch(T(1)) / xsimd::sqrt(x);
  }
};

}  // namespace lappet
