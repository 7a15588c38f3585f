// The 3x3 diagonal blocks of the tangent, per node and symmetric (00 01 02 11 12 22): what smoothers divide by.
#pragma once
#include "force/kernels/array_access.h"
#include "force/kernels/product_kernel.h"

namespace lappet {

// Adds to `block` (6) the block of a corner whose shape function has the gradient g (4 h grad N).
template <bool kFibers, bool kPrestretched, class Number>
inline void add_corner_block(const typename NumberTraits<Number>::Scalar* tangent,
                             const typename NumberTraits<Number>::Scalar* sigma,
                             const typename NumberTraits<Number>::Scalar* fiber,
                             const typename NumberTraits<Number>::Scalar* material, const Number (&u)[9],
                             const Number (&v)[9], const Number (&g)[3], Number (&block)[6]) {
  constexpr int w = kLanes<Number>;
  Number turned[3];
  if constexpr (kPrestretched) {
    Number a[9], stretched[3];
    load_symmetric3<Number>(material + kPrestretch * w, a);
    for (int i = 0; i < 3; ++i) stretched[i] = a[3 * i] * g[0] + a[3 * i + 1] * g[1] + a[3 * i + 2] * g[2];
    for (int j = 0; j < 3; ++j) turned[j] = v[j] * stretched[0] + v[3 + j] * stretched[1] + v[6 + j] * stretched[2];
  } else {
    for (int j = 0; j < 3; ++j) turned[j] = v[j] * g[0] + v[3 + j] * g[1] + v[6 + j] * g[2];
  }
  const auto field = [&](int k) { return load<Number>(tangent + k * w); };
  const Number xx = turned[0] * turned[0], yy = turned[1] * turned[1], zz = turned[2] * turned[2];
  Number hat[6];
  hat[0] = field(kHessian) * xx + field(kSame) * yy + field(kSame + 1) * zz;
  hat[3] = field(kSame) * xx + field(kHessian + 3) * yy + field(kSame + 2) * zz;
  hat[5] = field(kSame + 1) * xx + field(kSame + 2) * yy + field(kHessian + 5) * zz;
  hat[1] = (field(kHessian + 1) + field(kCross)) * turned[0] * turned[1];
  hat[2] = (field(kHessian + 2) + field(kCross + 1)) * turned[0] * turned[2];
  hat[4] = (field(kHessian + 4) + field(kCross + 2)) * turned[1] * turned[2];
  if constexpr (kFibers) {
    Number a[3], s[3], fa[3], b[3];
    const Number d0 = load<Number>(material + kFiberDirection * w),
                 d1 = load<Number>(material + (kFiberDirection + 1) * w),
                 d2 = load<Number>(material + (kFiberDirection + 2) * w);
    for (int i = 0; i < 3; ++i) {
      a[i] = v[i] * d0 + v[3 + i] * d1 + v[6 + i] * d2;
      s[i] = load<Number>(sigma + i * w);
      fa[i] = s[i] * a[i];
    }
    const Number dispersion = load<Number>(material + kFiberDispersion * w),
                 volume = load<Number>(fiber + kVolumeSlope * w);
    const Number along = a[0] * turned[0] + a[1] * turned[1] + a[2] * turned[2];
    const Number aligned = (Number(1) - Number(3) * dispersion) * along;
    for (int i = 0; i < 3; ++i)
      b[i] = dispersion * (s[i] + volume * s[(i + 1) % 3] * s[(i + 2) % 3]) * turned[i] + aligned * fa[i];
    const Number spherical = load<Number>(fiber + kAlong * w) * along * along;
    const Number curvature = load<Number>(fiber + kCurvature * w);
    const Number muscle = load<Number>(fiber + kMuscleCurvature * w) * along * along;
    int k = 0;
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j, ++k) {
        hat[k] += curvature * b[i] * b[j] + muscle * fa[i] * fa[j];
        if (i == j) hat[k] += spherical;
      }
  }
  // U hat U^T
  int k = 0;
  Number rows[9];
  for (int i = 0; i < 3; ++i) {
    rows[3 * i] = u[3 * i] * hat[0] + u[3 * i + 1] * hat[1] + u[3 * i + 2] * hat[2];
    rows[3 * i + 1] = u[3 * i] * hat[1] + u[3 * i + 1] * hat[3] + u[3 * i + 2] * hat[4];
    rows[3 * i + 2] = u[3 * i] * hat[2] + u[3 * i + 1] * hat[4] + u[3 * i + 2] * hat[5];
  }
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j, ++k)
      block[k] += rows[3 * i] * u[3 * j] + rows[3 * i + 1] * u[3 * j + 1] + rows[3 * i + 2] * u[3 * j + 2];
}

// Adds the blocks of the groups begin..end to `blocks`, 6 per node.
template <class Number, bool kOnePoint, bool kFibers, bool kPrestretched, bool kShares>
[[gnu::flatten]] void diagonal_groups(const ElasticArrays<typename NumberTraits<Number>::Scalar>& arrays,
                                      std::int64_t begin, std::int64_t end,
                                      typename NumberTraits<Number>::Scalar* blocks) {
  using Real = typename NumberTraits<Number>::Scalar;
  constexpr int w = kLanes<Number>;
  const int points = kOnePoint ? 1 : arrays.points;
  alignas(64) Real sum[kBlockNodes][6][w];
  for (std::int64_t group = begin; group < end; ++group) {
    for (auto& node : sum)
      for (auto& row : node) store(Number(0), row);
    for (int place = 0; place < kBlockCells; ++place) {
      const std::int64_t cell = group * kBlockCells + place;
      const Real *material = material_of(arrays, cell), *share = kShares ? arrays.share_of(cell, w) : nullptr;
      const auto add = [&](int corner, const Number(&block)[6]) {
        for (int k = 0; k < 6; ++k) {
          Real* to = sum[block_node(place, corner)][k];
          store(load<Number>(to) + block[k], to);
        }
      };
      for (int q = 0; q < points; ++q) {
        const std::int64_t point = cell * points + q;
        const Real* tangent = arrays.tangent + point * kTangentFields * w;
        const Real* sigma = arrays.sigma + point * 3 * w;
        const Real* fiber = arrays.fiber_tangent + point * kFiberFields * w;
        Number u[9], v[9];
        load_rotation(tangent, kU, u);
        load_rotation(tangent, kV, v);
        // At the center opposite corners have opposite gradients, and the same block.
        constexpr bool centered = kOnePoint && !kShares;
        const PointGradients<Number, Real, kOnePoint, kShares> gradients(arrays, share, q, w);
        for (int corner = 0; corner < (centered ? 4 : 8); ++corner) {
          Number g[3], block[6];
          for (int j = 0; j < 3; ++j) g[j] = gradients[8 * j + corner];
          for (auto& value : block) value = Number(0);
          add_corner_block<kFibers, kPrestretched>(tangent, sigma, fiber, material, u, v, g, block);
          if constexpr (kOnePoint) {
            Number modes[4];
            hourglass_stiffness<Number, kShares>(load<Number>(arrays.stabilization + cell * w), share, w, modes);
            const Number stabilization = modes[0] + modes[1] + modes[2] + modes[3];
            block[0] += stabilization;
            block[3] += stabilization;
            block[5] += stabilization;
            if (centered) add(7 - corner, block);
          }
          add(corner, block);
        }
      }
      if (arrays.quadratic_of != nullptr && arrays.quadratic_of[cell] >= 0) {
        const Real* matrix = arrays.quadratics + std::int64_t{arrays.quadratic_of[cell]} * 36 * w;
        int entry = 0;
        for (int corner = 0; corner < 8; entry += 8 - corner, ++corner) {
          const Number value = load<Number>(matrix + entry * w);
          const Number block[6] = {value, Number(0), Number(0), value, Number(0), value};
          add(corner, block);
        }
      }
    }
    const GroupNodes nodes = nodes_of(arrays, group, w);
    nodes.for_each([&](int n, const std::int32_t* row, std::ptrdiff_t shift) __attribute__((always_inline)) {
      for (int lane = 0; lane < w; ++lane) {
        Real* to = blocks + 6 * (row[lane] + shift);
        for (int k = 0; k < 6; ++k) to[k] += sum[n][k][lane];
      }
    });
  }
}

}  // namespace lappet
