// The displacement that an equilibrium resists least, and whether it resists it at all.
//
// K is the exact tangent, C the same with the negative eigenvalues of every point clamped (PsdProjection::kClamp): the
// stiffness that the tissue would have if nothing in it were compressed. Looked for is, over v on free nodes,
//   min (v . K v) / (v . C v):
// the share of its stiffness that compression leaves that mode. It has no unit and does not depend on the lattice: 1
// where nothing is compressed, 1 - load / buckling load for a column (linear buckling analysis), 0 where the
// equilibrium is neutral, negative at a saddle of the energy, in which no tissue rests.
//
// With N = C - K, positive semidefinite and zero but in compressed cells, it is 1 - the largest eigenvalue of
// N v = m C v, found by preconditioned steepest ascent of the quotient: each step is one application of the two-level
// preconditioner and a Rayleigh-Ritz problem of two vectors (Knyazev, SIAM J. Sci. Comput. 23, 2001, sec. 4). Since
// compression is a small part of the stiffness the other eigenvalues gather at 0, and a few steps do. What is found is
// a Rayleigh quotient: the true share is never larger, so a negative one is proof, however few the steps.
#pragma once
#include <span>
#include <vector>

#include "solve/multigrid/two_level.h"

namespace lappet {

template <class Real>
struct LowestMode {
  double stiffness = 1.0;  // the share that is left
  // 3 per node, the largest component 1, zero where prescribed; empty: nothing is compressed
  std::vector<Real> shape;
  int steps = 0;  // applications of the preconditioner
};

struct LowestModeSearch {
  // The search ends where a step changes the share by less than the tolerance, and before that where further steps are
  // not expected to bring it below `soft`.
  double soft = 0.2, tolerance = 0.01;
  int max_steps = 8;

  // To the end, for a mode that is to be moved along.
  static LowestModeSearch thorough() { return {.soft = 1.0, .tolerance = 1e-3, .max_steps = 16}; }
};

// At the last evaluation `at` of the system, at u. The start is noise, the same one always. Leaves the system
// linearized there, exactly or clamped, and the preconditioner updated. Throws NotDefiniteError where that cannot be.
template <class Real>
LowestMode<Real> find_lowest_mode(System<Real>& system, TwoLevel<Real>& preconditioner, std::span<const Real> u,
                                  const Evaluation& at, const LowestModeSearch& search);

}  // namespace lappet
