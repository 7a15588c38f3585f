// Whether work is still wanted. What takes long checks it every few milliseconds.
#pragma once
#include <atomic>
#include <chrono>
#include <optional>

#include "lattice/refused.h"

namespace lappet {

class Interrupt {
 public:
  Interrupt() = default;  // never
  // Ends work when another thread sets `cancel`, or after so many seconds (0: whenever). Keeps a reference.
  Interrupt(const std::atomic<bool>& cancel, double seconds) : cancel_(&cancel), seconds_(seconds) {
    if (seconds > 0.0) end_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(Seconds(seconds));
  }

  // Throws RefusedError(kCancelled) or (kTimeBudget) where it is not. From any thread.
  void check() const {
    if (cancel_ && cancel_->load(std::memory_order_relaxed))
      throw RefusedError(ErrorCode::kCancelled, "The epoch was cancelled.");
    if (end_ && Clock::now() > *end_)
      throw RefusedError(ErrorCode::kTimeBudget, "The epoch took longer than " + shown(seconds_) +
                                                     " s; use a larger spacing or raise the time budget.");
  }

 private:
  using Clock = std::chrono::steady_clock;
  using Seconds = std::chrono::duration<double>;
  const std::atomic<bool>* cancel_ = nullptr;
  double seconds_ = 0.0;
  std::optional<Clock::time_point> end_;
};

}  // namespace lappet
