// What the surface pushes itself with, for the coarse level. A row per pair would be far too many constraints there:
// the pairs between two coarse cells become three rows, which have what of their stiffness is felt by a push and by two
// tilts of the one against the other. Of rows R these are Q^T R with orthonormal columns Q, so R^T Q Q^T R is never
// more than the R^T R that it stands for.
#pragma once
#include <Eigen/Core>
#include <map>
#include <span>
#include <vector>

#include "force/self_contact/self_contact.h"

namespace lappet {

// Per node of the lattice: the three rows' factors, sqrt(mN/mm).
using ContactGroup = std::map<Index, Eigen::Matrix3d>;

// coarse_of: per cell of the lattice its coarse cell. In order of the coarse cells.
std::vector<ContactGroup> group_contacts(const SparseRows& rows, std::span<const SelfContact::Place> places,
                                         std::span<const Index> coarse_of);

}  // namespace lappet
