// Chebyshev smoothing on a block-Jacobi splitting D, before and after a coarse correction: x = p(D^-1 K) D^-1 b, the
// residual polynomial small on [largest / (range degree), largest].
//
// A cycle of degree d takes 2 d products with K: d - 1 before, one for the residual that the coarse level sees, one for
// what the correction changes, d - 1 after.
//
// On every level K is a sum of positive semidefinite cells (and contact penalties) that couple eight nodes each, and of
// constraints, which D holds too: by Cauchy and Schwarz no eigenvalue of D^-1 K exceeds eight. Single cells come near
// it where they are much stiffer than those around them, as at a suture's anchor, and an estimate from a few Lanczos
// steps misses them, the more surely the more nodes there are: Chebyshev's polynomial then blows up on them and the
// preconditioner is no longer definite.
#pragma once
#include <vector>

#include "solve/multigrid/block_jacobi.h"
#include "solve/system/vectors.h"

namespace lappet {

template <class Real, int Size>
class Chebyshev {
 public:
  // Of D^-1 K: no eigenvalue exceeds it.
  static constexpr double kMaxEigenvalue = 8.0;

  Chebyshev(int degree, double range) : degree_(degree), range_(range) {}

  BlockJacobi<Real, Size>& diagonal() { return diagonal_; }
  int degree() const { return degree_; }
  // After the diagonal is set.
  void resize() {
    for (auto* v : {&r_, &d_, &q_}) v->resize(Size * diagonal_.nodes());
  }

  // x = p(D^-1 K) D^-1 b; leaves b - K x = residual() - product().
  template <class Multiply>
  void before(const Multiply& multiply, std::span<const Real> b, std::span<Real> x) {
    const Recurrence c(*this);
    diagonal_.first(c.start, b.data(), r_.data(), d_.data(), x.data());
    continue_(multiply, c, x);
    multiply(d_, q_);
  }
  // x += correction() and then smooths what remains, given product() = K correction().
  template <class Multiply>
  void after(const Multiply& multiply, std::span<Real> x) {
    const Recurrence c(*this);
    diagonal_.resume(c.start, q_.data(), r_.data(), d_.data(), x.data());
    continue_(multiply, c, x);
  }
  std::span<Real> residual() { return r_; }
  std::span<Real> product() { return q_; }
  // The direction, which is of no use between before() and after().
  std::span<Real> correction() { return d_; }
  std::size_t bytes() const { return diagonal_.bytes() + 3 * r_.size() * sizeof(Real); }

 private:
  struct Recurrence {
    explicit Recurrence(const Chebyshev& c) {
      const double upper = kMaxEigenvalue, lower = upper / (c.range_ * c.degree_);
      center = 0.5 * (upper + lower);
      half = 0.5 * (upper - lower);
      start = Real(1.0 / center);
    }
    double center, half;
    Real start;
  };
  template <class Multiply>
  void continue_(const Multiply& multiply, const Recurrence& c, std::span<Real> x) {
    const double sigma = c.center / c.half;
    double rho = 1.0 / sigma;
    for (int k = 1; k < degree_; ++k) {
      multiply(d_, q_);
      const double next = 1.0 / (2.0 * sigma - rho);
      diagonal_.next(Real(next * rho), Real(2.0 * next / c.half), q_.data(), r_.data(), d_.data(), x.data());
      rho = next;
    }
  }

  int degree_;
  double range_;
  BlockJacobi<Real, Size> diagonal_;
  std::vector<Real> r_, d_, q_;
};

}  // namespace lappet
