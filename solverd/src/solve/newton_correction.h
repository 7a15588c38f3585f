// The step that Newton-Raphson would take next: K correction = -gradient, to a few per cent. Near an equilibrium it is
// the displacement that the residual still stands for, that is, the algebraic error.
#pragma once
#include "solve/conjugate_gradients.h"

namespace lappet {

// The system holds the gradient at u. `linearized`: it and the preconditioner hold a tangent from nearby, which is used
// as it is. The correction is 0 at nodes that are prescribed, and everywhere where the tangent cannot be used.
template <class Real>
void newton_correction(System<Real>& system, TwoLevel<Real>& preconditioner, std::span<const Real> u, bool linearized,
                       std::span<Real> correction) {
  constexpr double kReduction = 0.05;
  constexpr int kMostIterations = 4;
  std::fill(correction.begin(), correction.end(), Real(0));
  if (!linearized) {
    system.linearize(Definiteness::kClamp);
    try {
      preconditioner.update(u);
    } catch (const NotDefiniteError&) {
      return;
    }
  }
  const auto gradient = system.gradient();
  std::vector<Real> rhs(correction.size());
  for (std::size_t i = 0; i < rhs.size(); ++i) rhs[i] = static_cast<Real>(-gradient[i]);
  conjugate_gradients<Real>(system, preconditioner, rhs, correction, kReduction, kMostIterations, [] { return false; });
}

}  // namespace lappet
