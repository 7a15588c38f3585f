// Singular value decomposition of 3x3 matrices, branch-free, by one-sided Jacobi rotations (Hestenes 1958).
//
//   F = U diag(sigma) V^T,  U and V rotations,  sigma[0] >= sigma[1] >= |sigma[2]|.
// The reflection of an inverted F sits in the sign of sigma[2] (Irving et al. 2004). Matrices are row-major. Rotating
// the columns of F, not F^T F, keeps small singular values accurate; repeated and zero ones need no special case.
#pragma once
#include "math/number.h"

namespace lappet {

namespace svd3_detail {

// Makes columns p and q of b orthogonal by a rotation from the right, and applies it to v too.
template <int p, int q, class Number>
inline void rotate_columns(Number (&b)[9], Number (&v)[9]) {
  using std::abs;
  using std::sqrt;
  const Number alpha = b[p] * b[p] + b[3 + p] * b[3 + p] + b[6 + p] * b[6 + p];
  const Number beta = b[q] * b[q] + b[3 + q] * b[3 + q] + b[6 + q] * b[6 + q];
  const Number gamma = b[p] * b[q] + b[3 + p] * b[3 + q] + b[6 + p] * b[6 + q];
  const Number difference = beta - alpha;
  const Number twice = gamma + gamma;
  // The angle may be rough, further sweeps correct it; the rotation must be one to rounding.
  const Number tiny(tiny_number<Number>());
  const Number squared = difference * difference + twice * twice + tiny;
  const Number root = squared * rough_reciprocal_sqrt(squared);
  const Number signed_twice = select(difference < Number(0), -twice, twice);
  const Number tangent = signed_twice * rough_reciprocal(abs(difference) + root);
  const Number cosine = reciprocal_sqrt(Number(1) + tangent * tangent);
  const Number sine = cosine * tangent;
  for (int row = 0; row < 9; row += 3) {
    const Number bp = b[row + p], bq = b[row + q], vp = v[row + p], vq = v[row + q];
    b[row + p] = cosine * bp - sine * bq;
    b[row + q] = sine * bp + cosine * bq;
    v[row + p] = cosine * vp - sine * vq;
    v[row + q] = sine * vp + cosine * vq;
  }
}

// Swaps columns p and q where q is longer, with a sign that keeps the determinant.
template <int p, int q, class Number>
inline void order_columns(Number (&b)[9], Number (&v)[9]) {
  const Number length_p = b[p] * b[p] + b[3 + p] * b[3 + p] + b[6 + p] * b[6 + p];
  const Number length_q = b[q] * b[q] + b[3 + q] * b[3 + q] + b[6 + q] * b[6 + q];
  const auto swap = length_p < length_q;
  for (int row = 0; row < 9; row += 3) {
    const Number bp = b[row + p], vp = v[row + p];
    b[row + p] = select(swap, b[row + q], bp);
    b[row + q] = select(swap, -bp, b[row + q]);
    v[row + p] = select(swap, v[row + q], vp);
    v[row + q] = select(swap, -vp, v[row + q]);
  }
}

}  // namespace svd3_detail

template <class Number>
inline void svd3(const Number (&f)[9], Number (&u)[9], Number (&sigma)[3], Number (&v)[9]) {
  using std::abs;
  using std::max;
  using std::sqrt;
  constexpr int kSweeps = sizeof(typename NumberTraits<Number>::Scalar) == 4 ? 4 : 6;
  const Number zero(0), one(1), tiny(tiny_number<Number>());
  // The angles square the squares of the entries: in float those of a matrix of 1e-9 would vanish.
  Number size = max(abs(f[0]), tiny);
  for (int i = 1; i < 9; ++i) size = max(size, abs(f[i]));
  const Number inverse_size = one / size;
  Number b[9];
  for (int i = 0; i < 9; ++i) {
    b[i] = f[i] * inverse_size;
    v[i] = i % 4 == 0 ? one : zero;
  }
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    svd3_detail::rotate_columns<0, 1>(b, v);
    svd3_detail::rotate_columns<0, 2>(b, v);
    svd3_detail::rotate_columns<1, 2>(b, v);
  }
  svd3_detail::order_columns<0, 1>(b, v);
  svd3_detail::order_columns<0, 2>(b, v);
  svd3_detail::order_columns<1, 2>(b, v);

  // U by Gram-Schmidt on the orthogonal columns; where a column vanishes any unit vector orthogonal to those before.
  const Number length0 = sqrt(b[0] * b[0] + b[3] * b[3] + b[6] * b[6]);
  const auto has0 = length0 > tiny;
  const Number inverse0 = one / select(has0, length0, one);
  const Number u0[3] = {select(has0, b[0] * inverse0, one), select(has0, b[3] * inverse0, zero),
                        select(has0, b[6] * inverse0, zero)};
  const Number along = u0[0] * b[1] + u0[1] * b[4] + u0[2] * b[7];
  Number w[3] = {b[1] - along * u0[0], b[4] - along * u0[1], b[7] - along * u0[2]};
  const Number epsilon(std::numeric_limits<typename NumberTraits<Number>::Scalar>::epsilon());
  const auto has1 = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]) > epsilon * length0 + tiny;
  // u0 x the axis it is farthest from
  const auto x_smallest = (abs(u0[0]) <= abs(u0[1])) && (abs(u0[0]) <= abs(u0[2]));
  const auto y_smallest = abs(u0[1]) <= abs(u0[2]);
  const Number other[3] = {select(x_smallest, zero, select(y_smallest, -u0[2], u0[1])),
                           select(x_smallest, u0[2], select(y_smallest, zero, -u0[0])),
                           select(x_smallest, -u0[1], select(y_smallest, u0[0], zero))};
  for (int i = 0; i < 3; ++i) w[i] = select(has1, w[i], other[i]);
  const Number inverse1 = one / sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
  const Number u1[3] = {w[0] * inverse1, w[1] * inverse1, w[2] * inverse1};
  const Number u2[3] = {u0[1] * u1[2] - u0[2] * u1[1], u0[2] * u1[0] - u0[0] * u1[2], u0[0] * u1[1] - u0[1] * u1[0]};
  for (int i = 0; i < 3; ++i) {
    u[3 * i] = u0[i];
    u[3 * i + 1] = u1[i];
    u[3 * i + 2] = u2[i];
  }
  sigma[0] = size * length0;
  sigma[1] = size * (u1[0] * b[1] + u1[1] * b[4] + u1[2] * b[7]);
  sigma[2] = size * (u2[0] * b[2] + u2[1] * b[5] + u2[2] * b[8]);
}

}  // namespace lappet
