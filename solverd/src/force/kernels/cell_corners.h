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

}  // namespace lappet
