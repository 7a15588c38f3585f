// What a suture or a hook holds: the tissue around its anchor, not a point of it.
//
// A point force on an elastic solid has no finite displacement (Kelvin: it grows as one over the distance), so one that
// acts on a point of the lattice gives way the more the finer the lattice. A stencil takes the mean over what lies
// within kStencilRadius of the anchor instead, by the weights of moving least squares (Lancaster and Salkauskas 1981)
//   w_n = m_n k(r_n) p(x_n)^T A^-1 p(x_0),  A = sum_n m_n k(r_n) p(x_n) p(x_n)^T,  p = (1, x - x_0),  k = 1 -
//   (r/kStencilRadius)^2
// with the tissue m_n that each node carries: they sum to one and hold x_0 at rest and in every affine motion of it.
// Nodes come from cells that hang together by whole faces with the anchor's own cell: never from across a cut. Where
// cells are as large as the radius, one cell's trilinear weights do.
#pragma once
#include <cstdint>
#include <vector>

#include "lattice/lattice.h"

namespace lappet {

// A chosen measure, not a fitted one: a suture gathers about a millimeter of tissue around its thread and the tine of a
// skin hook is about as long. One trilinear cell of 1 mm gives a little more: two hooks that lift a rhomboid flap take
// 13 % more energy with stencils in cells of 0.5 mm than at 1 mm, and 23 % less when held at points there.
inline constexpr double kStencilRadius = 1.0;  // mm
// No needle takes more of thin or small tissue: the largest radius over the thinnest side of the box around it.
inline constexpr double kStencilShare = 0.5;

struct AnchorStencil {
  std::vector<Index> nodes;     // distinct
  std::vector<double> weights;  // sum to one; the first moment is the anchor's
};

// reach: mm.
AnchorStencil anchor_stencil(const Lattice& lattice, const EmbeddedPoint& anchor, double reach = kStencilRadius);

// The trilinear weights of a point as they are.
AnchorStencil point_stencil(const Lattice& lattice, const EmbeddedPoint& anchor);

}  // namespace lappet
