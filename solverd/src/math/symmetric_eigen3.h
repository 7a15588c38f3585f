// Eigenvalues of symmetric 3x3 matrices, branch-free, by two-sided Jacobi rotations, and the positive definite part of
// one.
#pragma once
#include "math/number.h"

namespace lappet {

// A symmetric matrix as {00, 01, 02, 11, 12, 22}.
template <class Number>
using Symmetric3 = Number[6];

namespace symmetric_eigen3_detail {

constexpr int index(int i, int j) {
  constexpr int table[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
  return table[i][j];
}

template <int p, int q, int r, class Number>
inline void rotate(Number (&a)[6], Number (&v)[9]) {
  using std::abs;
  using std::sqrt;
  const Number app = a[index(p, p)], aqq = a[index(q, q)], apq = a[index(p, q)];
  // What rounding hides is nothing: its square would be a denormal number, which processors are slow at.
  using Scalar = typename NumberTraits<Number>::Scalar;
  const auto matters = abs(apq) > Number(std::numeric_limits<Scalar>::epsilon()) * (abs(app) + abs(aqq));
  const Number difference = aqq - app, twice = select(matters, apq + apq, Number(0));
  const Number root = sqrt(difference * difference + twice * twice);
  const Number signed_twice = select(difference < Number(0), -twice, twice);
  const Number t = signed_twice / (abs(difference) + root + Number(tiny_number<Number>()));
  const Number c = reciprocal_sqrt(Number(1) + t * t), s = c * t;
  a[index(p, p)] = app - t * apq;
  a[index(q, q)] = aqq + t * apq;
  a[index(p, q)] = Number(0);
  const Number arp = a[index(r, p)], arq = a[index(r, q)];
  a[index(r, p)] = c * arp - s * arq;
  a[index(r, q)] = s * arp + c * arq;
  for (int row = 0; row < 9; row += 3) {
    const Number vp = v[row + p], vq = v[row + q];
    v[row + p] = c * vp - s * vq;
    v[row + q] = s * vp + c * vq;
  }
}

}  // namespace symmetric_eigen3_detail

// a = V diag(values) V^T; the values are not ordered.
template <class Number>
inline void symmetric_eigen3(const Number (&matrix)[6], Number (&values)[3], Number (&v)[9]) {
  namespace detail = symmetric_eigen3_detail;
  constexpr int kSweeps = sizeof(typename NumberTraits<Number>::Scalar) == 4 ? 4 : 6;
  Number a[6];
  for (int i = 0; i < 6; ++i) a[i] = matrix[i];
  for (int i = 0; i < 9; ++i) v[i] = Number(i % 4 == 0 ? 1 : 0);
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    detail::rotate<0, 1, 2>(a, v);
    detail::rotate<0, 2, 1>(a, v);
    detail::rotate<1, 2, 0>(a, v);
  }
  values[0] = a[0];
  values[1] = a[3];
  values[2] = a[5];
}

// Replaces the eigenvalues by max(value, floor), or by max(|value|, floor) where `absolute`.
template <class Number>
inline void make_definite3(Number (&a)[6], Number floor, bool absolute) {
  using std::abs;
  using std::max;
  Number values[3], v[9];
  symmetric_eigen3(a, values, v);
  for (auto& value : values) value = max(absolute ? Number(abs(value)) : value, floor);
  int k = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j, ++k)
      a[k] = values[0] * v[3 * i] * v[3 * j] + values[1] * v[3 * i + 1] * v[3 * j + 1] +
             values[2] * v[3 * i + 2] * v[3 * j + 2];
}

}  // namespace lappet
