// The two-level preconditioner: Chebyshev smoothing before and after a correction by rigid frames. Symmetric, so that
// conjugate gradients may use it.
#pragma once
#include <vector>

#include "solve/rigid_frames.h"
#include "solve/smoother.h"
#include "solve/vectors.h"

namespace lappet {

template <class Real>
class TwoLevel {
 public:
  TwoLevel(const System<Real>& system, int degree)
      : system_(system), smoother_(system, degree), frames_(system.lattice()) {}

  // Takes the current tangent. The coarse operator is assembled anew only where the constraints changed or where the
  // last solve took many more iterations than the first with it.
  void update(std::span<const Real> u) {
    smoother_.update();
    if (stale_ || system_.constraint_revision() != revision_) {
      frames_.assemble(system_, u);
      revision_ = system_.constraint_revision();
      stale_ = false;
      first_iterations_ = 0;
    }
    for (auto* v : {&residual_, &correction_}) v->resize(3 * system_.nodes());
  }
  // Tells how many iterations a linear solve took to reduce the residual tenfold.
  void observe(double iterations_per_digit) {
    if (first_iterations_ == 0)
      first_iterations_ = std::max(iterations_per_digit, 2.0);
    else
      stale_ = stale_ || iterations_per_digit > 1.6 * first_iterations_;
  }
  // Starts afresh, so that what follows depends on the state alone and a resumed solve repeats it bit for bit.
  void restart() {
    stale_ = true;
    smoother_.restart();
  }

  void apply(std::span<const Real> b, std::span<Real> x) const {
    smoother_.apply(b, x);
    defect(b, x);
    frames_.correct(residual_, correction_);
    add<Real>(Real(1), correction_, x);
    defect(b, x);
    smoother_.apply(residual_, correction_);
    add<Real>(Real(1), correction_, x);
  }

 private:
  void defect(std::span<const Real> b, std::span<const Real> x) const {
    system_.multiply(x, residual_);
    combine<Real>(Real(-1), Real(1), b, residual_);
  }

  const System<Real>& system_;
  Smoother<Real> smoother_;
  RigidFrames<Real> frames_;
  bool stale_ = true;
  double first_iterations_ = 0.0;
  std::uint64_t revision_ = 0;
  mutable std::vector<Real> residual_, correction_;
};

}  // namespace lappet
