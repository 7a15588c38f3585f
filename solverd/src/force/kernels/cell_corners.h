// A cell of a block: its corners among the block's nodes, the sums that give its deformation gradient and its hourglass
// amplitudes, and their transposes. Corner c of a cell is (c>>2 & 1, c>>1 & 1, c & 1).
#pragma once
#include "force/kernels/elastic_arrays.h"
#include "math/number.h"

namespace lappet {

// Node of corner c of the cell at `place` of a block.
constexpr int block_node(int place, int c) {
  return 9 * ((place >> 2) + (c >> 2)) + 3 * ((place >> 1 & 1) + (c >> 1 & 1)) + (place & 1) + (c & 1);
}

// Sums over the corners of one component: 4 h times its gradient, and the amplitudes of the modes xy, xz, yz, xyz.
template <class Number>
inline void corner_sums(const Number (&c)[8], Number& x, Number& y, Number& z, Number (&modes)[4]) {
  const Number a0 = c[4] - c[0], a1 = c[5] - c[1], a2 = c[6] - c[2], a3 = c[7] - c[3];
  const Number e0 = c[4] + c[0], e1 = c[5] + c[1], e2 = c[6] + c[2], e3 = c[7] + c[3];
  const Number a01 = a0 + a1, a23 = a2 + a3, d20 = e2 - e0, d31 = e3 - e1;
  x = a01 + a23;
  y = d20 + d31;
  z = (e3 + e1) - (e2 + e0);
  modes[0] = a23 - a01;
  modes[1] = (a1 + a3) - (a0 + a2);
  modes[2] = d31 - d20;
  modes[3] = (a3 - a2) - (a1 - a0);
}

// The transpose: what the corners receive of one component.
template <class Number>
inline void spread_to_corners(const Number& x, const Number& y, const Number& z, const Number (&modes)[4],
                              Number (&c)[8]) {
  const Number sum = x + y, difference = x - y;
  const Number odd7 = (sum + z) + modes[3], odd6 = (sum - z) - modes[3], odd5 = (difference + z) - modes[3],
               odd4 = (difference - z) + modes[3];
  const Number plus = modes[0] + modes[1], minus = modes[0] - modes[1];
  const Number even7 = plus + modes[2], even6 = minus - modes[2], even5 = Number(0) - (minus + modes[2]),
               even4 = modes[2] - plus;
  c[7] = even7 + odd7;
  c[0] = even7 - odd7;
  c[6] = even6 + odd6;
  c[1] = even6 - odd6;
  c[5] = even5 + odd5;
  c[2] = even5 - odd5;
  c[4] = even4 + odd4;
  c[3] = even4 - odd4;
}

// A point of a cell away from its center, in [-1, 1]: what the gradient there takes from the hourglass amplitudes.
template <class Number>
struct CellPoint {
  Number x, y, z;

  void add_to_gradient(const Number (&modes)[4], Number& gx, Number& gy, Number& gz) const {
    gx += y * modes[0] + z * (modes[1] + y * modes[3]);
    gy += x * modes[0] + z * (modes[2] + x * modes[3]);
    gz += x * (modes[1] + y * modes[3]) + y * modes[2];
  }
  // The transpose.
  void add_to_modes(const Number& gx, const Number& gy, const Number& gz, Number (&modes)[4]) const {
    modes[0] += y * gx + x * gy;
    modes[1] += z * gx + x * gz;
    modes[2] += z * gy + y * gz;
    modes[3] += y * z * gx + x * (z * gy + y * gz);
  }
  // 4 h grad N of the corners, [3][8].
  void gradients(Number (&g)[24]) const {
    const Number one(1), fx[2] = {one - x, one + x}, fy[2] = {one - y, one + y}, fz[2] = {one - z, one + z};
    for (int c = 0; c < 8; ++c) {
      const int i = c >> 2, j = c >> 1 & 1, k = c & 1;
      const Number gx = fy[j] * fz[k], gy = fx[i] * fz[k], gz = fx[i] * fy[j];
      g[c] = i == 0 ? Number(0) - gx : gx;
      g[8 + c] = j == 0 ? Number(0) - gy : gy;
      g[16 + c] = k == 0 ? Number(0) - gz : gz;
    }
  }
};

// Where quadrature point q of a part of a cell lies; `share` as ElasticArrays::share_of gives it, at the lane.
template <class Number, class Real>
inline CellPoint<Number> share_point(const ElasticArrays<Real>& arrays, const Real* share, int q, int width) {
  using Scalar = typename NumberTraits<Number>::Scalar;
  Number at[3];
  for (int i = 0; i < 3; ++i)
    at[i] = load<Number>(share + (kShareCenter + i) * width) +
            load<Number>(share + (kShareScale + i) * width) * Number(Scalar(arrays.positions[3 * q + i]));
  return {at[0], at[1], at[2]};
}

// The stiffness of the hourglass modes xy, xz, yz, xyz; share: as for share_point, where kShares.
template <class Number, bool kShares, class Real>
inline void hourglass_stiffness(const Number& stabilization, const Real* share, int width, Number (&modes)[4]) {
  using Scalar = typename NumberTraits<Number>::Scalar;
  for (int m = 0; m < 4; ++m) {
    if constexpr (kShares)
      modes[m] = stabilization * load<Number>(share + (kShareHourglass + m) * width);
    else
      modes[m] = m == 3 ? Number(Scalar(0.5)) * stabilization : stabilization;
  }
}

// 4 h grad N of the corners at quadrature point q, [3][8] as one number. Of a whole cell they are read where they are
// used: registers that hold them would be missed. share: as for share_point, where kShares.
template <class Number, class Real, bool kOnePoint, bool kShares>
class PointGradients {
 public:
  PointGradients(const ElasticArrays<Real>& arrays, const Real* share, int q, int width)
      : whole_(arrays.gradients + 24 * q) {
    if constexpr (kShares) share_point<Number>(arrays, share, q, width).gradients(own_);
  }
  Number operator[](int i) const {
    using Scalar = typename NumberTraits<Number>::Scalar;
    if constexpr (kShares) return own_[i];
    if constexpr (kOnePoint) return Number((i % 8) >> (2 - i / 8) & 1 ? 1 : -1);
    return Number(Scalar(whole_[i]));
  }

 private:
  const double* whole_;
  Number own_[kShares ? 24 : 1];
};

}  // namespace lappet
