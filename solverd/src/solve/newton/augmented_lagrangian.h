// When the multipliers of what must hold exactly (solve/system/multipliers.h) move on.
//
// While gaps are open the residual need not be below the tolerance: this many tolerances at most, in proportion to the
// gap. Where a gap does not shrink the residual hides it: solve more exactly.
#pragma once
#include <algorithm>
#include <limits>

namespace lappet {

class AugmentedLagrangian {
 public:
  enum class Action { kIterate, kUpdate, kConverged, kGiveUp };

  AugmentedLagrangian(double tolerance, double gap_tolerance) : tolerance_(tolerance), gap_tolerance_(gap_tolerance) {}

  // After an iteration or an update: relative residual, and the largest gap in mm.
  Action next(double residual, double gap) {
    const bool open = gap > gap_tolerance_;
    const double looseness = std::clamp(gap / gap_tolerance_, 1.0, kLooseTolerance);
    // What rounding leaves of the residual cannot be asked to fall further.
    const bool stalled = residual <= tolerance_ && residual > kStall * previous_residual_;
    if (residual > tolerance_ * (open ? strictness_ * looseness : 1.0) && !(open && stalled)) {
      previous_residual_ = residual;
      return Action::kIterate;
    }
    if (!open) return Action::kConverged;
    if (++updates_ > kMaxUpdates) return Action::kGiveUp;
    if (gap > kGapProgress * previous_gap_) strictness_ = std::max(kStricter * strictness_, kStrictest);
    previous_gap_ = gap;
    previous_residual_ = std::numeric_limits<double>::infinity();
    return Action::kUpdate;
  }
  double strictness() const { return strictness_; }
  int updates() const { return updates_; }  // of the multipliers

 private:
  static constexpr int kMaxUpdates = 60;
  static constexpr double kLooseTolerance = 10.0, kGapProgress = 0.7, kStricter = 0.3, kStrictest = 0.02, kStall = 0.5;

  double tolerance_, gap_tolerance_;
  double strictness_ = 1.0;
  double previous_gap_ = std::numeric_limits<double>::infinity(), previous_residual_ = previous_gap_;
  int updates_ = 0;
};

}  // namespace lappet
