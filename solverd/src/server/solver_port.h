// What the server needs of a session, so that the server can be tested without solving anything.
#pragma once
#include <atomic>
#include <functional>
#include <memory>

#include "session/program.h"

namespace lappet {

class SolverPort {
 public:
  virtual ~SolverPort() = default;
  virtual EpochReport set_epoch(const EpochInput& epoch, const std::atomic<bool>& cancel) = 0;
  virtual void set_state(const SolverState& state) = 0;
  virtual FrameOutput solve(const FrameInput& frame, const ProgressCallback& progress,
                            const std::atomic<bool>& cancel) = 0;
};

// Makes the session of one `open`; throws RefusedError where a setting makes no sense. Called on worker threads.
using SolverFactory = std::function<std::unique_ptr<SolverPort>(const SessionSettings&)>;

}  // namespace lappet
