// The coarse space of the preconditioner: a rigid frame (three translations, three rotations) at every node of the
// non-manifold lattice coarsened by four, blended with its trilinear weights; Galerkin operator; sparse Cholesky
// (CHOLMOD).
//
// A coarse cell is a connected component of the fine cells in a 4x4x4 box, so a cut stays a cut. Rotations turn about
// the coarse node's place in the state of assembly: delta u_n = sum_k w_nk (t_k + omega_k x (x_n - x_k)).
#pragma once
#include <Eigen/CholmodSupport>
#include <array>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <vector>

#include "solve/system.h"

namespace lappet {

struct NotDefiniteError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

template <class Real>
class RigidFrames {
 public:
  explicit RigidFrames(const Lattice& lattice);

  // Galerkin operator of the system's current tangent at u, and its factor. Throws NotDefiniteError if it cannot be
  // factored even when shifted.
  void assemble(const System<Real>& system, std::span<const Real> u);
  // x = P (P^T K P)^-1 P^T r
  void correct(std::span<const Real> r, std::span<Real> x) const;

  std::size_t unknowns() const { return 6 * coarse_nodes_; }

 private:
  struct Share {  // a fine node's part in a coarse node
    std::int32_t coarse;
    Real weight;
    Real arm[3];  // x_n - x_k over the coarse spacing
  };
  void build_topology(const Lattice& lattice);
  void place_frames(const System<Real>& system, std::span<const Real> u);

  const Lattice& lattice_;
  std::size_t coarse_nodes_ = 0;
  std::vector<std::int32_t> coarse_of_cell_;
  std::vector<std::array<std::int32_t, 8>> coarse_cell_nodes_;
  std::vector<std::array<std::int32_t, 3>> coarse_cell_position_;
  std::vector<std::int32_t> cell_start_, cells_;      // coarse cell -> its fine cells
  std::vector<Share> shares_;                         // 8 per fine node, weight 0 where prescribed
  std::vector<std::int32_t> share_start_, share_of_;  // coarse node -> 8 * fine node + k
  std::vector<Vec3> place_;                           // of coarse nodes
  std::vector<std::uint8_t> free_;                    // per fine node, as of the last assembly
  mutable Eigen::CholmodSupernodalLLT<Eigen::SparseMatrix<double>> factor_;
  mutable Eigen::VectorXd restricted_, solved_;
};

extern template class RigidFrames<float>;
extern template class RigidFrames<double>;

}  // namespace lappet
