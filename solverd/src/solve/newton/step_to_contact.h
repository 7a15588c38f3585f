// A step that would take tissue through tissue, found anew with what it would meet.
//
// Tissue that is not in contact yet is not in the tangent. A step is then cut where the first vertex meets something,
// the next one where the second does, and a wound that closes like a zipper takes one iteration for each. So what the
// step would meet becomes springs that hold it at a small distance, in the direction in which it meets, and the linear
// system is solved again: a step of sequential quadratic programming with a penalty (Nocedal and Wright 2006, ch. 18).
// What the new step would meet is added, a few times. Only the step is sought so: energy, force and line search know
// nothing of these springs.
#pragma once
#include <functional>
#include <span>

#include "solve/multigrid/conjugate_gradients.h"

namespace lappet {

// What a step is sought with.
template <class Real>
struct StepEquations {
  const Evaluation& at;                       // the evaluation at u, of the tangent
  std::function<void()> set_right_hand_side;  // in `work`, without springs, for the current tangent
  std::span<const Real> carried;              // what prescribed nodes have to go besides; or empty
  double tolerance = 1e-2;
};

struct StepToContact {
  int rounds = 0;  // 0: the step meets nothing, or only at its end
  int pcg_iterations = 0;
};

// Replaces the step where less than a share of it is free. Leaves the tangent as it was, and the preconditioner with
// the springs.
template <class Real>
StepToContact find_step_to_contact(System<Real>& system, TwoLevel<Real>& preconditioner, std::span<const Real> u,
                                   const StepEquations<Real>& equations, LinearVectors<Real>& work,
                                   std::span<Real> step, const std::function<bool()>& stop);

}  // namespace lappet
