// Chebyshev iteration on a block-Jacobi splitting D of the tangent: 3x3 blocks per node; the nodes that ties couple
// form one sparse block that is solved exactly, so that stiff sutures cost no iterations.
#pragma once
#include <Eigen/SparseCholesky>
#include <memory>
#include <span>
#include <vector>

#include "solve/system.h"

namespace lappet {

template <class Real>
class Smoother {
 public:
  Smoother(const System<Real>& system, int degree) : system_(system), degree_(degree) {}

  // Takes the system's current tangent.
  void update();
  void restart() { eigenvector_.clear(); }
  // x = p(D^-1 K) D^-1 b from a zero start; symmetric in b.
  void apply(std::span<const Real> b, std::span<Real> x) const;
  double largest_eigenvalue() const { return largest_; }

 private:
  void divide(std::span<const Real> r, std::span<Real> z) const;  // z = D^-1 r
  void factor_tied_nodes();
  void estimate_largest_eigenvalue();

  const System<Real>& system_;
  int degree_;
  double largest_ = 0.0;
  std::vector<Real> inverse_blocks_;  // 9 per node; zero at prescribed and tied nodes
  std::vector<std::int32_t> tied_nodes_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> tied_;
  std::vector<Real> eigenvector_;
  mutable std::vector<Real> residual_, direction_, divided_, product_;
};

extern template class Smoother<float>;
extern template class Smoother<double>;

}  // namespace lappet
