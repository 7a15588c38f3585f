// Products of row-major 3x3 matrices on any Number, and rotations as quaternions (w x y z).
#pragma once
#include "math/number.h"

namespace lappet {

// out = a b
template <class Number>
inline void multiply3(const Number (&a)[9], const Number (&b)[9], Number (&out)[9]) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) out[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
}

// out = a^T b
template <class Number>
inline void multiply3_transposed_left(const Number (&a)[9], const Number (&b)[9], Number (&out)[9]) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) out[3 * i + j] = a[i] * b[j] + a[3 + i] * b[3 + j] + a[6 + i] * b[6 + j];
}

// out = a b^T
template <class Number>
inline void multiply3_transposed_right(const Number (&a)[9], const Number (&b)[9], Number (&out)[9]) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      out[3 * i + j] = a[3 * i] * b[3 * j] + a[3 * i + 1] * b[3 * j + 1] + a[3 * i + 2] * b[3 * j + 2];
}

// A symmetric matrix kept as 00 01 02 11 12 22, `w` values from one to the next.
template <class Number, class From>
inline void load_symmetric3(const From* from, Number (&a)[9], int w = kLanes<Number>) {
  a[0] = load<Number>(from);
  a[1] = a[3] = load<Number>(from + w);
  a[2] = a[6] = load<Number>(from + 2 * w);
  a[4] = load<Number>(from + 3 * w);
  a[5] = a[7] = load<Number>(from + 4 * w);
  a[8] = load<Number>(from + 5 * w);
}

template <class Number>
inline void unpack_symmetric3(const Number (&from)[6], Number (&a)[9]) {
  a[0] = from[0];
  a[1] = a[3] = from[1];
  a[2] = a[6] = from[2];
  a[4] = from[3];
  a[5] = a[7] = from[4];
  a[8] = from[5];
}

template <class Number>
inline void rotation_of_quaternion(const Number (&q)[4], Number (&r)[9]) {
  const Number x2 = q[1] + q[1], y2 = q[2] + q[2], z2 = q[3] + q[3];
  const Number wx = q[0] * x2, wy = q[0] * y2, wz = q[0] * z2;
  const Number xx = q[1] * x2, xy = q[1] * y2, xz = q[1] * z2, yy = q[2] * y2, yz = q[2] * z2, zz = q[3] * z2;
  const Number one(1);
  r[0] = one - (yy + zz);
  r[1] = xy - wz;
  r[2] = xz + wy;
  r[3] = xy + wz;
  r[4] = one - (xx + zz);
  r[5] = yz - wx;
  r[6] = xz - wy;
  r[7] = yz + wx;
  r[8] = one - (xx + yy);
}

// The largest component is found first (Shepperd 1978), so that no digits are lost.
template <class Number>
inline void quaternion_of_rotation(const Number (&r)[9], Number (&q)[4]) {
  using std::sqrt;
  const Number one(1);
  const Number four_w = one + r[0] + r[4] + r[8], four_x = one + r[0] - r[4] - r[8];
  const Number four_y = one - r[0] + r[4] - r[8], four_z = one - r[0] - r[4] + r[8];
  const Number wx = r[7] - r[5], wy = r[2] - r[6], wz = r[3] - r[1];
  const Number xy = r[1] + r[3], xz = r[2] + r[6], yz = r[5] + r[7];
  // (w x y z) times four times the largest component
  const auto w_over_x = four_w >= four_x, y_over_z = four_y >= four_z;
  const Number best_wx = select(w_over_x, four_w, four_x), best_yz = select(y_over_z, four_y, four_z);
  const auto first = best_wx >= best_yz;
  const Number best = select(first, best_wx, best_yz);
  const Number scale = Number(0.5) / sqrt(best);
  q[0] = scale * select(first, select(w_over_x, four_w, wx), select(y_over_z, wy, wz));
  q[1] = scale * select(first, select(w_over_x, wx, four_x), select(y_over_z, xy, xz));
  q[2] = scale * select(first, select(w_over_x, wy, xy), select(y_over_z, four_y, yz));
  q[3] = scale * select(first, select(w_over_x, wz, xz), select(y_over_z, yz, four_z));
}

}  // namespace lappet
