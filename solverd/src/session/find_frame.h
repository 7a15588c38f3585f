// The equilibrium of a frame, tried from the state before and from rest (retry_schedule.h).
#pragma once
#include <atomic>
#include <limits>

#include "session/epoch_system.h"
#include "solve/newton/equilibrium.h"

namespace lappet {

template <class Real>
struct FoundFrame {
  EquilibriumOutcome outcome;  // its evaluation is the last of the epoch's system
  TissueState<Real> state;     // where the search ended, an equilibrium or not
  SolveEffort effort;          // of all attempts
  // As in FrameFields; the mode itself is the epoch's.
  double lowest_stiffness = std::numeric_limits<double>::quiet_NaN();
  int saddles_left = 0;
};

// before: the state of the frame before. repeats: the frame before asked for the same, and its stability is known.
// Throws RefusedError(kCancelled) or (kTimeBudget).
template <class Real>
FoundFrame<Real> find_frame(const SessionSettings& settings, EpochSystem<Real>& epoch, const TissueState<Real>& before,
                            const FrameInput& frame, bool repeats, const ProgressCallback& progress,
                            const std::atomic<bool>& cancel);

}  // namespace lappet
