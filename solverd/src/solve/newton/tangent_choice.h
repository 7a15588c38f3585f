// Which tangent a Newton iteration uses. The exact one converges quadratically also beyond a buckling load; a definite
// one is the way out where it has directions of negative curvature. Eigenvalues are clamped while the energy falls as
// the quadratic model predicts, and replaced by their magnitudes where it does not (Chen et al. 2024).
#pragma once
#include <algorithm>
#include <cmath>

#include "force/materials/material.h"

namespace lappet {

class TangentChoice {
 public:
  PsdProjection next() const { return exact_pause_ == 0 ? PsdProjection::kExact : fallback_; }
  // The exact tangent was indefinite: what to use instead, now and for some iterations.
  PsdProjection replace_exact() {
    exact_pause_ = kIndefinitePause + 1;
    return fallback_;
  }
  // After a jump the model is bad: clamped modes would take steps that the line search cuts to nothing.
  void jumped() { fallback_ = PsdProjection::kAbsolute; }
  void iteration_done() { exact_pause_ = std::max(0, exact_pause_ - 1); }
  // ratio: actual to predicted decrease of the energy in a step with the tangent `used`, of which the share `alpha` was
  // taken. Where that is next to nothing the exact one is all but singular, and what it says is of no use.
  void agreed(double alpha, double ratio, PsdProjection used) {
    if (used == PsdProjection::kExact && alpha < kMinShare) exact_pause_ = kIndefinitePause;
    if (used != PsdProjection::kExact)
      fallback_ = std::abs(ratio - 1.0) > kModelAgreement ? PsdProjection::kAbsolute : PsdProjection::kClamp;
  }
  // No step along the direction of `used` lowers the energy; false if no other tangent is left to try.
  bool try_another(PsdProjection used) {
    fallback_ = PsdProjection::kAbsolute;
    exact_pause_ = kIndefinitePause;
    return used != PsdProjection::kAbsolute;
  }

 private:
  static constexpr double kModelAgreement = 0.01;
  static constexpr double kMinShare = 0.01;
  static constexpr int kIndefinitePause = 3;  // iterations before the exact tangent is tried again

  PsdProjection fallback_ = PsdProjection::kClamp;
  int exact_pause_ = 0;
};

}  // namespace lappet
