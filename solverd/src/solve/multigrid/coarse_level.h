// A level of rigid modes: its Galerkin operator, and the (approximate) inverse of it. Up to kMaxDirect unknowns that
// is a sparse Cholesky; beyond, a cycle of Chebyshev smoothing around a correction by the rigid modes of the lattice
// coarsened once more, six unknowns on six:
//   t_i = sum_K w_iK (t_K + omega_K x a_iK),   omega_i = sum_K w_iK omega_K / ratio,
// a_iK = (x_i - x_K) over the coarser spacing, rotations in units of one over each level's spacing.
#pragma once
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "lattice/surface.h"
#include "solve/multigrid/chebyshev.h"
#include "solve/multigrid/coarse_cholesky.h"
#include "solve/multigrid/coarse_matrix.h"

namespace lappet {

template <std::size_t kRows>
struct CornerCoupling;

template <class Real>
class CoarseLevel {
 public:
  // Keeps a reference to the lattice, whose nodes carry the rigid modes.
  CoarseLevel(const CoarseLattice& lattice, std::size_t max_direct);

  CoarseMatrix<Real>& matrix() { return matrix_; }
  std::vector<CoarseConstraint>& constraints() { return constraints_; }
  // Makes room before matrix() is filled anew: the inverse is gone until prepare.
  void release();
  // Takes matrix(), whose numbers may go where they are not needed further, and constraints(); places of the nodes, mm,
  // and the spacing of this level. Throws NotDefiniteError.
  void prepare(std::span<const Vec3> places, double spacing);
  // x = an approximate inverse of the operator times b, symmetric positive (semi)definite; six numbers a node.
  void solve(std::span<const Real> b, std::span<Real> x);
  std::size_t levels() const { return next_ ? 1 + next_->levels() : 1; }
  std::size_t analyses() const { return next_ ? next_->analyses() : direct_->analyses(); }
  std::size_t bytes() const;

 private:
  using Block = Eigen::Matrix<double, 6, 6>;
  void place_next(std::span<const Vec3> places, double spacing);
  void assemble_next();
  // The couplings of the node of a slot, or of the corners of a coarse cell, with corners of coarse cells; cell_of: the
  // coarse cell of each node.
  void couple_node(std::size_t slot, std::span<const Index> cell_of, std::vector<CornerCoupling<1>>& row) const;
  void couple_cell(std::size_t c, std::span<const Index> cell_of, std::vector<CornerCoupling<8>>& list) const;
  void project_constraints();
  void set_diagonal();
  void multiply(std::span<const Real> x, std::span<Real> y) const;
  // b of the next level from residual - product, which it stores as the residual.
  void restrict_residual();
  void prolong();
  const std::array<double, 8>& weight_of(std::size_t slot) const { return weights_[coarse_->weight_index(slot)]; }
  Block transfer_of(std::size_t slot) const;                   // of a node, from the center of its coarse cell
  Block shift_of(std::size_t cell, std::size_t corner) const;  // of that center, from a corner

  const CoarseLattice& lattice_;
  CoarseMatrix<Real> matrix_;
  std::vector<CoarseConstraint> constraints_;
  std::optional<CoarseCholesky> direct_;

  std::unique_ptr<CoarseLattice> coarse_;
  std::unique_ptr<CoarseLevel> next_;
  Chebyshev<Real, 6> chebyshev_;
  std::vector<std::array<double, 8>> weights_;
  std::vector<Vec3> next_place_, arm_, corner_arm_;   // of coarse nodes; per slot; 8 per coarse cell
  std::vector<Eigen::Matrix<double, 6, 1>> partial_;  // 8 per coarse cell
  std::vector<Index> constrained_nodes_;
  std::vector<Real> next_b_, next_x_;
};

extern template class CoarseLevel<float>;
extern template class CoarseLevel<double>;

}  // namespace lappet
