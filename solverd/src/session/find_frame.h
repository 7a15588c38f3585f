// The equilibrium of a frame, tried from the state before and from rest (retry_schedule.h).
#pragma once
#include <atomic>

#include "session/epoch_system.h"
#include "solve/newton/equilibrium.h"

namespace lappet {

template <class Real>
struct FoundFrame {
  EquilibriumOutcome outcome;  // its evaluation is the last of the epoch's system
  TissueState<Real> state;     // where the search ended, an equilibrium or not
  SolveEffort effort;          // of all attempts
  // Of the surface, where the last attempt began, and how many of them were taken apart (force/self_contact).
  std::size_t piercings_before = 0, untangled = 0;
};

// before: the state of the frame before; known: where the search for it ended, if it was the same frame. Throws
// RefusedError(kCancelled) or (kTimeBudget).
template <class Real>
FoundFrame<Real> find_frame(const SessionSettings& settings, EpochSystem<Real>& epoch, const TissueState<Real>& before,
                            const FrameInput& frame, const std::optional<Arrival>& known,
                            const ProgressCallback& progress, const std::atomic<bool>& cancel);

}  // namespace lappet
