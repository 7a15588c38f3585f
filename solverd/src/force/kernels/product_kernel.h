// The tangent product, fused: gather the nodes of the blocks, differential and stabilization of each cell, scatter.
//   dF = du grad N,   dP = U (T : U^T dF V) V^T,   y += dP grad N + hourglass terms
#pragma once
#include <algorithm>

#include "force/kernels/array_access.h"
#include "force/kernels/cell_corners.h"
#include "force/kernels/column_lanes_kernel.h"
#include "math/matrix3.h"

namespace lappet {

// dp = T : hat, both in the frame of the decomposition.
template <class Number>
inline void apply_tangent(const typename NumberTraits<Number>::Scalar* t, const Number (&hat)[9], Number (&dp)[9]) {
  constexpr int w = kLanes<Number>;
  const auto field = [&](int k) { return load<Number>(t + k * w); };
  const Number h01 = field(kHessian + 1), h02 = field(kHessian + 2), h12 = field(kHessian + 4);
  dp[0] = field(kHessian) * hat[0] + h01 * hat[4] + h02 * hat[8];
  dp[4] = h01 * hat[0] + field(kHessian + 3) * hat[4] + h12 * hat[8];
  dp[8] = h02 * hat[0] + h12 * hat[4] + field(kHessian + 5) * hat[8];
  constexpr int kUpper[3] = {1, 2, 5}, kLower[3] = {3, 6, 7};
  for (int k = 0; k < 3; ++k) {
    const Number same = field(kSame + k), cross = field(kCross + k);
    const Number upper = hat[kUpper[k]], lower = hat[kLower[k]];
    dp[kUpper[k]] = same * upper + cross * lower;
    dp[kLower[k]] = same * lower + cross * upper;
  }
}

template <class Number>
inline void load_rotation(const typename NumberTraits<Number>::Scalar* t, int field, Number (&r)[9]) {
  Number q[4];
  for (int k = 0; k < 4; ++k) q[k] = load<Number>(t + (field + k) * kLanes<Number>);
  rotation_of_quaternion(q, r);
}

// What fibers and muscle add to a differential in the frame of the decomposition, where F = diag(sigma) and the
// direction is V^T a. What they add to the isotropic tangent is in that already.
template <class Number>
struct FiberDifferential {
  Number a[3], fa[3], b[3], aligned, along, curvature, muscle_curvature;

  FiberDifferential(const Number* material, const Number* sigma, const Number* response, const Number (&v)[9]) {
    const Number* d = material + kFiberDirection;
    const Number dispersion = material[kFiberDispersion], volume = response[kVolumeSlope];
    for (int i = 0; i < 3; ++i) {
      a[i] = v[i] * d[0] + v[3 + i] * d[1] + v[6 + i] * d[2];
      fa[i] = sigma[i] * a[i];
      b[i] = dispersion * (sigma[i] + volume * sigma[(i + 1) % 3] * sigma[(i + 2) % 3]);
    }
    aligned = Number(1) - Number(3) * dispersion;
    along = response[kAlong];
    curvature = response[kCurvature];
    muscle_curvature = response[kMuscleCurvature];
  }

  void operator()(const Number* hat, Number* dp) const {
    Number dfa[3];
    for (int i = 0; i < 3; ++i) dfa[i] = hat[3 * i] * a[0] + hat[3 * i + 1] * a[1] + hat[3 * i + 2] * a[2];
    const Number work = fa[0] * dfa[0] + fa[1] * dfa[1] + fa[2] * dfa[2];
    const Number b_df = b[0] * hat[0] + b[1] * hat[4] + b[2] * hat[8] + aligned * work;
    const Number bend = curvature * b_df;
    Number pull = bend * aligned;
    if constexpr (kHasMuscle) pull += muscle_curvature * work;
    for (int i = 0; i < 3; ++i) {
      dp[4 * i] += bend * b[i];
      const Number row = along * dfa[i] + pull * fa[i];
      for (int j = 0; j < 3; ++j) dp[3 * i + j] += row * a[j];
    }
  }
};

// df -> dp at a quadrature point, in place.
template <bool kFibers, bool kPrestretched, class Number>
inline void differential(const typename NumberTraits<Number>::Scalar* tangent,
                         const typename NumberTraits<Number>::Scalar* sigma,
                         const typename NumberTraits<Number>::Scalar* fiber,
                         const typename NumberTraits<Number>::Scalar* material, Number (&df)[9]) {
  constexpr int w = kLanes<Number>;
  Number stretch[9];
  if constexpr (kPrestretched) {
    Number unstretched[9];
    load_symmetric3<Number>(material + kPrestretch * w, stretch);
    for (int i = 0; i < 9; ++i) unstretched[i] = df[i];
    multiply3(unstretched, stretch, df);
  }
  Number u[9], v[9], rotated[9], hat[9], dp[9];
  load_rotation(tangent, kU, u);
  load_rotation(tangent, kV, v);
  multiply3_transposed_left(u, df, rotated);
  multiply3(rotated, v, hat);
  apply_tangent(tangent, hat, dp);
  if constexpr (kFibers) {
    Number cell[kMaterialFields], stretches[3], response[kFiberFields];
    for (int k : {kFiberDispersion + 0, kFiberDirection + 0, kFiberDirection + 1, kFiberDirection + 2})
      cell[k] = load<Number>(material + k * w);
    for (int k = 0; k < 3; ++k) stretches[k] = load<Number>(sigma + k * w);
    for (int k = 0; k < kFiberFields; ++k) response[k] = load<Number>(fiber + k * w);
    FiberDifferential<Number>(cell, stretches, response, v)(hat, dp);
  }
  multiply3(u, dp, rotated);
  multiply3_transposed_right(rotated, v, df);
  if constexpr (kPrestretched) {
    for (int i = 0; i < 9; ++i) dp[i] = df[i];
    multiply3(dp, stretch, df);
  }
}

// y += Q x of one component of the cells of a place, one symmetric 8x8 matrix per lane.
template <class Number>
inline void add_quadratic(const typename NumberTraits<Number>::Scalar* matrix, const Number (&x)[8], Number (&y)[8]) {
  int entry = 0;
  for (int a = 0; a < 8; ++a)
    for (int b = a; b < 8; ++b, ++entry) {
      const Number value = load<Number>(matrix + entry * kLanes<Number>);
      y[a] += value * x[b];
      if (a != b) y[b] += value * x[a];
    }
}

// Memory and arithmetic take a product of a large tissue about as long as each other, and what a processor foresees by
// itself is too little to overlap them: its prefetchers end at every page of 4 KiB, and rest while a group is gathered
// and scattered (docs/performance.md).
inline constexpr int kCacheLine = 64, kBytesAhead = 2560;

// Walks through the tangents, kBytesAhead before their use, a few lines at each step that a group takes.
struct TangentAhead {
  const char* next;

  [[gnu::always_inline]] void fetch(int lines) {
    for (; lines > 0; --lines, next += kCacheLine) __builtin_prefetch(next);
  }
};

// The nodes of the next group, half a column at each place: of the columns that no group before it has touched, since
// blocks come in the order of their positions.
template <class Number, class Scalar>
[[gnu::always_inline]] inline void fetch_nodes(const GroupNodes& next, int place, const Scalar* x, const Scalar* y) {
  constexpr int w = kLanes<Number>;
  constexpr int kNewColumns[4] = {4, 5, 7, 8};
  const int column = kNewColumns[place / 2];
  const std::int32_t* row = next.nodes + (next.grid ? column : 3 * column) * w;
  for (int lane = place % 2 * w / 2; lane < (place % 2 + 1) * w / 2; ++lane) {
    __builtin_prefetch(x + 3 * std::ptrdiff_t{row[lane]});
    __builtin_prefetch(y + 3 * std::ptrdiff_t{row[lane]});
  }
}

// y += K x of the groups begin..end; x and y hold 3 numbers per node. Flattened, here and in the other fused kernels:
// a compiler whose budget for inlining is spent on so many instances leaves calls that pass matrices through memory.
template <class Number, bool kOnePoint, bool kFibers, bool kPrestretched, bool kShares>
[[gnu::flatten]] void multiply_groups(const ElasticArrays<typename NumberTraits<Number>::Scalar>& arrays,
                                      std::int64_t begin, std::int64_t end,
                                      const typename NumberTraits<Number>::Scalar* x,
                                      typename NumberTraits<Number>::Scalar* y) {
  using Scalar = typename NumberTraits<Number>::Scalar;
  constexpr int w = kLanes<Number>;
  const int points = kOnePoint ? 1 : arrays.points;
  // Lines of tangents: of a point, and to fetch at each column, once when it is gathered and once when it is scattered,
  // and at each place. Together they are a group's.
  constexpr int point_lines = (kTangentFields * w * int{sizeof(Scalar)} + kCacheLine - 1) / kCacheLine;
  constexpr int column_lines = kOnePoint ? w * int{sizeof(Scalar)} / 16 : 0;
  constexpr int place_lines = point_lines - 2 * kBlockColumns * column_lines / kBlockCells;
  alignas(64) Scalar at[kBlockNodes][3][w];
  alignas(64) Scalar sum[kBlockNodes][3][w];
  for (std::int64_t group = begin; group < end; ++group) {
    const GroupNodes nodes = nodes_of(arrays, group, w), next = nodes_of(arrays, std::min(group + 1, end - 1), w);
    TangentAhead tangents{
        reinterpret_cast<const char*>(arrays.tangent + group * kBlockCells * points * kTangentFields * w) +
        kBytesAhead};
    gather_block<Number>(nodes, x, &at[0][0][0],
                         [&]() __attribute__((always_inline)) { tangents.fetch(column_lines); });
    for (int n = 0; n < kBlockNodes; ++n)
      for (int i = 0; i < 3; ++i) store(Number(0), sum[n][i]);
    for (int place = 0; place < kBlockCells; ++place) {
      const std::int64_t cell = group * kBlockCells + place;
      const Scalar *material = material_of(arrays, cell), *share = kShares ? arrays.share_of(cell, w) : nullptr;
      fetch_nodes<Number>(next, place, x, y);
      Number corners[3][8], result[3][8], df[9];
      for (int i = 0; i < 3; ++i)
        for (int c = 0; c < 8; ++c) corners[i][c] = load<Number>(at[block_node(place, c)][i]);
      if constexpr (kOnePoint) {
        tangents.fetch(place_lines);
        Number modes[3][4];
        for (int i = 0; i < 3; ++i) corner_sums(corners[i], df[3 * i], df[3 * i + 1], df[3 * i + 2], modes[i]);
        if constexpr (kShares) {
          const auto at_point = share_point<Number>(arrays, share, 0, w);
          for (int i = 0; i < 3; ++i) at_point.add_to_gradient(modes[i], df[3 * i], df[3 * i + 1], df[3 * i + 2]);
        }
        differential<kFibers, kPrestretched>(arrays.tangent + cell * kTangentFields * w, arrays.sigma + cell * 3 * w,
                                             arrays.fiber_tangent + cell * kFiberFields * w, material, df);
        Number stiffness[4];
        hourglass_stiffness<Number, kShares>(load<Number>(arrays.stabilization + cell * w), share, w, stiffness);
        for (int i = 0; i < 3; ++i) {
          for (int m = 0; m < 4; ++m) modes[i][m] *= stiffness[m];
          if constexpr (kShares)
            share_point<Number>(arrays, share, 0, w).add_to_modes(df[3 * i], df[3 * i + 1], df[3 * i + 2], modes[i]);
          spread_to_corners(df[3 * i], df[3 * i + 1], df[3 * i + 2], modes[i], result[i]);
        }
      } else {
        for (auto& row : result)
          for (auto& value : row) value = Number(0);
        for (int q = 0; q < points; ++q) {
          tangents.fetch(point_lines);
          const PointGradients<Number, Scalar, false, kShares> gradient(arrays, share, q, w);
          const std::int64_t point = cell * points + q;
          for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
              Number total(0);
              for (int c = 0; c < 8; ++c) total += corners[i][c] * gradient[8 * j + c];
              df[3 * i + j] = total;
            }
          differential<kFibers, kPrestretched>(arrays.tangent + point * kTangentFields * w,
                                               arrays.sigma + point * 3 * w,
                                               arrays.fiber_tangent + point * kFiberFields * w, material, df);
          for (int i = 0; i < 3; ++i)
            for (int c = 0; c < 8; ++c)
              for (int j = 0; j < 3; ++j) result[i][c] += df[3 * i + j] * gradient[8 * j + c];
        }
      }
      for (int i = 0; i < 3; ++i)
        for (int c = 0; c < 8; ++c) {
          Scalar* to = sum[block_node(place, c)][i];
          store(load<Number>(to) + result[i][c], to);
        }
      // From memory to memory: registers that hold the corners for the few cells with a matrix are missed by all
      // others.
      if (arrays.quadratic_of != nullptr && arrays.quadratic_of[cell] >= 0)
        for (int i = 0; i < 3; ++i) {
          Number from[8], to[8];
          for (int c = 0; c < 8; ++c) {
            from[c] = load<Number>(at[block_node(place, c)][i]);
            to[c] = load<Number>(sum[block_node(place, c)][i]);
          }
          add_quadratic(arrays.quadratics + std::int64_t{arrays.quadratic_of[cell]} * 36 * w, from, to);
          for (int c = 0; c < 8; ++c) store(to[c], sum[block_node(place, c)][i]);
        }
    }
    scatter_block<Number>(nodes, &sum[0][0][0], y,
                          [&](int lanes) __attribute__((always_inline)) { tangents.fetch(column_lines * lanes / w); });
  }
}

}  // namespace lappet
