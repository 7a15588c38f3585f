// The two-level preconditioner: Chebyshev smoothing before and after a correction by rigid modes. Symmetric, so that
// conjugate gradients may use it. With degree d an application takes 2 d products.
#pragma once
#include <algorithm>

#include "solve/multigrid/rigid_modes.h"
#include "solve/multigrid/smoother.h"

namespace lappet {

template <class Real>
class TwoLevel {
 public:
  TwoLevel(const System<Real>& system, int degree, std::size_t max_direct = kMaxDirect)
      : system_(system), smoother_(system, degree), modes_(system.lattice(), max_direct) {}

  // Leaves the rigid modes out from now on: the smoother alone, to compare with.
  void smoother_only() { smoother_only_ = true; }
  bool is_smoother_only() const { return smoother_only_; }

  // Takes the current tangent. The coarse operator is assembled anew only where the constraints changed or where the
  // last solve took many more iterations than the first with it.
  void update(std::span<const Real> u) {
    stale_ = stale_ || slow_;
    refresh(u);
  }
  // The same for few applications: the coarse operator stays, however slow, unless there is none for the constraints.
  void refresh(std::span<const Real> u) {
    smoother_.update();
    if (smoother_only_) return;
    if (stale_ || system_.constraint_revision() != revision_) {
      modes_.assemble(system_, u);
      ++assemblies_;
      revision_ = system_.constraint_revision();
      stale_ = slow_ = false;
      first_iterations_ = 0;
    }
  }
  // Takes how many iterations a linear solve needed to reduce the residual tenfold.
  void observe(double iterations_per_digit) {
    if (first_iterations_ == 0)
      first_iterations_ = std::max(iterations_per_digit, 2.0);
    else
      slow_ = slow_ || iterations_per_digit > 1.6 * first_iterations_;
  }
  // Starts afresh, so that what follows depends on the state alone and a resumed solve repeats it bit for bit.
  void restart() { stale_ = true; }

  void apply(std::span<const Real> b, std::span<Real> x) {
    smoother_.before(b, x);
    if (smoother_only_)
      std::ranges::fill(smoother_.correction(), Real(0));
    else
      modes_.correct(smoother_.product(), smoother_.residual(), smoother_.correction());
    smoother_.after(x);
  }
  RigidModes<Real>& modes() { return modes_; }
  Smoother<Real>& smoother() { return smoother_; }
  std::size_t assemblies() const { return assemblies_; }  // of the coarse operator, so far
  std::size_t bytes() const { return smoother_.bytes() + modes_.bytes(); }

 private:
  const System<Real>& system_;
  Smoother<Real> smoother_;
  RigidModes<Real> modes_;
  bool stale_ = true, slow_ = false, smoother_only_ = false;
  double first_iterations_ = 0.0;
  std::uint64_t revision_ = 0;
  std::size_t assemblies_ = 0;
};

}  // namespace lappet
