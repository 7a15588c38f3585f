// The neighborhood of a frame's changes is solved first, on its own, while all other tissue stays where it is.
//
// On an elastic bed a displacement decays with the distance d from its cause as exp(-d / l), l^2 = E t / k with the
// modulus E, the thickness t and the bed's stiffness k. So what is displaced already, what has no bed to hold it, what
// point constraints or retractors hold and what is out of equilibrium, with some l around it, is a Subdomain that is
// solved alone, its multipliers with it. The result is verified: the search for the equilibrium of everything goes
// on from there, and ends at once only where the residual of the whole, with the reactions of what stayed, is within
// the tolerance, and what the reactions at the rim would displace is little. A line load q on a sheet on a bed
// displaces it by q / (2 k l).
//
// The neighborhood follows from the frame and the state before it alone, so that a resumed solve repeats it bit for
// bit.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "solve/multigrid/coarse_lattice.h"
#include "solve/newton/equilibrium.h"

namespace lappet {

struct NeighborhoodOutcome : EquilibriumOutcome {
  std::vector<std::uint8_t> moved;  // per node: whether it could
  // Of the tissue that stayed: what a node gives way by to a force on it and its like along the rim, mm/mN.
  double rim_compliance = 0.0;
};

// u: 3 per node, moved in place with the multipliers where the outcome is converged, and must be evaluated anew then;
// now: the evaluation at u. tiles: the lattice coarsened; the neighborhood is made of them. Does
// nothing where the neighborhood is a large part of the tissue, without an attached bed, with bones, and where tissue
// touches tissue; it knows nothing of tissue that would come to touch on the way, which is for the caller to see.
template <class Real>
NeighborhoodOutcome solve_change_neighborhood(const System<Real>& system, const CoarseLattice& tiles, std::span<Real> u,
                                              Multipliers& multipliers, const Evaluation& now,
                                              const EquilibriumOptions& options, const SolveObserver& observer);

}  // namespace lappet
