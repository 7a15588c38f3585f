// Nodes of blocks in lockstep: three components per node in memory, a vector per component here. Gather reads node
// `index[lane]` of each lane; scatter adds, lane after lane, since lanes may share nodes.
#pragma once
#include <cstdint>

#include "math/number.h"
#if defined(__SSE4_2__)
#include <immintrin.h>
#endif

namespace lappet {

template <class Number>
struct NodeLanes {
  using Scalar = typename NumberTraits<Number>::Scalar;
  static constexpr int kWidth = kLanes<Number>;

  // `out`: [component][lane]
  static void gather(const Scalar* field, const std::int32_t* index, Scalar* out) {
    for (int lane = 0; lane < kWidth; ++lane) {
      const Scalar* from = field + 3 * std::ptrdiff_t{index[lane]};
      out[lane] = from[0];
      out[kWidth + lane] = from[1];
      out[2 * kWidth + lane] = from[2];
    }
  }
  static void scatter_add(Scalar* field, const std::int32_t* index, const Scalar* values) {
    for (int lane = 0; lane < kWidth; ++lane) {
      Scalar* to = field + 3 * std::ptrdiff_t{index[lane]};
      to[0] += values[lane];
      to[1] += values[kWidth + lane];
      to[2] += values[2 * kWidth + lane];
    }
  }
};

#if defined(__SSE4_2__)
// Four lanes of floats at a time: a node is read as a pair and a single, so that nothing beyond it is touched.
template <class Number>
  requires(std::is_same_v<typename NumberTraits<Number>::Scalar, float> && kLanes<Number> >= 4)
struct NodeLanes<Number> {
  static constexpr int kWidth = kLanes<Number>;

  static void gather(const float* field, const std::int32_t* index, float* out) {
    for (int lane = 0; lane < kWidth; lane += 4) {
      const float* a = field + 3 * std::ptrdiff_t{index[lane]};
      const float* b = field + 3 * std::ptrdiff_t{index[lane + 1]};
      const float* c = field + 3 * std::ptrdiff_t{index[lane + 2]};
      const float* d = field + 3 * std::ptrdiff_t{index[lane + 3]};
      const __m128 ab = pair(a, b), cd = pair(c, d);
      _mm_store_ps(out + lane, _mm_shuffle_ps(ab, cd, _MM_SHUFFLE(2, 0, 2, 0)));
      _mm_store_ps(out + kWidth + lane, _mm_shuffle_ps(ab, cd, _MM_SHUFFLE(3, 1, 3, 1)));
      __m128 z = _mm_load_ss(a + 2);
      z = _mm_insert_ps(z, _mm_load_ss(b + 2), 0x10);
      z = _mm_insert_ps(z, _mm_load_ss(c + 2), 0x20);
      z = _mm_insert_ps(z, _mm_load_ss(d + 2), 0x30);
      _mm_store_ps(out + 2 * kWidth + lane, z);
    }
  }
  static void scatter_add(float* field, const std::int32_t* index, const float* values) {
    for (int lane = 0; lane < kWidth; lane += 4) {
      const __m128 x = _mm_load_ps(values + lane), y = _mm_load_ps(values + kWidth + lane),
                   z = _mm_load_ps(values + 2 * kWidth + lane);
      const __m128 ab = _mm_unpacklo_ps(x, y), cd = _mm_unpackhi_ps(x, y);
      add(field + 3 * std::ptrdiff_t{index[lane]}, ab, z);
      add(field + 3 * std::ptrdiff_t{index[lane + 1]}, _mm_movehl_ps(ab, ab), _mm_shuffle_ps(z, z, 1));
      add(field + 3 * std::ptrdiff_t{index[lane + 2]}, cd, _mm_movehl_ps(z, z));
      add(field + 3 * std::ptrdiff_t{index[lane + 3]}, _mm_movehl_ps(cd, cd), _mm_shuffle_ps(z, z, 3));
    }
  }

 private:
  static __m128 pair(const float* a, const float* b) {
    const __m128d low = _mm_load_sd(reinterpret_cast<const double*>(a));
    return _mm_castpd_ps(_mm_loadh_pd(low, reinterpret_cast<const double*>(b)));
  }
  static void add(float* to, __m128 xy, __m128 z) {
    const __m128 old = _mm_castpd_ps(_mm_load_sd(reinterpret_cast<const double*>(to)));
    _mm_storel_pi(reinterpret_cast<__m64*>(to), _mm_add_ps(old, xy));
    _mm_store_ss(to + 2, _mm_add_ss(_mm_load_ss(to + 2), z));
  }
};
#endif

}  // namespace lappet
