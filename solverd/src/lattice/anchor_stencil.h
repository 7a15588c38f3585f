// What a suture or a hook holds: the tissue around its anchor, not a point of it.
//
// A point force on an elastic solid has no finite displacement (Kelvin: it grows as one over the distance), so one that
// acts on a point of the lattice gives way the more the finer the lattice, and by where in its cell the point lies. A
// stencil takes a mean over the tissue within kStencilRadius of the anchor instead, with the weight of moving least
// squares (Lancaster and Salkauskas 1981)
//   q(x) = k(|x - x_0|) p(x)^T A^-1 p(x_0),  A = integral of k p p^T,  p = (1, x - x_0),  k = 1 - (r/kStencilRadius)^2,
//   w_n = integral of q N_n,  N_n the trilinear function of node n,
// so that it holds x_0 at rest and in every affine motion. What is integrated over is the tissue seen from the anchor:
// rays end at the surface, so nothing outside the tissue and nothing across a cut takes part. Neither the rays nor q
// know the lattice: it is one definition for every spacing and every place of the lattice.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lattice/lattice.h"

namespace lappet {

// A chosen measure, not a fitted one: a suture gathers about a millimeter of tissue around its thread and the tine of a
// skin hook is about as long.
inline constexpr double kStencilRadius = 1.0;  // mm
// No needle takes more of thin or small tissue: the largest radius over the thinnest side of the box around it.
inline constexpr double kStencilShare = 0.5;
inline constexpr double kOneFace = 0.9;  // cosine between normals of triangles that count as one face

struct AnchorStencil {
  std::vector<Index> nodes;     // distinct, in order
  std::vector<double> weights;  // sum to one; the first moment is the anchor's
};

// How much of what two stencils hold is the same, from 0 to 1: where a suture's ends lie on either side of a cut that
// ends in the middle of a cell, the lattice does not part them, and the force between them is that cell's own.
double shared_hold(const AnchorStencil& a, const AnchorStencil& b);

// The trilinear weights of a point as they are.
AnchorStencil point_stencil(const Lattice& lattice, const EmbeddedPoint& anchor);

// Makes the stencils of one lattice.
class AnchorStencils {
 public:
  // surface: the one that the lattice was built from. Keeps references to both. radius: mm.
  AnchorStencils(const Lattice& lattice, const Surface& surface, double radius);

  // Of a rest point inside the tissue or on its surface; the triangle of the surface nearest to it. beyond: from the
  // anchor to the point that the stencil holds, mm, as if the tissue went on as it is about the anchor.
  AnchorStencil around(const Vec3& anchor, Index triangle, const Vec3& beyond = Vec3::Zero()) const;
  // The faces of the surface that an anchor lies below, within the radius, of those that look about the same way the
  // nearest.
  struct Facing {
    Vec3 normal;   // outwards, at rest
    double depth;  // of the anchor, mm
    Index triangle;
  };
  std::vector<Facing> faces_above(const Vec3& anchor) const;
  double radius() const { return radius_; }

 private:
  // A part of the tissue around an anchor: a point of a cell, and how much it weighs.
  struct Sample {
    Vec3 point;
    Index cell;
    double weight;
  };
  // A triangle near an anchor.
  struct Wall {
    Vec3 corner, first, second, normal;  // a corner, the edges from it; unit length
    Index triangle;
  };
  using Box = std::array<float, 6>;  // lowest and highest corner

  std::vector<Wall> walls_near(const Vec3& point, double reach) const;
  Vec3 viewpoint(const Vec3& anchor, std::span<const Wall> walls) const;
  std::vector<Sample> seen_from(const Vec3& eye, const Vec3& normal, std::span<const Wall> walls) const;
  Index cell_of(const Vec3& point, std::span<const Wall> walls) const;

  const Lattice& lattice_;
  const Surface& surface_;
  double radius_;
  std::vector<Box> boxes_;  // per triangle
};

}  // namespace lappet
