// The coarse space of the preconditioner: a rigid mode (three translations, three rotations) at every node of the
// non-manifold lattice coarsened by four, blended with its trilinear weights; Galerkin operator, inverted on its level
// (see coarse_level.h).
//
// Rotations turn about the coarse node's place in the state of assembly: delta u_n = sum_k w_nk (t_k + omega_k x (x_n -
// x_k)). With arms from the center of a node's coarse cell that is (sum_k w t'_k) + (sum_k w omega_k) x a_n with t'_k =
// t_k - omega_k x a_k: 24 bytes a fine node, weights from a table.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "solve/multigrid/coarse_lattice.h"
#include "solve/multigrid/coarse_level.h"
#include "solve/system/system.h"

namespace lappet {

// Unknowns of a level that are still factored directly: beyond, a further level costs fewer seconds than the factor,
// though up to a quarter more iterations.
inline constexpr std::size_t kMaxDirect = 10000;

template <class Real>
class RigidModes {
 public:
  explicit RigidModes(const Lattice& lattice, std::size_t max_direct = kMaxDirect);

  // Galerkin operator of the system's current tangent at u, and its inverse. Throws NotDefiniteError if it cannot be
  // factored even when shifted.
  void assemble(const System<Real>& system, std::span<const Real> u);
  // r -= product; x = P (P^T K P)^-1 P^T r
  void correct(std::span<const Real> product, std::span<Real> r, std::span<Real> x);
  // x = P q for six numbers a coarse node
  void prolong(std::span<const Real> q, std::span<Real> x) const;

  std::size_t unknowns() const { return 6 * coarse_.nodes; }
  std::size_t levels() const { return level_.levels(); }
  // Symbolic analyses so far.
  std::size_t analyses() const { return level_.analyses(); }
  CoarseLevel<Real>& level() { return level_; }
  const CoarseLattice& coarse_lattice() const { return coarse_; }
  std::size_t bytes() const;

 private:
  void place_modes(const System<Real>& system, std::span<const Real> u);
  void assemble_cells(const System<Real>& system, std::span<const Real> u);
  void project_cells(const System<Real>& system, std::span<const Real> u, std::size_t coarse, Real* blocks) const;
  void project_penalty(const System<Real>& system, std::span<const Real> u, std::size_t coarse,
                       const ContactPenalty& penalty, Real* blocks) const;
  void shift_to_corners(std::size_t coarse, Real* blocks) const;
  void assemble_constraints(const System<Real>& system);
  void assemble_self_contact(const System<Real>& system);
  // weight: a number, or a matrix that takes the node's displacement to what is held.
  template <class Weight>
  void add_rows(Index node, const Weight& weight, ConstraintRows& rows) const;

  const Lattice& lattice_;
  CoarseLattice coarse_;
  CoarseLevel<Real> level_;
  std::vector<std::array<Real, 8>> weights_;  // by local position; one more for prescribed nodes: zero
  std::vector<std::uint8_t> weight_of_;       // per slot
  std::vector<Real> arm_;                     // 3 per slot, from the center of the coarse cell, over its spacing
  std::vector<Real> corner_arm_;              // 24 per coarse cell
  std::vector<Vec3> place_, center_;          // of coarse nodes, of coarse cells
  std::vector<Real> partial_;                 // 48 per coarse cell
  std::vector<Real> restricted_, solved_;
};

extern template class RigidModes<float>;
extern template class RigidModes<double>;

}  // namespace lappet
