// The step that Newton-Raphson would take next: K correction = -gradient, to a few per cent. Near an equilibrium it is
// the displacement that the residual still stands for, that is, the algebraic error.
#pragma once
#include "solve/multigrid/conjugate_gradients.h"

namespace lappet {

// at: the evaluation at u, the system's last. The correction is 0 at nodes that are prescribed, and
// everywhere where the tangent cannot be used.
template <class Real>
void newton_correction(System<Real>& system, TwoLevel<Real>& preconditioner, std::span<const Real> u,
                       const Evaluation& at, std::span<Real> correction) {
  constexpr double kReduction = 0.05;
  const int most = preconditioner.is_smoother_only() ? 100 : 4;
  LinearVectors<Real> work(correction.size());
  // The exact tangent knows soft modes best; where it curves downwards at once the definite one stands in.
  for (const PsdProjection how : {PsdProjection::kExact, PsdProjection::kClamp}) {
    std::ranges::fill(correction, Real(0));
    system.linearize(at, how);
    try {
      preconditioner.update(u);
    } catch (const NotDefiniteError&) {
      continue;
    }
    for_each_index(work.r.size(), [&](std::size_t i) { work.r[i] = static_cast<Real>(-at.gradient[i]); });
    const LinearOutcome outcome =
        conjugate_gradients<Real>(system, preconditioner, work, correction, kReduction, most, [] { return false; });
    if (outcome.iterations > 0 || !outcome.indefinite) return;
  }
}

}  // namespace lappet
