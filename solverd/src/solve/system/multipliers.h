// The multipliers of the augmented Lagrangian, all of them in one value. It belongs to whoever holds the displacements:
// a solve moves both on together, and nothing else keeps a multiplier.
#pragma once
#include <map>
#include <vector>

#include "force/constraints/point_constraint.h"

namespace lappet {

struct Multipliers {
  std::map<ConstraintId, Vec3> of_constraint;  // mN; what is left out is zero
  std::vector<double> of_held_node;            // 3 per node, kPa; empty where no face is held off the lattice planes
  std::vector<double> of_contact_proxy;        // kPa; empty while all are zero
  std::vector<double> of_roller_row;           // mN; empty without rollers

  Vec3 of(const PointConstraint& constraint) const {
    const auto found = of_constraint.find(constraint.id);
    return found == of_constraint.end() ? Vec3::Zero() : found->second;
  }
};

}  // namespace lappet
