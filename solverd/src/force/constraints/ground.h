// The ground that undermined tissue lies on: the underside of the tissue before any cut, as a sheet that stays where it
// is. Undermined faces may lift off it and slide along it, but where they sink into it the bed pushes back.
//
// Its height is a signed distance (force/constraints/signed_distance.h) to the body below the sheet, so that a force
// made of it belongs to an energy, and tissue that slides over a curved sheet follows it.
#pragma once
#include "force/constraints/signed_distance.h"

namespace lappet {

class Ground {
 public:
  // sheet: triangles whose normals point out of the tissue, into the ground. spacing: of the lattice, mm. Throws
  // RefusedError like SignedDistance.
  Ground(const Surface& sheet, double spacing, std::size_t memory_budget, const Interrupt& interrupt = {});

  // The height of a point above the ground, mm, and its gradient; zero gradient where the ground is out of reach.
  SignedDistance::Sample height(const Vec3& point) const { return distance_.at(point); }
  std::size_t bytes() const { return distance_.bytes(); }

 private:
  SignedDistance distance_;
};

// The closed body of a thickness below a sheet.
Surface body_below(const Surface& sheet, double thickness);

}  // namespace lappet
