// The fine level's smoother: Chebyshev on 3x3 block-Jacobi of the system's tangent, with the constraints exact.
#pragma once
#include <vector>

#include "solve/multigrid/chebyshev.h"
#include "solve/system/system.h"

namespace lappet {

template <class Real>
class Smoother {
 public:
  Smoother(const System<Real>& system, int degree) : system_(system), chebyshev_(degree, kRange) {}

  // Takes the system's current tangent.
  void update();
  void before(std::span<const Real> b, std::span<Real> x) { chebyshev_.before(product_, b, x); }
  void after(std::span<Real> x) {
    product_(chebyshev_.correction(), chebyshev_.product());
    chebyshev_.after(product_, x);
  }
  std::span<Real> residual() { return chebyshev_.residual(); }
  std::span<Real> product() { return chebyshev_.product(); }
  std::span<Real> correction() { return chebyshev_.correction(); }
  static constexpr double kMaxEigenvalue = Chebyshev<Real, 3>::kMaxEigenvalue;
  std::size_t bytes() const { return chebyshev_.bytes(); }

 private:
  static constexpr double kRange = 4.0;

  void add_self_contact(std::span<Real> blocks) const;

  const System<Real>& system_;
  Chebyshev<Real, 3> chebyshev_;
  struct Product {
    const System<Real>& system;
    void operator()(std::span<const Real> x, std::span<Real> y) const { system.multiply(x, y); }
  } product_{system_};
};

extern template class Smoother<float>;
extern template class Smoother<double>;

}  // namespace lappet
