// What a solve changes, and all that the next one starts from.
#pragma once
#include <algorithm>
#include <vector>

#include "session/program.h"
#include "solve/system/multipliers.h"

namespace lappet {

template <class Real>
struct TissueState {
  std::vector<Real> u;              // displacements, 3 per node, mm
  std::vector<double> suture_gaps;  // as in SolverState
  Multipliers multipliers;
  std::vector<double> activation;  // of the muscles, per material

  void return_to_rest() {
    std::ranges::fill(u, Real(0));
    multipliers = {};
  }
};

// Of a session without an epoch.
template <class Real>
TissueState<Real> initial_state(const SessionSettings& settings);

// The state of an epoch, carried by rest position from the lattice before it (null: there is none, it is at rest).
template <class Real>
TissueState<Real> carry_over(const TissueState<Real>& state, const Lattice* from, const Lattice& to);

template <class Real>
SolverState exported(const TissueState<Real>& state);
template <class Real>
TissueState<Real> imported(const SolverState& state);

}  // namespace lappet
