// The region that a frame's changes reach goes to its own equilibrium first, while all other tissue stays where it is.
//
// Tissue on a bed forgets: a displacement falls off from where it is caused as exp(-d / l), l^2 = E t / k with the
// modulus E, the thickness t and the bed's stiffness k. So what is displaced already, what has no bed to hold it, what
// ties or retractors hold and what is out of equilibrium, with some l around it, is a Part that is solved alone, its
// multipliers with it. Nothing is taken on trust: the search for the equilibrium of everything goes on from there, and
// ends at once only where the residual of the whole, with the reactions of what stayed, is within the tolerance.
//
// The region follows from the frame and the state before it alone, so that a resumed solve repeats it bit for bit.
#pragma once
#include <span>

#include "solve/multigrid/coarse_lattice.h"
#include "solve/newton/equilibrium.h"

namespace lappet {

// u: 3 per node, moved in place with the system's multipliers where the outcome is converged, and u must be evaluated
// anew then; the system holds the gradient at u. tiles: the lattice coarsened; the region is made of them. Does nothing
// where the region is a large part of the tissue, without an attached bed, and with bones.
template <class Real>
EquilibriumOutcome solve_region(System<Real>& system, const CoarseLattice& tiles, std::span<Real> u,
                                const EquilibriumOptions& options, const EquilibriumWatch& watcher);

}  // namespace lappet
