// The equilibrium of a frame: Newton-Raphson with a line search on the energy inside an augmented Lagrangian iteration
// for what must hold exactly.
//
// Converged means: |residual| <= tolerance * force scale (elastic forces only), every gap <= gap tolerance, prescribed
// nodes where they belong, and J > 0 where the material does not invert. Anything else is reported as not converged.
#pragma once
#include <functional>
#include <span>
#include <string>

#include "solve/multigrid/two_level.h"
#include "solve/newton/failure.h"

namespace lappet {

struct EquilibriumOptions {
  double tolerance = 1e-3;
  double gap_tolerance = 1e-3;  // mm
  int max_newton = 100;
  bool inverts = false;             // the material describes J < 0
  bool relaxes = true;              // where a few nodes hold the rest up, they go ahead (local_relaxation.h)
  bool neighborhood_first = false;  // what the changes reach goes ahead (change_neighborhood.h)
  // The start is at rest and loaded: one iteration is taken though its residual be within the tolerance. What bends a
  // slender piece is far below its modulus, which the force scale begins with.
  bool moves_first = false;
};

struct EquilibriumOutcome {
  Evaluation at;  // where the search ended
  bool converged = false;
  Failure failure;
  int newton_iterations = 0, pcg_iterations = 0;
  std::int64_t active_cells = 0;  // that were solved for; 0: nothing was to be done
  double residual = 0.0, force_scale = 0.0, gap = 0.0, energy = 0.0, minimum_j = 1.0;
  std::int32_t inverted = 0;
  double seconds_update = 0.0, seconds_linear = 0.0, seconds_setup = 0.0;
};

struct SolveObserver {
  std::function<void(int newton, double residual, double gap)> progress;
  std::function<bool()> stop;  // asked often; true ends the solve with the reason "stopped"
};

// Moves u (3 per node) and the multipliers to equilibrium in place. reused: an evaluation whose memory may be used.
template <class Real>
EquilibriumOutcome find_equilibrium(System<Real>& system, TwoLevel<Real>& preconditioner, std::span<Real> u,
                                    Multipliers& multipliers, const EquilibriumOptions& options,
                                    const SolveObserver& observer, Evaluation reused = {});

}  // namespace lappet
