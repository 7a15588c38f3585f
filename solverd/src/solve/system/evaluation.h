// What is found at a state of displacements. Whoever asked for it holds it and passes it on to what needs it.
#pragma once
#include <cstdint>
#include <vector>

#include "force/constraints/contact.h"
#include "force/constraints/contact_penalty.h"
#include "force/constraints/loaded_faces.h"
#include "force/constraints/point_constraint.h"
#include "force/self_contact/self_contact.h"

namespace lappet {

struct EvaluationSummary {
  double energy = 0.0;
  double residual = 0.0;           // 2-norm of the force on free nodes, mN
  double force_scale = 0.0;        // 2-norm of the elastic nodal force magnitudes plus a floor, mN
  double relative_residual = 0.0;  // their quotient, or that of a cluster of nodes if larger (residual_clusters.h)
  double minimum_j = 1.0;
  std::int32_t inverted = 0;
};

struct Evaluation : EvaluationSummary {
  std::vector<double> gradient;                   // 3 per node; 0 where a node is not free
  std::vector<double> holding;                    // 3 per prescribed node: the force that holds it there, mN
  std::vector<ContactPenalty> contact_penalties;  // what the bed and the bones push with
  PointTangent point_tangent;                     // of the point constraints
  std::vector<FaceMotion> pressed;                // of the samples of faces under pressure
  double pressure_energy = 0.0;                   // theirs, part of `energy` (solve/system/loads.cpp)
  ContactState contact;                           // what the bones do
  SelfContactState self_contact;                  // what the surface does to itself
  std::uint64_t number = 0;                       // of the system's evaluations: see System::linearize
};

}  // namespace lappet
