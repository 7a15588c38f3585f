// The nodes of blocks in lockstep, between memory and [node][component][lane]. A column of the grid is nine consecutive
// numbers per lane: two or three wide accesses instead of three narrow ones for each node.
//
// Wide accesses have a price. Neighbors along a column share a node, and a load that overlaps a store without lying
// inside it waits until that store has left for the cache. So the scatter adds a few lanes of all columns before it
// goes on to the next lanes, and block_layout.cpp keeps such neighbors half the lanes apart.
#pragma once
#include "force/kernels/elastic_arrays.h"
#include "force/kernels/node_lanes_kernel.h"

namespace lappet {

template <class Number>
struct ColumnLanes {
  using Scalar = typename NumberTraits<Number>::Scalar;
  static constexpr int kWidth = kLanes<Number>, kScatterLanes = kWidth;  // that one call of scatter_add adds

  // index: first node of the column per lane; `out`: [3][component][lane]
  static void gather(const Scalar* field, const std::int32_t* index, Scalar* out) {
    for (int z = 0; z < 3; ++z) NodeLanes<Number>::gather(field + 3 * z, index, out + 3 * z * kWidth);
  }
  // The lanes lane..lane + kScatterLanes, one after the other, since lanes may share nodes.
  static void scatter_add(Scalar* field, const std::int32_t* index, const Scalar* values, int /*lane*/) {
    for (int z = 0; z < 3; ++z) NodeLanes<Number>::scatter_add(field + 3 * z, index, values + 3 * z * kWidth);
  }
};

#if defined(__AVX2__)
template <class Number>
  requires(std::is_same_v<typename NumberTraits<Number>::Scalar, float> && kLanes<Number> >= 8)
struct ColumnLanes<Number> {
  static constexpr int kWidth = kLanes<Number>, kScatterLanes = 4;

  static void gather(const float* field, const std::int32_t* index, float* out) {
    for (int lane = 0; lane < kWidth; lane += 8) {
      const float* from[8];
      for (int k = 0; k < 8; ++k) from[k] = field + 3 * std::ptrdiff_t{index[lane + k]};
      for (int first : {0, 4}) {
        __m256 rows[4];
        for (int k = 0; k < 4; ++k) rows[k] = halves(from[k] + first, from[k + 4] + first);
        transpose(rows);
        for (int k = 0; k < 4; ++k) _mm256_store_ps(out + (first + k) * kWidth + lane, rows[k]);
      }
      // the ninth: of the last four, so that nothing beyond is touched
      const __m256 ab = _mm256_unpackhi_ps(halves(from[0] + 5, from[4] + 5), halves(from[1] + 5, from[5] + 5));
      const __m256 cd = _mm256_unpackhi_ps(halves(from[2] + 5, from[6] + 5), halves(from[3] + 5, from[7] + 5));
      _mm256_store_ps(out + 8 * kWidth + lane, _mm256_shuffle_ps(ab, cd, _MM_SHUFFLE(3, 2, 3, 2)));
    }
  }
  static void scatter_add(float* field, const std::int32_t* index, const float* values, int lane) {
    const float* first = values + lane;
    __m256 rows[4];  // of the first four numbers and the next four; then of the lanes
    for (int k = 0; k < 4; ++k) rows[k] = halves(first + k * kWidth, first + (k + 4) * kWidth);
    transpose(rows);
    for (int k = 0; k < 4; ++k) {
      float* to = field + 3 * std::ptrdiff_t{index[lane + k]};
      _mm256_storeu_ps(to, _mm256_add_ps(_mm256_loadu_ps(to), rows[k]));
      to[8] += first[8 * kWidth + k];
    }
  }

 private:
  static __m256 halves(const float* low, const float* high) {
    return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(low)), _mm_loadu_ps(high), 1);
  }
  // 4x4 in each half
  static void transpose(__m256 (&r)[4]) {
    const __m256 a = _mm256_unpacklo_ps(r[0], r[1]), b = _mm256_unpackhi_ps(r[0], r[1]);
    const __m256 c = _mm256_unpacklo_ps(r[2], r[3]), d = _mm256_unpackhi_ps(r[2], r[3]);
    r[0] = _mm256_shuffle_ps(a, c, _MM_SHUFFLE(1, 0, 1, 0));
    r[1] = _mm256_shuffle_ps(a, c, _MM_SHUFFLE(3, 2, 3, 2));
    r[2] = _mm256_shuffle_ps(b, d, _MM_SHUFFLE(1, 0, 1, 0));
    r[3] = _mm256_shuffle_ps(b, d, _MM_SHUFFLE(3, 2, 3, 2));
  }
};
#endif

// at: [27][component][lane]. Calls step() kBlockColumns times on the way.
template <class Number, class Step>
[[gnu::always_inline]] inline void gather_block(const GroupNodes& nodes,
                                                const typename NumberTraits<Number>::Scalar* field,
                                                typename NumberTraits<Number>::Scalar* at, const Step& step) {
  constexpr int w = kLanes<Number>;
  if (nodes.grid)
    for (int c = 0; c < kBlockColumns; ++c, step())
      ColumnLanes<Number>::gather(field, nodes.nodes + c * w, at + 9 * c * w);
  else
    for (int c = 0; c < kBlockColumns; ++c, step())
      for (int n = 3 * c; n < 3 * c + 3; ++n) NodeLanes<Number>::gather(field, nodes.nodes + n * w, at + 3 * n * w);
}

// field += sum, as [27][component][lane]. Calls step(lanes) on the way; the lanes come to kBlockColumns times the
// width.
template <class Number, class Step>
[[gnu::always_inline]] inline void scatter_block(const GroupNodes& nodes,
                                                 const typename NumberTraits<Number>::Scalar* sum,
                                                 typename NumberTraits<Number>::Scalar* field, const Step& step) {
  constexpr int w = kLanes<Number>, lanes = ColumnLanes<Number>::kScatterLanes;
  if (nodes.grid)
    for (int lane = 0; lane < w; lane += lanes)
      for (int c = 0; c < kBlockColumns; ++c, step(lanes))
        ColumnLanes<Number>::scatter_add(field, nodes.nodes + c * w, sum + 9 * c * w, lane);
  else
    for (int c = 0; c < kBlockColumns; ++c, step(w))
      for (int n = 3 * c; n < 3 * c + 3; ++n)
        NodeLanes<Number>::scatter_add(field, nodes.nodes + n * w, sum + 3 * n * w);
}

}  // namespace lappet
