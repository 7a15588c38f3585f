// In which order a frame is tried: from the state before in one load step, in 2, 4, ... load steps, and at last from
// rest in the same way. A state before that is not valid to start from is passed over. Halving the load stops where it
// does not help, and all attempts together have a budget of iterations: a frame without an equilibrium ends soon. An
// attempt that gets further along the load than any before adds to the budget, and one that runs out of iterations
// close to an equilibrium, or where there is no load to halve, goes on. Where tissue does not pass through tissue the
// state before is never passed over for rest: from there the way to the frame leads through tissue.
#pragma once
#include <algorithm>
#include <limits>
#include <optional>

namespace lappet {

struct Attempt {
  bool from_rest = false;
  int load_steps = 1;
  bool goes_on = false;  // from where the last load step ran out of iterations
};

class RetrySchedule {
 public:
  // before: the state before differs from rest and is valid to start from. max_newton: iterations of one load step.
  // self_contact: tissue does not pass through tissue.
  // least, least_from_rest: load steps of the first attempt from the state before, and from rest.
  RetrySchedule(bool before, int max_newton, bool self_contact = false, int least = 1, int least_from_rest = 1)
      : keeps_before_(before && self_contact),
        max_newton_(std::min(max_newton, kMaxNewton)),
        least_from_rest_(least_from_rest),
        max_load_steps_(std::max(kMaxLoadSteps, kMaxHalvings * std::max(least, least_from_rest))),
        budget_(kNewtonBudget * max_newton_ * (before ? least : least_from_rest)),
        next_{Attempt{!before, before ? least : least_from_rest}} {}

  const std::optional<Attempt>& next() const { return next_; }
  // Newton iterations that a load step may take once the frame has taken `used`.
  int newton_left(int used) const { return std::min(max_newton_, budget_ - used); }
  // The attempt failed in this of its load steps (from 0), at this relative residual; the frame has taken `used`
  // iterations. goes_on: it ran out of iterations in its last load step, and is to go on from there.
  void failed(int load_step, double residual, int used, bool goes_on = false) {
    const double reached = static_cast<double>(load_step) / next_->load_steps;
    if (next_->load_steps > 1 && reached > furthest_) {
      budget_ += max_newton_;
      furthest_ = reached;
    }
    if (used >= budget_) return give_up(used);
    next_->goes_on = goes_on;
    if (goes_on) return;
    unimproved_ = load_step > 0 || residual < kHelp * residual_ ? 0 : unimproved_ + 1;
    residual_ = residual;
    if (unimproved_ < kMaxUnimproved && next_->load_steps < max_load_steps_)
      next_->load_steps *= 2;
    else
      give_up(used);
  }
  void start_over(int used) {
    next_ = Attempt{true, least_from_rest_};
    unimproved_ = 0;
    furthest_ = 0.0;
    residual_ = std::numeric_limits<double>::infinity();
    budget_ = used + kNewtonBudget * max_newton_ * least_from_rest_ / 2;
  }

 private:
  static constexpr int kMaxLoadSteps = 16;
  static constexpr int kMaxHalvings = 4;        // of the load steps that moving bones ask for, as a factor
  static constexpr int kMaxNewton = 1'000'000;  // as good as no limit, and its sums are far from an int's end
  // A halved first load step that fails at a residual not this much lower did not help; so often in a row.
  static constexpr double kHelp = 0.5;
  static constexpr int kMaxUnimproved = 2;
  // All attempts from the state before together may take this many times max_newton iterations, those from rest half.
  static constexpr int kNewtonBudget = 4;

  // More load steps are of no use.
  void give_up(int used) {
    if (next_->from_rest || keeps_before_)
      next_.reset();
    else
      start_over(used);
  }

  bool keeps_before_;
  int max_newton_, least_from_rest_, max_load_steps_, budget_;
  std::optional<Attempt> next_;
  double residual_ = std::numeric_limits<double>::infinity();
  double furthest_ = 0.0;  // share of the load
  int unimproved_ = 0;
};

}  // namespace lappet
