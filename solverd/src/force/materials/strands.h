// Muscles in the tissue: strands of fibers that run from an origin to an insertion, each a sweep along a curve.
//
// A strand is all that lies nearer to its curve c(s) than its radius r(s), both linear between its points. Its fibers
// keep their place in the cross-section: x(s) = c(s) + rho r(s) e with rho e constant, so at x they run along
// c' + r'/r (x - c), and come together where the strand tapers to a tendon.
#pragma once
#include <span>
#include <vector>

#include "force/materials/material_parameters.h"
#include "lattice/lattice.h"

namespace lappet {

struct Strand {
  std::int32_t material = 0;  // index into the table
  std::vector<Vec3> points;   // mm, at least two
  std::vector<double> radii;  // mm, one per point
};

// Where a point lies in a strand.
struct InStrand {
  double share = 0.0;         // of the radius there: 0 on the curve, 1 at the strand's surface
  Vec3 fiber = Vec3::Zero();  // unit
};

InStrand in_strand(const Strand& strand, const Vec3& point);

// Gives each cell whose middle a strand holds the strand's material and its fibers' direction, in place of what it had;
// of several strands the one in which it lies deepest.
void lay_strands(const Lattice& lattice, std::span<const Strand> strands, CellMaterials& materials,
                 const Interrupt& interrupt = {});

}  // namespace lappet
