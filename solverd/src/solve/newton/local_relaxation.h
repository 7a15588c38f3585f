// Local relaxation (nonlinear elimination: Lanzkron, Rose, Wilkes 1996; Cai, Li 2011). Where compressed tissue creases
// or snaps through, a few nodes have several spacings to go, and cells bear only a part of a spacing in one step: the
// whole would take one short step after the other for them, the more the finer the lattice. Instead they, and what is
// around them, go to their own equilibrium while the rest stays still, and then the whole takes its next step.
//
// What moves falls into clusters that no cell, no point constraint and nothing that touches joins; each is a subdomain,
// a system of its own. The energy of the whole falls by what theirs fall: this is a descent like any other step.
// Multipliers stay. Clusters know what they touch, and their ways are clear of it; where tissue rubs on tissue they
// know nothing of it, and whether the way there is clear is for the caller to see.
#pragma once
#include <functional>
#include <span>

#include "solve/system/system.h"

namespace lappet {

struct LocalRelaxation {
  int clusters = 0, newton_iterations = 0;  // that moved, and theirs together
  std::size_t nodes = 0;                    // that moved; 0: the residual is not a matter of a few nodes
};

// u: 3 per node, moved in place; now: the evaluation at u, which must be evaluated anew where nodes moved. tolerance:
// what the search is after, relative to the force scale. inverts: the material describes J < 0.
template <class Real>
LocalRelaxation relax_locally(const System<Real>& system, std::span<Real> u, const Multipliers& multipliers,
                              const Evaluation& now, double tolerance, bool inverts, const std::function<bool()>& stop);

}  // namespace lappet
