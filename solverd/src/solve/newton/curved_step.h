// A step along a valley that bends. Where tissue turns, or keeps a volume that it hardly gives up, what costs little
// energy lies on a curve, and a straight step along its tangent must be cut short: by the line search, again and again.
// The curve is followed to second order instead (geodesic acceleration, Transtrum and Sethna 2012):
//   u + beta step + beta^2 bend,   K bend = -(g(u + alpha step) - g(u) - alpha K step) / alpha^2,
// K the tangent, alpha the cut. One more linear solve that replaces several iterations.
#pragma once
#include <functional>
#include <span>

#include "solve/multigrid/conjugate_gradients.h"

namespace lappet {

// A step with the exact tangent that the line search has cut.
template <class Real>
struct CutStep {
  std::span<const Real> step;  // as it was found
  double alpha;                // of which this share was taken
  double slope;                // gradient . step at its start
  bool inverts;                // the material describes J < 0
};

struct CurvedStepOutcome {
  bool taken = false;
  int pcg_iterations = 0;
};

// Moves u, which is at the end of the cut step, further along the curve where that lowers the energy. at: the
// evaluation at u, before and after.
template <class Real>
CurvedStepOutcome follow_curve(System<Real>& system, TwoLevel<Real>& preconditioner, std::span<Real> u,
                               const Multipliers& multipliers, const CutStep<Real>& cut, LinearVectors<Real>& work,
                               Evaluation& at, const std::function<bool()>& stop);

}  // namespace lappet
