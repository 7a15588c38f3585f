// Chebyshev smoothing on a block-Jacobi splitting D, before and after a coarse correction: x = p(D^-1 K) D^-1 b, the
// residual polynomial small on [largest / (kRange degree), largest].
//
// A cycle of degree d takes 2 d products with K: d - 1 before, one for the residual that the coarse level sees, one for
// what the correction changes, d - 1 after.
#pragma once
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <vector>

#include "solve/multigrid/block_jacobi.h"
#include "solve/system/vectors.h"

namespace lappet {

template <class Real, int Size>
class Chebyshev {
 public:
  explicit Chebyshev(int degree) : degree_(degree) {}

  BlockJacobi<Real, Size>& diagonal() { return diagonal_; }
  int degree() const { return degree_; }
  double largest_eigenvalue() const { return largest_; }
  // A known bound on the eigenvalues of D^-1 K.
  void set_largest_eigenvalue(double largest) {
    resize();
    largest_ = largest;
  }

  // Estimates the largest eigenvalue of D^-1 K by `steps` of the Lanczos process (conjugate gradients from a fixed
  // start); is_free(node).
  template <class Multiply, class IsFree>
  void estimate(const Multiply& multiply, const IsFree& is_free, int steps, double margin, double max_eigenvalue) {
    resize();
    const std::size_t nodes = diagonal_.nodes();
    for_each_index(nodes, [&](std::size_t n) {
      for (std::size_t i = Size * n; i < Size * (n + 1); ++i) {
        std::uint32_t hash = std::uint32_t(i) * 2654435761u;
        hash = (hash ^ (hash >> 15)) * 2246822519u;
        r_[i] = is_free(n) ? Real((hash ^ (hash >> 13)) >> 8) / Real(1u << 24) - Real(0.5) : Real(0);
      }
    });
    std::vector<Real> z(r_.size());
    diagonal_.divide(r_.data(), z.data());
    copy<Real>(z, d_);
    double rho = dot<Real>(r_, z), before = 0.0;  // before: beta / alpha of the last step
    Eigen::VectorXd diagonal(steps), beside(steps);
    Eigen::Index size = 0;
    while (size < steps && rho > 0.0) {
      multiply(d_, q_);
      const double curvature = dot<Real>(d_, q_);
      if (!(curvature > 0.0)) break;
      const double alpha = rho / curvature;
      add<Real>(Real(-alpha), q_, r_);
      diagonal_.divide(r_.data(), z.data());
      const double rho_next = dot<Real>(r_, z), beta = rho_next / rho;
      diagonal[size] = 1.0 / alpha + before;
      beside[size] = std::sqrt(std::max(beta, 0.0)) / alpha;
      ++size;
      before = beta / alpha;
      combine<Real>(Real(beta), Real(1), z, d_);
      rho = rho_next;
    }
    if (size == 0) {
      largest_ = max_eigenvalue;
      return;
    }
    Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
    solver.computeFromTridiagonal(diagonal.head(size), beside.head(size - 1), Eigen::EigenvaluesOnly);
    largest_ = std::min(margin * solver.eigenvalues().maxCoeff(), max_eigenvalue);
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
  static constexpr double kRange = 4.0;
  struct Recurrence {
    explicit Recurrence(const Chebyshev& c) {
      const double upper = c.largest_, lower = upper / (kRange * c.degree_);
      center = 0.5 * (upper + lower);
      half = 0.5 * (upper - lower);
      start = Real(1.0 / center);
    }
    double center, half;
    Real start;
  };
  void resize() {
    for (auto* v : {&r_, &d_, &q_}) v->resize(Size * diagonal_.nodes());
  }
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
  double largest_ = 0.0;
  BlockJacobi<Real, Size> diagonal_;
  std::vector<Real> r_, d_, q_;
};

}  // namespace lappet
