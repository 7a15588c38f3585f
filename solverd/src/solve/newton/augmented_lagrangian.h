// When the multipliers of what must hold exactly (solve/system/multipliers.h) move on.
//
// While gaps are open the residual need not be below the tolerance: this many tolerances at most, in proportion to the
// gap. Where a gap does not shrink the residual hides it: solve more exactly. Where it still does not the penalty is
// soft beside what holds the gap open, as where a coarse lattice can hardly tell neighboring sutures apart, or where a
// sliver of a held face bears the tension of a whole cell: a multiplier closes the share k s / (1 + k s) of it at a
// time, k the penalty and s the compliance, and the penalty must grow (Nocedal and Wright 2006, algorithm 17.4).
#pragma once
#include <algorithm>
#include <limits>

namespace lappet {

class AugmentedLagrangian {
 public:
  enum class Action { kIterate, kUpdate, kConverged, kGiveUp };

  AugmentedLagrangian(double tolerance, double gap_tolerance) : tolerance_(tolerance), gap_tolerance_(gap_tolerance) {}

  // After an iteration or an update: relative residual, and the largest gap in mm. but_walls: that of all but the
  // sutures that touching walls keep from closing. Once an update closes little the latter counts.
  Action next(double residual, double gap) { return next(residual, gap, gap); }
  Action next(double residual, double gap, double but_walls) {
    if (walls_) gap = but_walls;
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
    slow_ = gap > kGapProgress * previous_gap_ ? slow_ + 1 : 0;
    if (slow_ > 0 && but_walls <= gap_tolerance_) {
      walls_ = true;
      strictness_ = 1.0;
      previous_residual_ = std::numeric_limits<double>::infinity();
      return residual > tolerance_ ? Action::kIterate : Action::kConverged;
    }
    if (slow_ > 0) strictness_ = std::max(kStricter * strictness_, kStrictest);
    rate_ = gap / previous_gap_;
    previous_gap_ = gap;
    previous_residual_ = std::numeric_limits<double>::infinity();
    return Action::kUpdate;
  }
  // After an update: by how much the penalty of what keeps the largest gap is to grow, 1 where it is to stay.
  double stiffening() {
    if (slow_ < kSlowUpdates || previous_gap_ > kNearlyClosed * gap_tolerance_) return 1.0;
    const double wanted = kWantedStiffness * rate_ / std::max(1.0 - rate_, 1e-6);
    const double factor = std::max(std::min(wanted, kMaxStiffening / stiffened_), 1.0);
    stiffened_ *= factor;
    slow_ = 0;
    return factor;
  }
  double strictness() const { return strictness_; }
  int updates() const { return updates_; }  // of the multipliers

 private:
  static constexpr int kMaxUpdates = 60;
  static constexpr double kLooseTolerance = 10.0, kGapProgress = 0.7, kStricter = 0.3, kStrictest = 0.02, kStall = 0.5;
  static constexpr int kSlowUpdates = 2;  // in a row
  // Gap tolerances up to which the penalty grows; what stays open further asks for what the tissue cannot bear.
  static constexpr double kNearlyClosed = 100.0;
  // k s after the penalty has grown, so that a multiplier closes nine tenths of a gap; and how much it grows in all.
  static constexpr double kWantedStiffness = 9.0, kMaxStiffening = 100.0;

  double tolerance_, gap_tolerance_;
  double strictness_ = 1.0;
  double previous_gap_ = std::numeric_limits<double>::infinity(), previous_residual_ = previous_gap_;
  bool walls_ = false;          // only walls are in the way of the rest
  int updates_ = 0, slow_ = 0;  // in all; that closed little of the gap, in a row
  double rate_ = 0.0;           // share of the gap that the last one left
  double stiffened_ = 1.0;
};

}  // namespace lappet
