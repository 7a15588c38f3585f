// The equilibrium of a frame: Newton-Raphson with a line search on the energy inside an augmented Lagrangian iteration
// for what must hold exactly.
//
// Converged means: the displacement still to come is small (kSpacings, kShare below), |residual| <= tolerance * force
// scale in every cluster of nodes (elastic forces only; solve/system/residual_clusters.h), every gap <= gap tolerance,
// prescribed nodes where they belong, and J > 0 where the material does not invert. Anything else is reported as not
// converged.
#pragma once
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "solve/multigrid/two_level.h"
#include "solve/newton/failure.h"

namespace lappet {

// Of displacements still to come, for each unit of the tolerance: at most this many spacings, and at most this share of
// the largest displacement of the fragment, but no less than a gap may be left open: at the default tolerance of 1e-3
// 0.02 spacings, 1 % and 0.001 spacings.
inline constexpr double kSpacingsPerTolerance = 20.0, kSharePerTolerance = 10.0;

enum class Accuracy {
  kFrame,       // converged as above
  kLoadStep,    // but without a look at the displacement still to come: what the next load step starts from
  kRelaxation,  // and the residual in one norm: a few nodes on the way to something else, nor are these relaxed further
};

// Where a search has ended that was after the same: one that begins there has nothing to do.
struct Arrival {
  double energy = 0.0, residual = 0.0;  // tell that it begins there
  double to_come = 0.0;                 // mm
};

struct EquilibriumOptions {
  double tolerance = 1e-3;
  double gap_tolerance = 1e-3;  // mm
  int max_newton = 100;
  bool inverts = false;  // the material describes J < 0
  Accuracy accuracy = Accuracy::kFrame;
  // How the tissue moved last, 3 per node, mm: it goes on so where that lowers the energy. Empty: nobody knows.
  std::span<const float> motion;
  // While something is dragged, the last of them first: it goes on by what of them lowers the energy most
  // (predict_motion.h), whatever `motion` is.
  std::span<const std::vector<float>> motions;
  bool last_step_tells = false;     // a step that may be the last is solved until its size is known
  bool neighborhood_first = false;  // what the changes reach goes ahead (change_neighborhood.h)
  std::optional<Arrival> known;     // where the search before ended, if that was after the same
  bool keeps_step = false;          // the outcome has the displacement still to come at each node
};

struct EquilibriumOutcome {
  Evaluation at;  // where the search ended
  bool converged = false;
  Failure failure;
  int newton_iterations = 0, pcg_iterations = 0;
  std::int64_t active_cells = 0;  // that were solved for; 0: nothing was to be done
  double residual = 0.0, force_scale = 0.0, gap = 0.0, energy = 0.0, minimum_j = 1.0;
  std::int32_t inverted = 0;
  double to_come = 0.0;     // estimate of the largest displacement still to come, mm; of a frame
  std::vector<float> step;  // where it is kept: the displacement still to come, 3 per node, mm
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
