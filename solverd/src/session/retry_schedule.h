// In which order a frame is tried: from the state before in one load step, in 2, 4, ... load steps, and at last from
// rest in the same way. A state before that is not valid to start from is passed over. Halving the load stops where it
// does not help, so that a frame without an equilibrium ends soon.
#pragma once
#include <limits>
#include <optional>

namespace lappet {

struct Attempt {
  bool from_rest = false;
  int load_steps = 1;
};

class RetrySchedule {
 public:
  // before: the state before differs from rest and is valid to start from.
  explicit RetrySchedule(bool before) : next_{Attempt{!before, 1}} {}

  const std::optional<Attempt>& next() const { return next_; }
  // The attempt failed in this of its load steps (from 0), at this relative residual.
  void failed(int load_step, double residual) {
    unimproved_ = load_step > 0 || residual < kHelp * residual_ ? 0 : unimproved_ + 1;
    residual_ = residual;
    if (unimproved_ < kMaxUnimproved && next_->load_steps < kMaxLoadSteps)
      next_->load_steps *= 2;
    else
      give_up();
  }
  // More load steps are of no use.
  void give_up() {
    if (next_->from_rest)
      next_.reset();
    else
      start_over();
  }
  void start_over() {
    next_ = Attempt{true, 1};
    unimproved_ = 0;
    residual_ = std::numeric_limits<double>::infinity();
  }

 private:
  static constexpr int kMaxLoadSteps = 16;
  // A halved first load step that fails at a residual not this much lower did not help; so often in a row.
  static constexpr double kHelp = 0.5;
  static constexpr int kMaxUnimproved = 2;

  std::optional<Attempt> next_;
  double residual_ = std::numeric_limits<double>::infinity();
  int unimproved_ = 0;
};

}  // namespace lappet
