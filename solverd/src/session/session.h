// A session: one procedure being solved. Takes epochs and frames in order and finds each frame's equilibrium from the
// one before. Not thread-safe: one worker owns it; `cancel` may be set from any thread.
#pragma once
#include <atomic>
#include <memory>

#include "session/program.h"

namespace lappet {

inline const std::atomic<bool> kNotCancelled{false};

class Session {
 public:
  class Implementation;  // by precision, see session.cpp

  // Throws RefusedError where a setting makes no sense (names it, its value and the remedy).
  explicit Session(const SessionSettings& settings);
  ~Session();
  Session(Session&&) noexcept;

  // Installs an epoch. If there was one before, its state is carried over by rest position. Where it throws the epoch
  // before and its state stay; also RefusedError(kCancelled) and, after ten time budgets, (kTimeBudget).
  EpochReport set_epoch(const EpochInput& epoch, const std::atomic<bool>& cancel = kNotCancelled);
  // Replaces the state of the current epoch by one that an earlier solve returned. Throws if its sizes do not fit.
  void set_state(const SolverState& state);
  // Finds the equilibrium. Throws RefusedError(kCancelled) or (kTimeBudget) and keeps the state before; an unconverged
  // frame is returned with converged = false and also keeps the state before.
  FrameOutput solve(const FrameInput& frame, const ProgressCallback& progress, const std::atomic<bool>& cancel);

 private:
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace lappet
