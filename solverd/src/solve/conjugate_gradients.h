// Preconditioned conjugate gradients on the free nodes; vectors in Real, dot products in double.
#pragma once
#include <cmath>
#include <functional>

#include "solve/two_level.h"

namespace lappet {

struct LinearOutcome {
  int iterations = 0;
  double reduction = 1.0;   // of the residual's norm
  bool indefinite = false;  // met a direction in which the energy does not curve upwards, and stopped there
};

// Solves K x = b to |b - K x| <= tolerance |b| from x = 0. `stop` is asked once an iteration.
template <class Real>
LinearOutcome conjugate_gradients(const System<Real>& system, const TwoLevel<Real>& preconditioner,
                                  std::span<const Real> b, std::span<Real> x, double tolerance, int most,
                                  const std::function<bool()>& stop) {
  const std::size_t size = b.size();
  std::vector<Real> r(b.begin(), b.end()), z(size), p(size), q(size), previous(size);
  std::fill(x.begin(), x.end(), Real(0));
  const double start = std::sqrt(dot<Real>(r, r));
  LinearOutcome outcome;
  if (!(start > 0.0)) return outcome;
  double rho = 0.0;
  while (outcome.iterations < most && !stop()) {
    preconditioner.apply(r, z);
    const double rho_new = dot<Real>(r, z);
    // Polak-Ribiere: tolerates a preconditioner that rounding makes slightly unsymmetric
    const double beta = outcome.iterations == 0 ? 0.0 : (rho_new - dot<Real>(previous, z)) / rho;
    if (!(rho_new > 0.0)) {
      outcome.indefinite = true;
      break;
    }
    rho = rho_new;
    combine<Real>(static_cast<Real>(beta), Real(1), z, p);
    system.multiply(p, q);
    const double curvature = dot<Real>(p, q);
    if (!(curvature > 0.0)) {
      outcome.indefinite = true;
      break;
    }
    const double alpha = rho / curvature;
    copy<Real>(r, previous);
    add<Real>(static_cast<Real>(alpha), p, x);
    add<Real>(static_cast<Real>(-alpha), q, r);
    ++outcome.iterations;
    outcome.reduction = std::sqrt(dot<Real>(r, r)) / start;
    if (outcome.reduction <= tolerance) break;
  }
  return outcome;
}

}  // namespace lappet
