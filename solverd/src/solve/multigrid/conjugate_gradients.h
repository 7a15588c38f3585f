// Preconditioned conjugate gradients on the free nodes; vectors in Real, dot products in double.
//
// The four vectors are the caller's, who may use them between solves: at a million cells each takes 13 MB in float.
#pragma once
#include <cmath>
#include <functional>
#include <span>
#include <vector>

#include "solve/multigrid/two_level.h"
#include "solve/system/vectors.h"

namespace lappet {

struct LinearOutcome {
  int iterations = 0;
  double reduction = 1.0;   // of the residual's norm
  bool indefinite = false;  // met a direction in which the energy does not curve upwards, and stopped there
};

// What the iteration works on. What is in them but `r` does not matter before, and nothing in them after.
template <class Real>
struct LinearVectors {
  explicit LinearVectors(std::size_t size) : r(size), z(size), p(size), q(size) {}
  std::vector<Real> r, z, p, q;  // residual, preconditioned residual, direction, product of the direction
};

// Solves K x = b, b = work.r, from x = 0 until enough(reduction, alpha, p, x) after an iteration that has added alpha p
// to x and left the residual at `reduction` of its norm. `stop` is called once an iteration.
template <class Real, class Enough>
LinearOutcome conjugate_gradients_until(const System<Real>& system, TwoLevel<Real>& preconditioner,
                                        LinearVectors<Real>& work, std::span<Real> x, const Enough& enough,
                                        int max_iterations, const std::function<bool()>& stop) {
  auto& [r, z, p, q] = work;
  const std::size_t size = r.size();
  set_zero<Real>(x);
  const double start = std::sqrt(dot<Real>(r, r));
  LinearOutcome outcome;
  if (!(start > 0.0)) return outcome;
  double rho = 0.0, alpha = 0.0;
  while (outcome.iterations < max_iterations && !stop()) {
    preconditioner.apply(r, z);
    const auto [rz, qz] = reduce<2>(size, [r = r.data(), q = q.data(), z = z.data()](std::size_t i, double* out) {
      out[0] = double(r[i]) * double(z[i]);
      out[1] = double(q[i]) * double(z[i]);
    });
    if (!(rz > 0.0)) {
      outcome.indefinite = true;
      break;
    }
    // Polak-Ribiere, (r - r_before) . z / rho with r - r_before = -alpha q: tolerates a preconditioner that rounding
    // makes slightly unsymmetric
    const double beta = outcome.iterations == 0 ? 0.0 : -alpha * qz / rho;
    rho = rz;
    if (outcome.iterations == 0)
      copy<Real>(z, p);
    else
      combine<Real>(Real(beta), Real(1), z, p);
    system.multiply(p, q);
    const double curvature = dot<Real>(p, q);
    if (!(curvature > 0.0)) {
      outcome.indefinite = true;
      break;
    }
    alpha = rho / curvature;
    const double squared = reduce<1>(
        size, [a = Real(alpha), p = p.data(), q = q.data(), r = r.data(), x = x.data()](std::size_t i, double* out) {
          x[i] += a * p[i];
          r[i] -= a * q[i];
          out[0] = double(r[i]) * double(r[i]);
        })[0];
    ++outcome.iterations;
    outcome.reduction = std::sqrt(squared) / start;
    if (enough(outcome.reduction, alpha, std::span<const Real>(p), std::span<const Real>(x))) break;
  }
  return outcome;
}

// Solves K x = b, b = work.r, to |b - K x| <= tolerance |b| from x = 0.
template <class Real>
LinearOutcome conjugate_gradients(const System<Real>& system, TwoLevel<Real>& preconditioner, LinearVectors<Real>& work,
                                  std::span<Real> x, double tolerance, int max_iterations,
                                  const std::function<bool()>& stop) {
  const auto enough = [tolerance](double reduction, double, std::span<const Real>, std::span<const Real>) {
    return reduction <= tolerance;
  };
  return conjugate_gradients_until<Real>(system, preconditioner, work, x, enough, max_iterations, stop);
}

template <class Real>
LinearOutcome conjugate_gradients(const System<Real>& system, TwoLevel<Real>& preconditioner, std::span<const Real> b,
                                  std::span<Real> x, double tolerance, int max_iterations,
                                  const std::function<bool()>& stop) {
  LinearVectors<Real> work(b.size());
  copy<Real>(b, work.r);
  return conjugate_gradients<Real>(system, preconditioner, work, x, tolerance, max_iterations, stop);
}

}  // namespace lappet
